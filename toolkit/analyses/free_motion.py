"""Free motions as states that can be drawn: the given positions, and each motion that nothing holds.

Each motion moves its bodies by a tenth of the model size.
"""

from __future__ import annotations

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.mode_shapes import told_apart
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.solvers.static.loose import loose_motions
from toolkit.system.solution import Solution
from toolkit.system.system import System

FAR = 0.1
"""Distance that a motion is drawn by, in parts of the model size or rad."""


def free_motion_states(system: System, frames: int = 1) -> Solution:
    """The given positions, and behind them those moved along every free motion; each with its name.

    Where several motions are free, each mixture of them is free too: they are told apart as modes of equal frequency are.

    Parameters
    ----------
    frames : states of every motion: the farthest alone, or a whole number of fours for a swing there, back, to the other side and home

    Raises
    ------
    InputError
        Joints and stiffness hold every body.
    """
    motions = loose_motions(system, system.scene.solver)
    count, n_q = motions.shape[1], system.n_q
    if not count:
        raise InputError("nothing can move freely: joints and stiffness hold every body. Leave --free-motions out.")
    weights = system.weights[: system.n_b]
    shapes = told_apart(np.zeros(count), motions, weights)
    shapes = FAR * shapes / (weights[:, None] * np.abs(shapes)).max(axis=0)
    swing = np.sin(2 * np.pi * np.arange(1, frames + 1) / frames) if frames > 1 else np.ones(1)
    q = np.tile(np.real(system.undeformed()[0][:n_q]), (1 + count * frames, 1))
    q[1:, : system.n_b] += np.kron(shapes.T, swing[:, None])
    rest, force = np.zeros_like(q), np.zeros((len(q), system.n - n_q))
    design = (*q.shape, system.n_x)
    names = ("as given", *(f"free motion {k + 1} of {count}" for k in range(count) for _ in range(frames)))
    nothing, no_force = np.zeros(design), np.zeros((*force.shape, system.n_x))
    times = np.arange(float(len(q)))
    return Solution(system, times, q, rest, rest, force, nothing, nothing, nothing, no_force, judge=_judged, names=names)


def farthest(solution: Solution, frames: int) -> list[float]:
    """Times of the given positions and of the farthest state of every motion of `free_motion_states`."""
    return [float(solution.times[0]), *map(float, solution.times[max(frames // 4, 1) :: frames])]


def _judged(_solution: Solution) -> Verdict:
    text = "these are motions that nothing resists while there are no loads, each a tenth of the model size or rad far."
    return Verdict.of([Caution("free-motions", text, doubt=False)])
