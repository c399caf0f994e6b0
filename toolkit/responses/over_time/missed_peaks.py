"""Peaks between the steps of a run, which a largest value over all steps does not see, however well other steps agree with it.

A wheel with five steps in a turn is seen at five places, with twice as long steps at the same five. Four values in a row tell: a parabola
through three of them has its vertex between the inner two, and so has the one through the other three. The lower vertex counts, so that
a jump, which bends one of them alone, is no peak.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.verdict import Caution
from toolkit.responses.over_time.extremes import TimeKS, TimeMax, TimeMin
from toolkit.responses.over_time.over_time import over_all_steps
from toolkit.responses.stress.stress import KSStress, MaxStress
from toolkit.system.solution import Solution

MISSED = 0.042
"""Part of the largest magnitude by which a peak may be missed without a word: the same as of other errors by the length of steps."""


def missed_peaks(solution: Solution) -> Iterator[Caution]:
    """Doubt for every extreme over time that lies beyond the values at the steps, as far as all values are kept."""
    if solution.run_times is not None or len(solution.times) < 4:
        return
    for name, response in solution.system.scene.responses.items():
        missed = missed_part(solution.times, np.array(list(_curves(response, solution))))
        if missed > MISSED:
            yield Caution(
                "missed-peak",
                f"{name} is the largest (or least) of the values at the steps, and between them is one that is about {missed:.1%} beyond. "
                f"Try solver.step = {np.diff(solution.times).max() / 4:.1g}.",
            )


def missed_part(times: np.ndarray, curves: np.ndarray) -> float:
    """How far a peak between the times (n,) is above the largest of some curves' values (m, n), a part of the largest magnitude."""
    size, beyond = float(np.abs(curves).max(initial=0.0)), 0.0
    for values in curves:
        before, after = _vertices(times, values)
        beyond = max(beyond, float(np.minimum(before[:-1], after[1:]).max(initial=-np.inf) - curves.max()))
    return beyond / size if size > 0 else 0.0


def peaks(solution: Solution) -> Iterator[tuple[int, float]]:
    """Step of the largest value of each curve that a response looks for peaks in, and by how many steps its vertex is later."""
    for response in solution.system.scene.responses.values():
        for values in _curves(response, solution):
            step = int(np.argmax(values))
            before, at, after = values[step - 1 : step + 2] if 0 < step < len(values) - 1 else (0.0, 0.0, 0.0)
            bend = before - 2 * at + after
            yield step, (before - after) / (2 * bend) if bend < 0 else 0.0


def _vertices(times: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices of the parabolas through three values in a row, (n - 2,), which are maxima in the second and in the first of both steps."""
    left, right = np.diff(times)[:-1], np.diff(times)[1:]
    rises = np.diff(values) / np.diff(times)
    bend = (rises[1:] - rises[:-1]) / (left + right)
    slope = rises[:-1] + bend * left
    with np.errstate(divide="ignore", invalid="ignore"):
        place = np.where(bend < 0, -slope / (2 * bend), np.inf)
        height = values[1:-1] + slope * place / 2
    second, first = (place >= 0) & (place <= right), (place <= 0) & (place >= -left)
    return np.where(second, height, -np.inf), np.where(first, height, -np.inf)


def _curves(response: object, solution: Solution) -> Iterator[np.ndarray]:
    """Values at all steps (n_t,) whose largest or smooth largest is the response; for an absolute one also their negatives."""
    if isinstance(response, TimeMax | TimeMin | TimeKS):
        values = np.real(over_all_steps(response.source, solution))
        absolute = isinstance(response, TimeMax | TimeKS) and response.measure == "absolute"
        yield from (values, -values) if absolute else (-values if isinstance(response, TimeMin) else values,)
    elif isinstance(response, MaxStress | KSStress) and response.when == "all":
        considered = np.real(response.considered(solution))
        yield considered[:, int(np.argmax(considered.max(axis=0)))]
