"""Doubts about bodies that tension stiffens across itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.responses.pencil import free_pencil, real_pencil
from toolkit.responses.vibration import any_pencil_of
from toolkit.solvers.free_motions import undamped_rates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.lines_on_bodies import asked_vibrations
from toolkit.validity.bodies.cut.more_frames import divided
from toolkit.validity.bodies.deformation import LIMIT
from toolkit.validity.bodies.tension.pulled_joints import pulled_joints
from toolkit.validity.bodies.tension.stiffened_bodies import TooLarge, most_pulled, pulled_bodies, stiffened_states, too_large
from toolkit.validity.bodies.tension.stiffened_state import StiffenedState, stiffened_state

SLOW = 1e-9
"""Part of the largest squared frequency below which a frequency is round-off: a motion that nothing holds."""


def raised_by_tension(solution: Solution) -> np.ndarray:
    """Ratio of true frequencies to those of the equations, for all vibrations around the last state; empty without tension.

    They are in order from the slowest on.
    """
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
    """Last state of a solution, if tension counts in it."""
    last = len(solution.times) - 1
    states = stiffened_states(solution)
    found = next((each for each in states if each.instant == last), None)
    return stiffened_state(solution, pulled_bodies(solution), last) if states and found is None else found


MANY = 20.0
"""Factor by which a number is too large above which a message gives no factor."""
NAMED = 3
"""Largest number of vibrations that are named."""
OF_GRADIENTS = 0.1
"""Relative error of a derivative of a motion above which there is a doubt, as of other errors of gradients."""
GROWS = 3.0
"""Ratio of the error of a deflection's derivative by the load to its own: w (1 + c w^2) = f gives c w^2 and 3 c w^2."""


@check("tension", STATES)
def tension(solution: Solution, lateral: bool = False) -> Iterator[Caution]:
    """Tension stiffens a body across itself, which linear deformations in its own frame do not know.

    Limit: 5 % of a deflection, of a derivative in statics, or of a frequency; a remark where a run with more frames, made for
    gradients, changes no answer by half of that.
    Fix: more floating frames (`frames`).

    Parameters
    ----------
    lateral
        Whether derivatives are asked for that the solution does not hold.
    """
    found = too_large(solution)
    if found is not None and found.part > LIMIT:
        part = found.part / (1 - found.part) if found.part < 1 else np.inf
        yield tension.caution(_too_large(solution, found), body=found.body, part=part)
    elif not solution.steps:
        yield from _of_derivatives(solution, lateral)
    elif found is not None and solution.dq.shape[2] and GROWS * found.part > OF_GRADIENTS:
        yield tension.caution(_steeper(solution, found), body=found.body, part=GROWS * found.part)
    if found is None or found.part <= LIMIT:
        yield from pulled_joints(solution)
    yield from tension_of_vibrations(solution, asked_vibrations(solution))


def _steeper(solution: Solution, found: TooLarge) -> str:
    return (
        f"tension stiffens {found.body} across itself, which these equations do not know: its displacements are {found.part:.1%} too "
        f"large, and as tension grows with their square derivatives by what bends it are off by about {GROWS * found.part:.0%}. "
        f"{_remedy(solution, found.body, GROWS * found.part)}"
    )


def tension_of_vibrations(solution: Solution, asked: Mapping[str, int]) -> Iterator[Caution]:
    """A doubt about vibrations that tension makes faster, from their names and numbers from the slowest on."""
    times = raised_by_tension(solution) if asked and stiffened_states(solution) else np.zeros(0)
    high = {name: float(times[k - 1]) for name, k in asked.items() if k <= len(times) and times[k - 1] > 1 + LIMIT}
    if not high:
        return
    body, highest = most_pulled(solution), max(high.values())
    told = [f"{name} by {1 - 1 / factor:.1%}" for name, factor in list(high.items())[:NAMED]]
    more = f" and {len(high) - NAMED} more" if len(high) > NAMED else ""
    yield tension.caution(
        f"tension stiffens {body} across itself, which makes vibrations faster than these equations say: {', '.join(told)}{more} too slow. "
        f"Their derivatives by what pulls at it are missing, too. {_remedy(solution, body, highest**2 - 1)}",
    )


def _of_derivatives(solution: Solution, lateral: bool) -> Iterator[Caution]:
    """Doubts about derivatives of an equilibrium that nothing bends, by what would bend it."""
    for state in stiffened_states(solution):
        times = _times_of_derivatives(solution, state) if solution.dq.shape[2] else 1 + state.largest() if lateral else 1.0
        if times > 1 + LIMIT:
            body = most_pulled(solution)
            yield tension.caution(
                f"tension stiffens {body} across itself, and these equations do not know it: derivatives by what bends it are up to "
                f"{_times(times)} as large as they should be. {_remedy(solution, body, times - 1)}",
            )


def _times_of_derivatives(solution: Solution, state: StiffenedState) -> float:
    """Largest factor by which the derivatives of coordinates that a solution holds are too large."""
    weights, worst = solution.system.weights[: solution.system.n_q], 1.0
    for moved in np.real(solution.dq[0]).T:
        force = state.adds(np.where(state.elastic, moved, 0.0))
        less, work = state.yields(force), float(force @ moved)
        if not work > 0:
            continue
        size = float(np.abs(weights * less).max() / np.abs(weights * moved).max())
        part = min(size / (1 + float(force @ less) / work), 1.0)
        worst = max(worst, 1 / (1 - part) if part < 1 else np.inf)
    return worst


def _too_large(solution: Solution, found: TooLarge) -> str:
    when = f" at t = {solution.times[found.state.instant]:.4g}" if solution.steps else ""
    why = "its own deflection, between what holds it, pulls at" if found.by_itself else "tension pulls at"
    times = 1 / (1 - found.part) if found.part < 1 else np.inf
    stiffer = float(np.fmax(1 + found.state.largest(), times))  # a state that loses its stability elsewhere tells no largest one
    return (
        f"{why} {found.body}{when} and stiffens it across itself, which these equations do not know: its largest displacement is "
        f"{_times(times)} as large as it should be, stresses and whatever depends on it are "
        f"off as much, derivatives by what bends it are up to {_times(stiffer)} as large, and frequencies across it up to "
        f"{1 - 1 / np.sqrt(stiffer):.0%} too low. {_remedy(solution, found.body, stiffer - 1)}"
    )


def _times(factor: float) -> str:
    return f"{factor:.3g} times" if factor < MANY else "many times"


def _remedy(solution: Solution, body: str, part: float) -> str:
    helps = divided(solution.system.scene, body, part / LIMIT)
    return f"Linear FFRF knows this between frames, and not inside of one. Fix: {helps}."
