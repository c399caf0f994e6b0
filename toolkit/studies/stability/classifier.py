"""The classifier of a map: what a cell is called, and why.

A run is
    failed       if it raised an error: Newton did not converge, or the equations of a step are singular;
    refused      if the scene cannot be set up there, for example a reduced model that knows no other thickness;
    drifting     if it ended, but its joints opened further than `drift`, or it created more energy than `energy`;
    inaccurate   if it ended in good order, but a response differs from the reference by more than `accuracy`;
    stable       otherwise.

Why these. An error and open joints are what the solver itself can see. Energy is the norm in which a scheme is stable or not: a scheme
that creates energy out of nothing grows without bound if it runs on, one that loses some does not, so only what was created counts,
beyond the error of the sum that measures the work. All of this can be in order and the motion wrong: after a singular position the
mechanism may have taken the other branch, a step may have jumped over a snap-through. Only a comparison sees that, and `accuracy` is
coarse on purpose: it tells another motion from the same motion with an error, which is what `ffrf tradeoff` measures.

A gradient has the same names: failed and refused if it could not be computed, drifting where its run drifts, inaccurate if direct
differentiation and the adjoint differ by more than `agreement`, or if it is further than `accuracy` from the gradient of the reference.
Both methods are exact for the same discrete equations, so whatever they differ by is round-off that grew: half the digits of double
precision are the least that an optimiser can use.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from toolkit.studies.stability.cell_outcome import CellOutcome, Ending, slope_difference, value_difference

CLASSES = ("stable", "inaccurate", "drifting", "failed", "refused", "not run")


@dataclass(frozen=True)
class Limits:
    """Where one class ends and the next begins; all relative."""

    drift: float = 1e-3
    energy: float = 0.05
    accuracy: float = 0.1
    agreement: float = 1e-6


@dataclass(frozen=True)
class CellClass:
    """Class of a cell, and what decided it."""

    name: str
    reason: str = ""


def run_class(cell: CellOutcome, reference: CellOutcome | None, limits: Limits) -> CellClass:
    """Class of a run; without a reference its accuracy is not judged."""
    return _ended(cell.ending) or _drifting(cell, limits) or _compared(cell.ending, cell, reference, value_difference, limits)


def gradient_class(cell: CellOutcome, reference: CellOutcome | None, limits: Limits) -> CellClass | None:
    """Class of a gradient; None if there are no variables."""
    if cell.differentiation is None and not cell.failed:
        return None
    ending = cell.differentiation or cell.ending
    return (
        _ended(ending)
        or _drifting(cell, limits)
        or _disagreeing(cell, limits)
        or _compared(
            ending, cell, reference, lambda one, other: slope_difference(one.gradients, other.gradients, other.undecided), limits
        )
    )


def _ended(ending: Ending) -> CellClass | None:
    return None if ending.status == "ended" else CellClass(ending.status, ending.message)


def _drifting(cell: CellOutcome, limits: Limits) -> CellClass | None:
    if not cell.drift <= limits.drift:
        return CellClass("drifting", f"joints open by {cell.drift:.1e} of the model size, more than {limits.drift:g}")
    if not cell.created <= limits.energy:
        return CellClass("drifting", f"energy created: {100 * cell.created:.3g} % of the largest energy or work")
    return None


def _disagreeing(cell: CellOutcome, limits: Limits) -> CellClass | None:
    if cell.disagreement > limits.agreement:
        return CellClass("inaccurate", f"direct differentiation and adjoint differ by {cell.disagreement:.1e}")
    if any(np.isinf(slope) for row in cell.gradients.values() for slope in row.values()):
        return CellClass("inaccurate", "a derivative is infinite")
    return None


def _compared(
    ending: Ending,
    cell: CellOutcome,
    reference: CellOutcome | None,
    difference: Callable[[CellOutcome, CellOutcome], float],
    limits: Limits,
) -> CellClass:
    if reference is None:
        return CellClass("stable")
    there = reference.ending if reference.failed else (reference.differentiation or ending)
    if there.status != "ended":
        return CellClass("inaccurate", f"with half the step: {there.message}")
    off = difference(cell, reference)
    if off > limits.accuracy:
        return CellClass("inaccurate", f"off by {100 * off:.3g} % of the reference")
    return CellClass("stable", f"off by {100 * off:.2g} % of the reference")
