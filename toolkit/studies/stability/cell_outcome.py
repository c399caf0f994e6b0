"""What came of one cell of a map, and how far the outcomes of two cells are apart."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from toolkit.studies.engine.outcome import RunOutcome

Status = Literal["ended", "failed", "refused"]
Slopes = dict[str, dict[str, float]]


class Ending(NamedTuple):
    """How a run, or the differentiation of one, ended; the error's text if it did not."""

    status: Status = "ended"
    message: str = ""


@dataclass(frozen=True, kw_only=True)
class CellOutcome(RunOutcome):
    """A cell that was run; `reason` says why it did not end, and may go with other numbers that are known.

    Attributes
    ----------
    status
        How the run ended.
    differentiation
        How its differentiation ended; None if there are no variables.
    gradients
        Response -> variable -> derivative times the size of the variable, so that all slopes of a response are comparable.
    created
        `created_energy`.
    disagreement
        Largest difference of direct differentiation and adjoint, over the largest slope of each response.
    undecided
        Response -> up to where its slopes may be round-off.
    """

    status: Status = "ended"
    differentiation: Ending | None = None
    created: float = 0.0
    disagreement: float = 0.0
    undecided: dict[str, float] = field(default_factory=dict)

    @property
    def ending(self) -> Ending:
        """How the run ended."""
        return Ending(self.status, self.reason)


def slope_difference(one: Slopes, other: Slopes, undecided: Mapping[str, float]) -> float:
    """Largest difference of slopes, over the largest slope in `other` of the same response.

    Derivatives that do not exist in `other` are left out; one that is lost, or a response that gained one, counts as infinite. Slopes that
    are zero but for round-off, up to `undecided`, differ by nothing.
    """
    largest = 0.0
    for f, row in other.items():
        theirs, ours = np.array(list(row.values())), np.array([one[f][x] for x in row])
        exists = ~np.isnan(theirs)
        if exists.any():
            off, size = np.abs(ours[exists] - theirs[exists]).max(), np.abs(theirs[exists]).max()
            nothing = max(off, size) <= undecided.get(f, 0.0)
            largest = largest if nothing else max(largest, _ratio(off, size))
    return largest


def value_difference(one: CellOutcome, other: CellOutcome) -> float:
    """Largest difference of responses, each over what it is in `other` or over what a variable's own size changes there."""
    largest = 0.0
    for f, value in other.values.items():
        scale = max([abs(value), *(abs(s) for s in other.gradients.get(f, {}).values() if np.isfinite(s))])
        largest = max(largest, _ratio(abs(one.values[f] - value), scale))
    return largest


def _ratio(difference: float, scale: float) -> float:
    """Relative difference; nan and the change of a zero are infinite."""
    if difference == 0:
        return 0.0
    found = difference / scale if scale > 0 else np.inf
    return float(found) if np.isfinite(found) else np.inf
