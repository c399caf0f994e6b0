"""By how much shapes that were left out change the frequencies and damping ratios that responses ask for."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.verdict import Caution
from toolkit.responses.vibrations.pencil import pencil_of
from toolkit.responses.vibrations.roots import Vibration
from toolkit.responses.vibrations.vibration import DampingRatio, OfVibration
from toolkit.system.solution import Solution
from toolkit.validity.bodies.reduced.full_scene import reduced_bodies
from toolkit.validity.bodies.reduced.raised_frequencies import DOUBTFUL, TOLD, root_changes

UNDAMPED = 1e-9
"""Damping ratio that is round-off."""


def changed_vibrations(solution: Solution) -> dict[str, float]:
    """Response -> part of its value by which it is too large, of an equilibrium at rest; empty of other states, without what is
    not damped."""
    scene, n_q = solution.system.scene, solution.system.n_q
    asked = {name: each for name, each in scene.responses.items() if isinstance(each, OfVibration)}
    if not asked or solution.steps or solution.spins or not reduced_bodies(scene):
        return {}
    pencil = pencil_of(solution)
    found = [each.about_rest(solution, pencil) for each in asked.values()]
    right, left = (np.array([_vectors(of)[side][:n_q] for of in found]).T for side in range(2))
    damped = np.array([each.counted(np.ones((1, 1)))[0, 0] for each in asked.values()])
    changes = root_changes(solution, np.array([each.s for each in found]), right, left, damped)
    return {
        name: -float(each.slope(of.s, ds)) / value
        for (name, each), of, ds in zip(asked.items(), found, changes, strict=True)
        if abs(value := each.of(of.s)) > (UNDAMPED if isinstance(each, DampingRatio) else 0.0)
    }


def _vectors(found: Vibration) -> tuple[np.ndarray, np.ndarray]:
    """u and w; of a vibration with a twin some real motion, because vectors of the two need not belong together."""
    if found.alone:
        return found.right, found.left
    motion = np.real(found.right / found.right[np.argmax(np.abs(found.right))])
    return motion, motion


def cautions_of_changed(solution: Solution) -> Iterator[Caution]:
    """All responses that lack much."""
    parts = {name: part for name, part in changed_vibrations(solution).items() if abs(part) > TOLD}
    if parts:
        yield Caution(
            "left-out-shapes",
            "the parts of cut bodies keep some of their modes (modes_per_frame), which changes "
            f"{', '.join(f'{name} by about {part:+.1%}' for name, part in parts.items())}. Write larger numbers, or leave them out.",
            doubt=bool(max(map(abs, parts.values())) > DOUBTFUL),
        )
