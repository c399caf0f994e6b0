"""Changes of the frequencies and damping ratios that responses ask for, by shapes that were left out."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.verdict import Caution
from toolkit.responses.vibration import DampingRatio, OfVibration, any_pencil_of
from toolkit.system.solution import Solution
from toolkit.validity.bodies.reduced.full_scene import reduced_bodies
from toolkit.validity.bodies.reduced.raised_frequencies import DOUBTFUL, TOLD
from toolkit.validity.bodies.reduced.richer_pencil import richer_pencil

UNDAMPED = 1e-9
"""Damping ratio that is round-off."""
HELD = 1e-6
"""Part of the fastest vibration below which a vibration is round-off: a motion that nothing holds."""
NEAR, LEFT = 0.01, 3e-4
"""Parts of a frequency by which two vibrations differ at most that may change places, if it is off by as much; and which it may always be
off by, see `richer_pencil`."""


def changed_vibrations(solution: Solution) -> dict[str, float]:
    """Response -> relative error of its vibration by left-out shapes; empty where nothing is reduced, without undamped ones.

    Of vibrations that are so close to each other that they may change places, the largest of their errors counts.
    """
    scene, n_q = solution.system.scene, solution.system.n_q
    asked = {name: each for name, each in scene.responses.items() if isinstance(each, OfVibration)}
    asked = {name: each for name, each in asked.items() if not (solution.steps and each.needs_rest)}
    if not asked or not reduced_bodies(scene):
        return {}
    pencil, weights = any_pencil_of(solution), solution.system.weights[:n_q]
    found = {name: each.vibrations(solution, pencil, weights)[each.number - 1] for name, each in asked.items()}
    richer = richer_pencil(solution, max(map(abs, found.values())))
    told = {name: _part(each, found[name], each.vibrations(solution, *richer)) for name, each in asked.items()}
    return {name: part for name, part in told.items() if not np.isnan(part)}


def _part(response: OfVibration, s: complex, true: np.ndarray) -> float:
    """Relative error of the number from s, against those near its place among the true ones; the largest counts.

    It is nan where both are zero, and inf where only the true numbers are, or where there is none of its place.
    """
    if response.number > len(true):
        return np.inf
    wanted = true[response.number - 1]
    reach = np.clip(abs(s - wanted), LEFT * abs(wanted), NEAR * abs(wanted))
    numbers = np.array([response.of(each) for each in true[np.abs(true - wanted) <= reach]])
    zero = UNDAMPED if isinstance(response, DampingRatio) else HELD * np.abs(true).max() / (2 * np.pi)
    value = response.of(s)
    if np.abs(numbers).min() <= zero:
        return np.nan if abs(value) <= zero else np.inf
    parts = (value - numbers) / np.abs(numbers)
    return float(parts[np.argmax(np.abs(parts))])


def cautions_of_changed(solution: Solution) -> Iterator[Caution]:
    """A caution about all responses whose vibrations left-out shapes change by much."""
    parts = {name: part for name, part in changed_vibrations(solution).items() if abs(part) > TOLD}
    if parts:
        yield Caution(
            "left-out-shapes",
            "the parts of cut bodies keep some of their modes (modes_per_frame), which changes "
            f"{', '.join(f'{name} by about {part:+.1%}' for name, part in parts.items())}. Write larger numbers, or leave them out.",
            doubt=bool(max(map(abs, parts.values())) > DOUBTFUL),
        )
