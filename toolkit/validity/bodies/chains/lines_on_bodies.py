"""Answers that joints along a line on a flexible body falsify: by what the deformed body in the place of the line would change.

Responses of an equilibrium are asked of the changed state, those of a motion by their derivatives or, of stress, in some changed states.
Frequencies are those with the joint's rows at the body beside the block.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from toolkit.foundation.near_ties import spread
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.responses.least_frequency import LeastFrequency, LoadMargin
from toolkit.responses.pencil import Pencil, free_pencil, pencil_of, real_pencil
from toolkit.responses.response import Instant, Response
from toolkit.responses.stress import StressResponse
from toolkit.responses.vibration import Frequency, OfVibration
from toolkit.solvers.free_motions import undamped_rates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.led_points import Beside, Line, beside, lines

LIMIT = 0.05
"""Relative change of a response above which there is a doubt: as much as bodies may be deformed beyond what is linear."""
STEPS = 20
"""Number of instants at which the largest value of a response is sought, and of those at which its change is evaluated."""

Known = dict[int, Beside | None]
"""Instant -> the deformed body beside a line's block."""


def asked_vibrations(solution: Solution) -> dict[str, int]:
    """Responses that ask for a vibration -> its number from the slowest on."""
    found = {name: each for name, each in solution.system.scene.responses.items() if isinstance(each, Frequency | LeastFrequency)}
    return {name: getattr(each, "number", 1) for name, each in found.items() if not (solution.steps and each.needs_rest)}


@check("line-on-flexible-body", STATES)
def lines_on_bodies(solution: Solution, vibrations: Mapping[str, int] | None = None, values: bool = True) -> Iterator[Caution]:
    """A joint leads its point along the straight tangent of a flexible body, or in a plane there, and loads the body where the joint is;
    along the deformed body a response or a frequency would be another number, which is told.

    Limit: 5 % of the response, in a motion of its largest value.
    Fix: the joint's point where its partner stands, or a stiff body of its own as the rail.

    Parameters
    ----------
    vibrations
        Those about the last state, by what they are called, and their numbers from the slowest on; by default those of responses.
    values
        Whether the other responses are looked at, too.
    """
    vibrations = asked_vibrations(solution) if vibrations is None else vibrations
    for line in lines(solution):
        known: Known = {}
        told = _worst(_changes(solution, line, known)) if values else ""
        told = told or _worst(_of_vibrations(solution, line, vibrations, known))
        if told:
            yield lines_on_bodies.caution(_words(line, known, told))


def _worst(changes: Iterator[tuple[str, float, float, float]]) -> str:
    """A phrase on the answer that changes most, from name, value, change, and scale of the change; empty where none does."""
    worst, told = LIMIT, ""
    for name, value, change, size in changes:
        part = abs(change) / size if size > 0 else 0.0
        if part > worst:
            worst, told = part, f"{name} would be about {value + change:.3g} instead of {value:.3g}"
    return told


def _words(line: Line, known: Known, told: str) -> str:
    far = max((each for each in known.values() if each is not None), key=lambda each: each.gap + abs(each.travel) * 1e-9)
    where = f", where the body itself is {far.gap:.2g} beside it," if far.gap > 1e-9 * far.travel else ""
    return (
        f"joints.{line.name} leads its point along the tangent of {line.body} at the joint's point, {far.travel:.3g} away from there"
        f"{where} and loads the body at the joint's point alone. Along the deformed body {told}. "
        "Its derivatives are off as much. Fix: put the joint's point where on the body its partner stands, or make the rail a stiff body; "
        "no joint follows a body that bends."
    )


def _changes(solution: Solution, line: Line, known: Known) -> Iterator[tuple[str, float, float, float]]:
    """Name, value, change and scale of all responses but those of vibrations."""
    responses: Mapping[str, Any] = solution.system.scene.responses
    for name, response in responses.items():
        left_out = (response.needs_rest and solution.steps) or (response.needs_motion and not solution.steps)
        if left_out or isinstance(response, OfVibration | LeastFrequency | LoadMargin):
            continue
        if not solution.steps:
            value, change = _at_rest(solution, line, response, known)
        elif isinstance(response, StressResponse):
            value, change = _of_stress(solution, line, response, known)
        else:
            value, change = _changed(solution, line, response, known)
        yield name, value, change, max(abs(value), _largest(solution, response)) if change else 0.0


def _found(solution: Solution, line: Line, known: Known, instant: int) -> Beside | None:
    if instant not in known:
        known[instant] = beside(solution, line, instant)
    return known[instant]


def _at_rest(solution: Solution, line: Line, response: Response, known: Known) -> tuple[float, float]:
    """Value of a response of an equilibrium, and its change along the deformed body."""
    value, found = float(np.real(response.value(solution))), _found(solution, line, known, 0)
    if found is None:
        return value, 0.0
    return value, float(np.real(response.value(_moved(solution, [0], found.change[None])))) - value


def _moved(solution: Solution, instants: list[int], change: np.ndarray) -> Solution:
    """States at some instants with changes (n_t, n) of their coordinates and multipliers."""
    n_q = solution.system.n_q
    names = ("times", "v", "a", "dq", "dv", "da", "dmultipliers")
    kept = {name: getattr(solution, name)[instants] for name in names}
    q, multipliers = solution.q[instants] + change[:, :n_q], solution.multipliers[instants] + change[:, n_q:]
    return replace(solution, **kept, q=q, multipliers=multipliers)


def _of_stress(solution: Solution, line: Line, response: StressResponse, known: Known) -> tuple[float, float]:
    """Value of a largest stress of a motion, and its change along the deformed body, by some instants."""
    last = len(solution.times) - 1
    instants = [last] if response.when == "end" else spread(last, STEPS)
    none = np.zeros(solution.system.n)
    found = [_found(solution, line, known, k) for k in instants]
    changes = np.array([none if each is None else each.change for each in found])
    before, after = (float(np.real(response.value(_moved(solution, instants, each)))) for each in (0 * changes, changes))
    return float(np.real(response.value(solution))), after - before


def _changed(solution: Solution, line: Line, response: Response, known: Known) -> tuple[float, float]:
    """Value of any response of a motion, and its change along the deformed body, by its derivatives."""
    partials, n_q = response.partials(solution), solution.system.n_q
    slopes = [each for each in (partials.q, partials.multipliers) if each is not None]
    felt = np.flatnonzero(np.any([np.nan_to_num(each).any(axis=1) for each in slopes], axis=0)) if slopes else np.zeros(0, int)
    chosen = felt[spread(len(felt) - 1, STEPS)] if len(felt) else felt
    total = 0.0
    for k in chosen.tolist():
        found = _found(solution, line, known, k)
        if found is not None:
            total += 0.0 if partials.q is None else float(np.real(partials.q[k] @ found.change[:n_q]))
            total += 0.0 if partials.multipliers is None else float(np.real(partials.multipliers[k] @ found.change[n_q:]))
    return float(np.real(partials.value)), total * len(felt) / max(len(chosen), 1)


def _largest(solution: Solution, response: Response) -> float:
    """Largest magnitude of a response at one time over the motion; zero of other responses."""
    if not (solution.steps and isinstance(response, Instant)):
        return 0.0
    return max(abs(float(np.real(response.at(solution, k).value))) for k in spread(len(solution.times) - 1, STEPS))


def _of_vibrations(
    solution: Solution, line: Line, asked: Mapping[str, int], known: Known
) -> Iterator[tuple[str, float, float, float]]:
    """Name, value, change and scale of frequencies about the last state, in cycles per time."""
    found = _found(solution, line, known, len(solution.times) - 1) if asked else None
    if found is None or solution.spins:
        return
    pencil, n_q = real_pencil(pencil_of(solution)), solution.system.n_q
    rows, stiffness = line.row + np.arange(len(found.rows)), pencil.stiffness.copy()
    stiffness[rows, :n_q], stiffness[:n_q, rows] = found.rows, found.rows.T
    before, after = (_rates(solution, each) for each in (pencil, pencil._replace(stiffness=stiffness)))
    for name, number in asked.items():
        if number <= min(len(before), len(after)):
            value, true = float(before[number - 1]), float(after[number - 1])
            yield name, value, true - value, max(value, true)


def _rates(solution: Solution, pencil: Pencil) -> np.ndarray:
    reduced = free_pencil(solution.system.weights[: solution.system.n_q], pencil)[1]
    return undamped_rates(reduced.stiffness, reduced.mass) / (2 * np.pi)
