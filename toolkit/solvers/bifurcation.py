"""Where on its way an equilibrium lost its stability although the load went on: a bifurcation."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from toolkit.errors import BifurcationError, ConvergenceError
from toolkit.run_options import RunOptions
from toolkit.solvers.critical_state import is_stable, soft_motion
from toolkit.solvers.equilibrium import Equilibrium, find_equilibrium
from toolkit.solvers.load_step import load_step
from toolkit.static_path import StaticPath
from toolkit.system import System

NEAR = 1e-6
"""How far, in parts of the scene's size (or rad), Newton may move an equilibrium that was found before."""
HALVINGS = 20
"""Of a load step: the critical load to a millionth of it."""


def bifurcation(system: System, options: RunOptions, path: StaticPath) -> BifurcationError | None:
    """The error that names critical load and motion, if the path is unstable somewhere before its first limit point.

    At a limit point the stiffness vanishes against a motion on which the load does work, so that the load turns back. Where it vanishes
    while the load goes on, the load does no work on the motion: other branches of equilibria begin there.
    """
    end = path.limit_points[0].place if path.limit_points else len(path.q)
    visited = [(float(path.load_factors[k]), _found_again(system, options, path, k)) for k in range(end)]
    for (low, before), (high, after) in pairwise(visited):
        if not is_stable(system, options, after, high):
            return _error(system, *_bisect(system, options, before, low, high))
    return None


def _found_again(system: System, options: RunOptions, path: StaticPath, place: int) -> Equilibrium:
    """A point of the path with its tangent."""
    q: np.ndarray = np.append(path.q[place], np.zeros(system.n - system.n_q)).astype(system.dtype)
    acc: np.ndarray = np.append(np.zeros(system.n_q), path.multipliers[place]).astype(system.dtype)
    return find_equilibrium(system, options, float(path.load_factors[place]), q, acc, NEAR)[0]


def _bisect(system: System, options: RunOptions, state: Equilibrium, low: float, high: float) -> tuple[float, np.ndarray]:
    """Critical load factor, and the motion without stiffness."""
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        try:
            trial = load_step(system, options, state, low, middle)[0]
        except ConvergenceError:  # the matrix is singular there: this is the place
            high = middle
            continue
        if is_stable(system, options, trial, middle):
            low, state = middle, trial
        else:
            high = middle
    return low, soft_motion(system, options, state, low)


def _error(system: System, factor: float, motion: np.ndarray) -> BifurcationError:
    coordinate = system.most_moved(motion)
    return BifurcationError(
        f"the equilibrium is unstable beyond a bifurcation (buckling) at {100 * factor:.6g} % of the load: the load does no work on a "
        f"motion of {coordinate}, which loses its stiffness there, and the smallest disturbance sets it off. Use less "
        "load, add stiffness there, or follow the motion with a transient run from a slightly disturbed start.",
        factor,
        coordinate,
    )
