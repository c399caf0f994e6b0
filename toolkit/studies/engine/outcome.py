"""Outcomes of jobs: values and gradients, or the reason why there are none."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

DesignKey = tuple[int, bytes]
"""What a design is kept under: the number of the search that asked for it, and the design to the bit."""
EMPTY = np.zeros(0)
"""Numbers that do not exist."""


@dataclass(frozen=True, kw_only=True)
class JobOutcome:
    """What became of a job.

    Attributes
    ----------
    values, gradients
        Of the responses; empty if the job failed.
    reason
        Why it failed; empty if it did not.
    seconds
        Time that it took; nothing follows from it.
    """

    values: Any
    gradients: Any
    reason: str = ""
    seconds: float = 0.0

    @property
    def failed(self) -> bool:
        """Whether there are no values."""
        return bool(self.reason)


class State(NamedTuple):
    """The equilibrium of one case, which that of a design near by is sought from; empty arrays of a motion."""

    q: np.ndarray
    multipliers: np.ndarray


@dataclass(frozen=True, kw_only=True)
class DesignOutcome(JobOutcome):
    """A design of a study that was solved in all cases, or could not be.

    Attributes
    ----------
    lane
        Number of the search that asked for it.
    design
        Values of the variables, (n,).
    values, gradients
        Of all responses in all cases, (cases, responses) and (cases, responses, n); empty if it failed.
    states
        Equilibria of all cases.
    curvatures
        Second derivatives of what the problem calls `curved`, in all cases, (cases, curved, n, n); empty if nothing is.
    """

    lane: int
    design: np.ndarray
    values: np.ndarray = field(default_factory=lambda: EMPTY)
    gradients: np.ndarray = field(default_factory=lambda: EMPTY)
    states: tuple[State, ...] = ()
    curvatures: np.ndarray = field(default_factory=lambda: EMPTY)

    @property
    def key(self) -> DesignKey:
        """What it is kept under."""
        return self.lane, self.design.tobytes()


@dataclass(frozen=True, kw_only=True)
class RunOutcome(JobOutcome):
    """A scene that was run, or could not be.

    Attributes
    ----------
    values
        Response -> its value.
    gradients
        Response -> variable -> derivative.
    steps, newton_iterations
        Of the run.
    drift
        Largest opening of a joint, relative to the model size or in rad.
    """

    values: dict[str, float] = field(default_factory=dict)
    gradients: dict[str, dict[str, float]] = field(default_factory=dict)
    steps: int = 0
    newton_iterations: int = 0
    drift: float = 0.0
