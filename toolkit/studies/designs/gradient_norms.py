"""Norms of gradients as responses: the largest change of a response per step of a design, in scaled variables.

With scales S, the norm N of the gradient g in scaled variables and its derivative are

    N = |S g|,    dN/dz = S H S e,    e = S g / N

H e is the derivative of the gradient along one direction: that of exact gradients at four designs beside, by differences whose error is
known from two steps.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from toolkit.foundation.errors import ToolkitError
from toolkit.studies.designs.case_run import CaseResult, CaseRun

STEP = 1e-3
"""Step of the differences, relative to the variables' scales: round-off of gradients over it is below 1e-7, as is step^4."""
ROUGH = 1e-2
"""Relative error of a derivative above which the gradient is said to have kinks."""


class DerivedValue(NamedTuple):
    """A value that follows from several runs, with its derivatives by the variables (n,).

    Their error is relative to the largest of them; second derivatives are (n, n), None if these are not known.
    """

    value: float
    slope: np.ndarray
    error: float = 0.0
    curvature: np.ndarray | None = None


def norms(run: CaseRun, design: np.ndarray, here: CaseResult) -> Iterator[DerivedValue]:
    """Norms of the gradients of all responses for which a norm is asked; `here` is the run at the design, with gradients.

    Raises
    ------
    ToolkitError
        A design beside cannot be solved, or the gradient leaps.
    """
    for name in run.problem.norms:
        yield _norm(run, design, here, run.problem.asked.index(name))


def with_gradients(run: CaseRun) -> CaseRun:
    """The run with gradients, if a norm of one is asked for; otherwise the run as it is."""
    return replace(run, gradients=True) if run.problem.norms else run


def _norm(run: CaseRun, design: np.ndarray, here: CaseResult, place: int) -> DerivedValue:
    problem, scales = run.problem, run.problem.scales
    slope = scales * here.gradients[place]
    value = float(np.sqrt(np.sum(slope**2)))
    if value <= problem.undecided(problem.asked[place], here.values[place : place + 1]):
        return DerivedValue(value, np.zeros_like(slope))  # it can only grow from here
    along = scales * slope / value
    far, near = (_difference(run, design, step, along, place) for step in (2 * STEP, STEP))
    second = scales * (4 * near - far) / 3
    size = float(np.max(np.abs(second)))
    error = float(np.max(np.abs(scales * (near - far)))) / 3 / size if size else 0.0
    if error > ROUGH:
        raise ToolkitError(
            f"the gradient of {problem.asked[place]} leaps beside this design: differences of it by two steps differ by {error:.1%} of "
            "themselves. A maximum that moves from place to place has kinks, its smooth maximum (ks-stress) has not."
        )
    return DerivedValue(value, second / scales, error)


def _difference(run: CaseRun, design: np.ndarray, step: float, along: np.ndarray, place: int) -> np.ndarray:
    """Derivative of a gradient (n,) along a direction, by designs on both sides."""
    ends = []
    for side in (1.0, -1.0):
        try:
            ends.append(run.at(design + side * step * along).gradients[place])
        except ToolkitError as error:
            raise ToolkitError(f"beside the design, for the gradient's norm: {error}") from error
    found: np.ndarray = (ends[0] - ends[1]) / (2 * step)
    return found
