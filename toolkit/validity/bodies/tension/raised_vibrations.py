"""Frequencies that the tension of bodies raises, which the equations do not know.

Vibrations with the stiffness K + T, T of `stiffened_state`, against those with K, number by number.
"""

from __future__ import annotations

import numpy as np

from toolkit.responses.vibrations.pencil import real_pencil
from toolkit.responses.vibrations.roots import free_pencil
from toolkit.responses.vibrations.vibration import any_pencil_of
from toolkit.solvers.roots import undamped_rates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.tension.stiffened_bodies import pulled_bodies, stiffened_states
from toolkit.validity.bodies.tension.stiffened_state import StiffenedState, stiffened_state

SLOW = 1e-9
"""Part of the largest squared frequency below which one is the round-off of a motion that nothing holds."""


def raised_by_tension(solution: Solution) -> np.ndarray:
    """True frequency over that of the equations, of all vibrations about the last state from the slowest on; empty without tension."""
    state = _last(solution)
    if state is None:
        return np.zeros(0)
    weights = solution.system.weights[: solution.system.n_q]
    pencil = real_pencil(any_pencil_of(solution))
    motions, reduced = free_pencil(weights, pencil)
    more = motions.T @ np.array([state.adds(each) for each in motions.T]).T
    one, other = (undamped_rates(each, reduced.mass) for each in (reduced.stiffness, reduced.stiffness + more))
    fast = one**2 > SLOW * np.max(one, initial=0.0) ** 2
    found: np.ndarray = np.divide(other, one, out=np.ones(len(one)), where=fast)
    return found


def _last(solution: Solution) -> StiffenedState | None:
    """The last state of a solution, if tension counts in it."""
    last = len(solution.times) - 1
    states = stiffened_states(solution)
    found = next((each for each in states if each.instant == last), None)
    return stiffened_state(solution, pulled_bodies(solution), last) if states and found is None else found
