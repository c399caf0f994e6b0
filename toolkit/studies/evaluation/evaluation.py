"""One design of a study: what it is worth in all cases, or why it could not be solved."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np


class State(NamedTuple):
    """The equilibrium of one case, which that of a design near by is sought from; empty arrays of a motion."""

    q: np.ndarray
    multipliers: np.ndarray


@dataclass(frozen=True)
class Evaluation:
    """A design that was solved, or could not be.

    Attributes
    ----------
    lane
        Which search asked for it.
    design
        Values of the variables, (n,).
    reason
        Why it failed; empty if it did not.
    values, gradients
        Of all responses in all cases, (cases, responses) and (cases, responses, n); empty if it failed.
    states
        Of all cases.
    wall
        Time that it took, in s; nothing follows from it.
    curvatures
        Second derivatives of what the problem calls `curved`, in all cases, (cases, curved, n, n); empty if nothing is.
    """

    lane: int
    design: np.ndarray
    reason: str
    values: np.ndarray
    gradients: np.ndarray
    states: tuple[State, ...]
    wall: float
    curvatures: np.ndarray = field(default_factory=lambda: np.zeros(0))

    @property
    def failed(self) -> bool:
        """Whether there are no values."""
        return bool(self.reason)
