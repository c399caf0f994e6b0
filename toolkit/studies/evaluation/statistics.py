"""Mean and standard deviation of a design over the points of uncertain numbers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from toolkit.foundation.errors import ToolkitError
from toolkit.studies.evaluation.case_run import CaseRun, Ran
from toolkit.studies.study.problem import Problem


class Robust(NamedTuple):
    """A statistic with its gradient (n,), and second derivative (n, n), None if it is not told."""

    value: float
    slope: np.ndarray
    curvature: np.ndarray | None


def statistics(run: CaseRun, design: np.ndarray, here: Ran) -> Iterator[Robust]:
    """What is to be robust; `here` is the run at the means."""
    problem = run.problem
    if problem.points is None:
        return
    ran = [here, *(_at_point(run, design, point) for point in range(1, len(problem.points)))]
    values, slopes = np.array([each.values for each in ran]), np.array([each.gradients for each in ran])
    squares, curved = list(problem.squares), np.array([each.curvatures for each in ran])
    for name, each in problem.statistics.items():
        weights = np.array([each.weights.get(asked, 0.0) for asked in problem.asked])
        undecided = _undecided(problem, weights, values)
        mean, by_mean, sigma, by_sigma = problem.points.statistics(values @ weights, weights @ slopes, undecided)
        bent = None
        if run.curvatures and name in problem.curved:
            shares = np.array([each.weights[square] for square in squares])
            parts = np.einsum("s,psxy->pxy", shares, curved)
            both = problem.points.curvatures(values @ weights, weights @ slopes, parts, undecided)
            bent = each.mean * both[0] + each.sigma * both[1]
        yield Robust(each.mean * mean + each.sigma * sigma, each.mean * by_mean + each.sigma * by_sigma, bent)


def _undecided(problem: Problem, weights: np.ndarray, values: np.ndarray) -> float:
    shares = zip(problem.asked, weights, values.T, strict=True)
    return sum(abs(weight) * problem.undecided(name, column) for name, weight, column in shares)


def _at_point(run: CaseRun, design: np.ndarray, point: int) -> Ran:
    """The run at a point; whoever fails says which."""
    problem, points = run.problem, run.problem.points
    assert points is not None
    try:
        return run.at(design, point)
    except ToolkitError as error:
        moved = np.flatnonzero(points.shifts[point])
        there = points.at(point) | {problem.variables[k]: float((design + points.shifts[point])[k]) for k in moved}
        raise ToolkitError(f"where {', '.join(f'{name} = {value:.5g}' for name, value in there.items())}: {error}") from error
