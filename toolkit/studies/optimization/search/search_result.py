"""How one search ended, and why a method is to stop before it is done."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolkit.studies.engine.outcome import DesignOutcome
from toolkit.studies.optimization.optimality import Optimality
from toolkit.studies.optimization.program import Program


class Ended(Exception):
    """Why a method is to stop; no error."""


class Arrived(Ended):
    """The conditions of an optimum are met."""


class Renewed(Ended):
    """A method is to begin anew, or the next one: so many designs were solved."""


class Spent(Ended):
    """No more designs may be solved, or no more may fail."""


@dataclass(frozen=True)
class SearchResult:
    """How one search ended.

    Attributes
    ----------
    lane
        Its number in the store.
    best
        The design where it ended: feasible and of the least objective, or else the one that violates its constraints least; None if not one
        could be solved.
    optimality
        What is left of the conditions there.
    program
        The functions as they were scaled.
    ended
        Why it ended, in words.
    evaluations, failed
        Designs solved, and how many of them failed.
    """

    lane: int
    start: np.ndarray
    best: DesignOutcome | None
    optimality: Optimality | None
    program: Program
    ended: str
    evaluations: int
    failed: int
    arrived: bool
