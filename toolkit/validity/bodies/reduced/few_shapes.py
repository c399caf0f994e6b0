"""Frequencies that a reduced basis has too few shapes for.

The shapes that a basis leaves out vibrate with omega_l or faster, and bend against none that it keeps: u^T K u_l = 0. So with the motion
u of the kept ones Rayleigh's quotient is at least

    (omega_k^2 m + omega_l^2 m_l) / (sqrt(m) + sqrt(m_l))^2 >= 1 / (1 / omega_k^2 + 1 / omega_l^2)

and by the minimum over subspaces the true frequency of the same number is not below this (in the way of S. Dunkerley, Phil. Trans. R. Soc.
185 (1894) 279), as long as joints and springs grip where the left out shapes stand still. Where numbers of the body are others than
those of its file, omega_l is taken to change as the slowest vibration of the kept shapes does.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import scipy

from toolkit.bodies.body import CENTRE
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import Caution
from toolkit.loads.load import Load
from toolkit.reduced_model.model import MEAN_AXES
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.flexible_bodies import flexible_body
from toolkit.system.solution import Solution
from toolkit.validity.bodies.deformation import whole_bodies
from toolkit.validity.bodies.reduced.frozen_bases import frozen_bodies
from toolkit.validity.bodies.reduced.gripped_vibrations import raised_by_grips
from toolkit.validity.bodies.reduced.raised_frequencies import DOUBTFUL, TOLD, listed_parts

ENOUGH = float(np.sqrt((1 + TOLD) ** 2 - 1))
"""Frequency, relative to the slowest one left out, that may be too high by `TOLD`."""

OF_GRADIENTS = 0.02
"""Relative error of a frequency from which its derivative may be off by a tenth: by a thickness, by up to five times as much."""
BETTER = 'Build it with kind = "craig-bampton", whose shapes know its interface points.'
"""Remedy where the basis holds eigenmodes alone."""


class FewShapes(NamedTuple):
    """Slowest frequency that the basis of one body leaves out, in cycles per time; nan if it is not known, with the reason."""

    body: str
    slowest: float
    why: str = ""
    gripped: str = ""  # points that move in shapes which are left out, where these are known


def cautions_of_few_shapes(
    solution: Solution, frequencies: Mapping[str, float], doubt: bool, differentiated: bool
) -> Iterator[Caution]:
    """Cautions about frequencies, by name, that a basis may make too large, and about bodies where the error is not known."""
    scene = solution.system.scene
    vibrating = {name: abs(value) for name, value in frequencies.items() if value}
    if not vibrating:
        return
    label, found = unit(scene.units, "rate"), [*left_out(scene)]
    gripped = [each for each in found if each.gripped]
    if gripped:
        found = [each for each in found if not each.gripped]
        yield from _of_gripped(solution, vibrating, gripped, doubt, differentiated)
    for each in found:
        if np.isnan(each.slowest):
            yield Caution(
                "left-out-shapes", f"how much too high frequencies are where {each.body} vibrates is not known: {each.why}", doubt
            )
    known = [each for each in found if not np.isnan(each.slowest)]
    least = min(known, key=lambda each: each.slowest, default=None)
    if least is None:
        return
    parts = {name: raised_at_most(value, least.slowest) for name, value in vibrating.items()}
    high = {name: part for name, part in parts.items() if part > TOLD}
    if high:
        yield Caution(
            "left-out-shapes",
            f"frequencies may be too high where {least.body} vibrates, {listed_parts(high, 'up to')}: its basis leaves out shapes that "
            f"vibrate from {least.slowest:.4g} {label} on. Others are so by less than {TOLD:.0%}. Build it with "
            "more modes, or in more pieces: what is left out from "
            f"{1 / ENOUGH:.0f} times a frequency on makes it {TOLD:.0%}.",
            doubt and max(high.values()) > DOUBTFUL,
        )


def _of_gripped(
    solution: Solution, frequencies: Mapping[str, float], gripped: list[FewShapes], doubt: bool, differentiated: bool
) -> Iterator[Caution]:
    """Cautions about frequencies raised by bodies that joints or springs hold where left-out shapes move."""
    parts = raised_by_grips(solution, frequencies, {each.body: each.slowest for each in gripped})
    where = ", ".join(f"{each.body} at {each.gripped}" for each in gripped)
    if parts is None:
        yield Caution(
            "left-out-shapes",
            f"how much too high frequencies are is not known: joints or springs hold {where}, which moves in shapes that its basis leaves "
            f"out. {BETTER}",
            doubt,
        )
        return
    high = {name: part for name, part in parts.items() if part > TOLD}
    if high:
        slopes = " Derivatives are off by up to five times as much." if differentiated else ""
        yield Caution(
            "left-out-shapes",
            f"frequencies are too high, {listed_parts(high, 'about')}: joints or springs hold {where}, which moves in shapes that its "
            f"basis leaves out. Others are so by less than {TOLD:.0%}.{slopes} {BETTER}",
            doubt and max(high.values()) > (OF_GRADIENTS if differentiated else DOUBTFUL),
        )


def raised_at_most(frequency: float, slowest: float) -> float:
    """Largest relative error of a frequency where the slowest vibration left out is known."""
    return float(np.sqrt(1 + (frequency / slowest) ** 2) - 1)


def left_out(scene: ResolvedScene) -> Iterator[FewShapes]:
    """Slowest left-out frequency of all bodies whose model does not keep all coordinates, cut or not.

    Bodies of frozen shapes away from their design are not among them: what these leave out are no shapes of their design, so that
    the bound does not hold. `basis_errors` measures what they lack.
    """
    off = {each.name for each in frozen_bodies(scene)}
    for name in whole_bodies(scene):
        model = flexible_body(scene, name).design_point(scene).model
        if model.keeps_all or name in off:
            continue
        if not model.left_out:
            yield FewShapes(
                name, np.nan, f"{model.label} does not say what its basis leaves out. Build it again with ffrf-preprocess."
            )
        elif pulled := _pulled(scene, name, "interface" in model.left_out):
            at = ", ".join(pulled)
            if CENTRE not in pulled and flexible_body(scene, name).design_point(scene, "left_out_shapes").model.left_out_shapes:
                yield FewShapes(name, min(model.left_out.values()) * _speeded(scene, name), gripped=at)
                continue
            better = "Hold it at interface points, whose motions its basis knows." if "interface" in model.left_out else BETTER
            yield FewShapes(
                name, np.nan, f"its basis leaves out shapes that move where joints or springs hold it, at {at}. {better}"
            )
        elif "interface" in model.left_out or _coupled(scene, name):
            yield FewShapes(name, min(model.left_out.values()) * _speeded(scene, name))


def _coupled(scene: ResolvedScene, body: str) -> bool:
    """Whether inertia couples shapes that are left out with the frame's motion or kept shapes.

    It does not where the frame stands still, nor of free modes about mean axes, which float by themselves, at the numbers that
    they were found with.
    """
    written = flexible_body(scene, body)
    design = written.design_point(scene)
    nominal = design.model.invariants
    same = all(np.array_equal(np.real(design.value(name)), each) for name, each in vars(nominal).items())
    return bool(written.frame_size) and not (design.model.reference_condition == MEAN_AXES and same)


def _pulled(scene: ResolvedScene, body: str, held: bool) -> list[str]:
    """Points at which joints or springs hold a body, and which left-out shapes may move."""
    springs = [load for load in scene.loads.values() if isinstance(load, Load) and not load.proportional]
    grips = {grip for each in (*scene.joints.values(), *springs) for grip in each.grips}
    gripped = {point for name, point in grips if name == body}
    if held:
        return sorted(gripped & {CENTRE})
    written = flexible_body(scene, body)
    moves = {point: written.point(scene, point, body) for point in gripped}
    return sorted(point for point, (place, turn) in moves.items() if np.any(place[..., 1:]) or np.any(turn[..., 1:]))


def _speeded(scene: ResolvedScene, body: str) -> float:
    """Slowest vibration of the kept shapes at the scene's numbers, relative to that at the nominal design.

    The vibrations of the shapes left out are taken to change alike.
    """
    design = flexible_body(scene, body).design_point(scene)
    nominal = design.model.invariants
    here = type(nominal)(**{name: design.value(name) for name in vars(nominal)})
    slowest = [_slowest(inv.stiffness, inv.inertia_about_origin[1:, 1:]) for inv in (here, nominal)]
    return float(np.sqrt(slowest[0] / slowest[1]))


def _slowest(stiffness: np.ndarray, mass: np.ndarray) -> float:
    last = len(stiffness) - 1
    found: np.ndarray = scipy.linalg.eigvalsh(np.real(mass), np.real(stiffness), subset_by_index=[last, last])
    return float(1 / found[0])
