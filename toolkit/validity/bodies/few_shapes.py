"""Frequencies that a reduced basis has too few shapes for, and bases that are frozen while the design changes.

By how much frequencies are too high because a basis leaves out shapes that move where joints and springs hold the body.

Its reduced model tells how far unit loads at rest move these shapes, the compliance C of `LeftOutShapes`. A vibration omega of unit modal
mass puts the amplitudes c on them, at the body's points and by its inertia, so that with the motions C c Rayleigh's quotient is

    omega_true^2 = omega^2 / (1 + x),    x = c^T C c / (omega^2 (1 - (omega / omega_l)^2))

where omega_l is the slowest vibration that is left out: as of springs in a row, one of which was rigid. Of free modes that a pin holds this
is true within 3 %, of some that a clamp holds it is up to 1.8 times too much.

The shapes that a basis leaves out vibrate with omega_l or faster, and bend against none that it keeps: u^T K u_l = 0. So with the motion
u of the kept ones Rayleigh's quotient is at least

    (omega_k^2 m + omega_l^2 m_l) / (sqrt(m) + sqrt(m_l))^2 >= 1 / (1 / omega_k^2 + 1 / omega_l^2)

and by the minimum over subspaces the true frequency of the same number is not below this (in the way of S. Dunkerley, Phil. Trans. R. Soc.
185 (1894) 279), as long as joints and springs grip where the left out shapes stand still. Where numbers of the body are others than
those of its file, omega_l is taken to change as the slowest vibration of the kept shapes does.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy

from toolkit.components.bodies.body import CENTRE, Body
from toolkit.components.bodies.model_body import ModelBody
from toolkit.components.loads.load import Load
from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import Caution
from toolkit.reduced_model.frozen_basis import RICHER_PARTS, RicherModel, is_frozen, richer_model, turns
from toolkit.reduced_model.model import MEAN_AXES, ReducedModel, place_parameter
from toolkit.responses.pencil import Pencil, free_pencil, pencil_of, real_pencil
from toolkit.responses.stress import model_parameter
from toolkit.scene.resolution import ResolvedScene, loaded
from toolkit.scene.scene import Scene
from toolkit.solvers.free_motions import is_symmetric
from toolkit.system.solution import Solution, design_point, flexible_body
from toolkit.validity.bodies.deformation import whole_bodies
from toolkit.validity.bodies.full_scene import DOUBT_PART, REMARK_PART, listed_parts
from toolkit.validity.bodies.missed_statics import amplitudes_of_loads, softer_and_stressed

PARTS = ("affine", "derivatives", *RICHER_PARTS)
MODES_ALONE = "frozen: eigenmodes"
"""Beginning of the name of a basis whose shapes know no interface points."""


@dataclass(frozen=True)
class FrozenBody:
    """A body whose basis is frozen.

    Attributes
    ----------
    model
        Its reduced model, for messages.
    moved
        Parameter that turns its shapes -> its value, and that which the shapes are for; of those whose values differ.
    asked
        Variables that turn its shapes.
    shapes
        How many its basis has, and how many the richer one of its file has; zero if there is none.
    """

    name: str
    model: str
    moved: dict[str, tuple[float, float]]
    asked: tuple[str, ...]
    shapes: tuple[int, int]

    @property
    def known(self) -> bool:
        """Whether the body's file holds it in more shapes."""
        return self.shapes[1] > 0


def frozen_bodies(scene: Scene, variables: Collection[str] = ()) -> list[FrozenBody]:
    """Frozen bodies whose shapes are not for the design of the scene, or that some variables would turn."""
    return [*filter(None, (_frozen(scene, name, body, variables) for name, body in scene.bodies.items()))]


def with_richer_bases(scene: Scene) -> Scene:
    """The scene with more shapes in all frozen bodies whose files hold them."""
    bodies = {
        name: body.model_copy(update={"model": RicherModel(body.model)})
        for name, body in scene.bodies.items()
        if isinstance(body, ModelBody) and _has_more(scene, body)
    }
    return scene.model_copy(update={"bodies": {**scene.bodies, **bodies}})


def _has_more(scene: Scene, body: ModelBody) -> bool:
    return is_frozen(scene.model(body.model)) and scene.model(body.model, *RICHER_PARTS).richer_invariants is not None


def _frozen(scene: Scene, name: str, body: Body, variables: Collection[str]) -> FrozenBody | None:
    if not isinstance(body, ModelBody) or isinstance(body.model, RicherModel) or not is_frozen(scene.model(body.model)):
        return None
    moved, asked = dict(_moved(scene, body)), [*_asked(scene, name, variables)]
    if not moved and not asked:
        return None
    model = scene.model(body.model, *PARTS)
    off = {parameter: each for parameter, each in moved.items() if _turns(model, parameter)}
    turned = tuple(dict.fromkeys(x for x, parameter in asked if _turns(model, parameter)))
    more = 0 if model.richer_invariants is None else richer_model(model).n_f
    return FrozenBody(name, model.label, off, turned, (model.n_f, more)) if off or turned else None


def _moved(scene: Scene, body: ModelBody) -> Iterator[tuple[str, tuple[float, float]]]:
    """Parameters and positions whose values differ from those of the model."""
    model = scene.model(body.model)
    nominal = {place_parameter(name): float(each.arc_length) for name, each in (model.interfaces or {}).items()} | model.nominal
    given = {**body.model_values(), **{place_parameter(name): s for name, s in loaded(scene).arc_lengths(body).items()}}
    for parameter, value in given.items():
        if parameter in nominal and np.real(value) != nominal[parameter]:
            yield parameter, (float(np.real(value)), nominal[parameter])


def _asked(scene: Scene, name: str, variables: Collection[str]) -> Iterator[tuple[str, str]]:
    """Variables with the parameters of the body that they drive."""
    for variable in scene.design_variables(list(variables)) if variables else ():
        for parameter in filter(None, (model_parameter(scene, name, path) for path in variable.paths)):
            yield variable.name, parameter


def _turns(model: ReducedModel, parameter: str) -> bool:
    """Whether a parameter, or the place of an interface point, turns the shapes; few shapes alone may not show it."""
    if parameter in model.nominal:
        return turns(model if model.richer_invariants is None else richer_model(model), parameter)
    return not model.basis.startswith(MODES_ALONE)


LINEAR_AMPLITUDE = 1e-6
"""Size of a vibration, in parts of the model size or rad, over which forces are linear in it to as much."""
COUNTED_INERTIA_PART = 0.9
"""Part of the slowest frequency that is left out up to which its own inertia is counted."""


class Vibrating(NamedTuple):
    """A vibration of unit modal mass: rad per time, coordinates (n_q,) and multipliers."""

    omega: float
    shape: np.ndarray
    multipliers: np.ndarray


def raised_by_grips(
    solution: Solution, frequencies: Mapping[str, float], slowest: Mapping[str, float]
) -> dict[str, float] | None:
    """Parts by which frequencies about the last state are too high, by what they are called; None where that is not known.

    Parameters
    ----------
    frequencies
        In cycles per time; each is that of the vibration which is nearest to it.
    slowest
        Body -> the slowest frequency that its basis leaves out.
    """
    system, n_q = solution.system, solution.system.n_q
    pencil = real_pencil(pencil_of(solution))
    Z, reduced = free_pencil(system.weights[:n_q], pencil)
    known = all(design_point(system.scene, each, "left_out_shapes").model.left_out_shapes is not None for each in slowest)
    if solution.spins or not known or not is_symmetric(reduced.stiffness):
        return None
    squares, shapes = scipy.linalg.eigh(*((each + each.T) / 2 for each in (reduced.stiffness, reduced.mass)))
    rates = np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)
    found = {}
    for name, frequency in frequencies.items():
        k = first_largest(-np.abs(rates - frequency))
        vibrating = _whole(pencil, n_q, 2 * np.pi * float(rates[k]), Z @ shapes[:, k])
        softer = sum(_softer(solution, body, vibrating, frequency / least) for body, least in slowest.items())
        found[name] = float(np.sqrt(1 + softer) - 1)
    return found


def _whole(pencil: Pencil, n_q: int, omega: float, shape: np.ndarray) -> Vibrating:
    left = (pencil.stiffness - omega**2 * pencil.mass)[:n_q, :n_q] @ shape
    return Vibrating(omega, shape, np.linalg.lstsq(pencil.stiffness[n_q:, :n_q].T, -left)[0])


def _softer(solution: Solution, body: str, vibrating: Vibrating, near: float) -> float:
    """x of one body; `near` is the frequency in parts of the slowest that is left out."""
    design = design_point(solution.system.scene, body, "left_out_shapes")
    assert design.model.left_out_shapes is not None
    loads = _amplitudes(solution, body, vibrating)
    compliance = softer_and_stressed(design_point(solution.system.scene, body))[0] * design.model.left_out_shapes.compliance
    return float(loads @ compliance @ loads) / (vibrating.omega**2 * (1 - min(near, COUNTED_INERTIA_PART) ** 2))


def _amplitudes(solution: Solution, body: str, vibrating: Vibrating) -> np.ndarray:
    """Loads c of a body per unit of a vibration, by the states at both of its ends."""
    system, n_q = solution.system, solution.system.n_q
    size = LINEAR_AMPLITUDE / np.abs(system.weights[:n_q] * vibrating.shape).max()
    side = np.array([[size], [-size]])
    options = (solution.options or system.scene.solver).model_copy(update={"quasi_static": False})
    states = {
        "q": solution.q[-1] + side * vibrating.shape,
        "v": np.zeros((2, n_q)),
        "a": -(vibrating.omega**2) * side * vibrating.shape,
        "multipliers": solution.multipliers[-1] + side * vibrating.multipliers,
    }
    ends = replace(solution, times=np.repeat(solution.times[-1:], 2), options=options, **states)
    one, other = amplitudes_of_loads(ends, body, np.arange(2))
    found: np.ndarray = (one - other) / (2 * size)
    return found


ENOUGH = float(np.sqrt((1 + REMARK_PART) ** 2 - 1))
"""Frequency, relative to the slowest one left out, that may be too high by `REMARK_PART`."""

DERIVATIVE_ERROR_LIMIT = 0.02
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
    high = {name: part for name, part in parts.items() if part > REMARK_PART}
    if high:
        yield Caution(
            "left-out-shapes",
            f"frequencies may be too high where {least.body} vibrates, {listed_parts(high, 'up to')}: its basis leaves out shapes that "
            f"vibrate from {least.slowest:.4g} {label} on. Others are so by less than {REMARK_PART:.0%}. Build it with "
            "more modes, or in more pieces: what is left out from "
            f"{1 / ENOUGH:.0f} times a frequency on makes it {REMARK_PART:.0%}.",
            doubt and max(high.values()) > DOUBT_PART,
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
    high = {name: part for name, part in parts.items() if part > REMARK_PART}
    if high:
        slopes = " Derivatives are off by up to five times as much." if differentiated else ""
        yield Caution(
            "left-out-shapes",
            f"frequencies are too high, {listed_parts(high, 'about')}: joints or springs hold {where}, which moves in shapes that its "
            f"basis leaves out. Others are so by less than {REMARK_PART:.0%}.{slopes} {BETTER}",
            doubt and max(high.values()) > (DERIVATIVE_ERROR_LIMIT if differentiated else DOUBT_PART),
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
