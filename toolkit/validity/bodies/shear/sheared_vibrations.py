"""Frequencies that Euler-Bernoulli elements make too high, because they know no shear: by those of the same scene with elements that do.

A bending wave of the wave number k is too fast by (k r)^2 E / (2 kappa G) in the first order, r^2 = I / A, and k^2 r = omega sqrt(m / E A).
Where that is small for all bodies nothing is computed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import scipy

from toolkit.foundation.units import unit
from toolkit.foundation.verdict import Caution, check
from toolkit.responses.pencil import free_pencil, real_pencil
from toolkit.responses.vibration import any_pencil_of
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.flexible_bodies import deforming, elastic_coordinates, flexible_body, is_in_pieces
from toolkit.system.solution import Solution
from toolkit.validity.bodies.beam_assumptions import beams_of
from toolkit.validity.bodies.chains.known_chain import chain
from toolkit.validity.bodies.deformation import LIMIT, whole_bodies
from toolkit.validity.bodies.shear.soft_elements import STIFF, SoftElements, soft_elements

WAVES = 3.0
"""Factor by which vibrations between supports may have a larger error than a free wave."""
STEP = 1e-2
"""Relative change of the shear for the derivative by the thickness."""
NAMED = 3
"""Largest number of vibrations that are named."""


class Raised(NamedTuple):
    """Relative errors of one frequency, and of its derivative by the thickness of all beams."""

    value: float
    derivative: float

    def counts(self, differentiated: bool) -> bool:
        """Whether an error of those that are asked for exceeds `LIMIT`."""
        return self.value > LIMIT or (differentiated and self.derivative > LIMIT)


@check("shear")
def sheared_vibrations(solution: Solution, asked: Mapping[str, float], differentiated: bool) -> Iterator[Caution]:
    """Doubts about frequencies, by name, in cycles per time, that shear makes lower.

    Parameters
    ----------
    differentiated
        Whether their derivatives are asked for, too.
    """
    found = raised_by_stiff_shear(solution, asked, differentiated)
    high = {name: each for name, each in found.items() if each.counts(differentiated)}
    if not high:
        return
    first = list(high.items())[:NAMED]
    if (worst := max(high, key=lambda name: high[name].value)) not in dict(first):
        first[-1] = worst, high[worst]
    label = unit(solution.system.scene.units, "rate")
    told = [f"{name} of {asked[name]:.5g} {label} by some {_words(each, differentiated)}" for name, each in first]
    more = f" and {len(high) - len(first)} more" if len(high) > len(first) else ""
    yield sheared_vibrations.caution(
        f"Euler-Bernoulli beams leave shear out, so that frequencies of short waves are too high: {', '.join(told)}{more}. "
        "Fix: a frame with shear = true, or a body of solid elements.",
    )


def _words(found: Raised, differentiated: bool) -> str:
    return f"{found.value:.1%}" + (f" (its derivative by a thickness by {found.derivative:.0%})" if differentiated else "")


def raised_by_stiff_shear(solution: Solution, asked: Mapping[str, float], differentiated: bool) -> dict[str, Raised]:
    """Errors of those frequencies in which shear might count, by name."""
    scene, times = solution.system.scene, 1 + differentiated
    part = times * WAVES * max((_slowness(scene, name) for name in whole_bodies(scene) if asked), default=0.0)
    short = {name: value for name, value in asked.items() if part * value > LIMIT}
    return _raised(solution, short) if short else {}


def _slowness(scene: ResolvedScene, name: str) -> float:
    """Relative error of a free bending wave per cycle per time; zero where there are no beams."""
    behind = None if is_in_pieces(scene, name) else chain(scene, name)
    if behind is None:
        return 0.0
    found = beams_of(behind)
    (mass,) = flexible_body(scene, name).some_invariants(scene, "mass")
    per_stretch = float(np.real(mass)) / float(found.axial @ found.lengths)  # m / E A
    return float(np.pi * STIFF * np.sqrt(per_stretch * found.gyration.max()))


def _raised(solution: Solution, asked: Mapping[str, float]) -> dict[str, Raised]:
    """Errors of frequencies, from the vibrations with shear that are most alike.

    These are scaled by the mass, so that their products with each other tell.
    """
    weights = solution.system.weights[: solution.system.n_q]
    motions, reduced = free_pencil(weights, real_pencil(any_pencil_of(solution)))
    soft = _soft_bodies(solution, motions)
    stiffness, mass = ((each + each.T) / 2 for each in (reduced.stiffness, reduced.mass))
    try:
        known, more, most = (
            scipy.linalg.eigh(stiffness - sum(each.lost(factor) for each in soft), mass) for factor in (0.0, 1.0, 1 + STEP)
        )
    except scipy.linalg.LinAlgError:
        return {}
    alike = [np.abs(each[1].T @ mass @ known[1]).argmax(axis=0) for each in (more, most)]
    squares = [known[0], *(each[0][where] for each, where in zip((more, most), alike, strict=True))]
    values = [np.sqrt(np.maximum(each, 0.0)) / (2 * np.pi) for each in squares]
    return {name: _of(values, int(np.abs(values[0] - value).argmin())) for name, value in asked.items()}


def _of(values: list[np.ndarray], k: int) -> Raised:
    """Errors of frequency k, from those without shear, with it, and with more of it.

    Shear goes with the square of the thickness.
    """
    known, true, softer = (float(each[k]) for each in values)
    if not true > 0:
        return Raised(np.inf, np.inf) if known > 0 else Raised(0.0, 0.0)
    slope = 1 + 2 * np.log(softer / true) / np.log1p(STEP) if softer > 0 else 0.0
    return Raised(known / true - 1, known / (true * slope) - 1 if slope > 0 else np.inf)


def _soft_bodies(solution: Solution, motions: np.ndarray) -> list[SoftElements]:
    """Shear of the elements of all beams, on the motions that joints allow."""
    found = []
    for name in deforming(solution.system.scene):
        behind = None if is_in_pieces(solution.system.scene, name) else chain(solution.system.scene, name)
        if behind is not None:
            found.append(soft_elements(behind, motions[elastic_coordinates(solution, name)]))
    return found
