"""Memory in which one thread evaluates the equations of a system, again and again."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np

from toolkit.equations.equations import Plan, Terms, allocate_terms, allocate_work
from toolkit.foundation.compiled.calls import in_memory


class EvaluationMemory(threading.local):
    """Every thread has its own.

    Parameters
    ----------
    plan
        Of the system, whose formulas run compiled.
    """

    def __init__(self, plan: Plan) -> None:
        self._terms = allocate_terms(plan, float)
        self._state = np.zeros((3, plan.n))
        self.terms: Any = in_memory(self._terms)
        self.work: Any = in_memory(allocate_work(plan, float))
        self.formula: Callable[..., Any] | None = None
        """The compiled equations, once they have been looked up."""

    def state(self, *vectors: np.ndarray) -> np.ndarray:
        """q, v and acc (n,) as the compiled equations take them."""
        self._state[:] = vectors
        return self._state

    def found(self, linearized: bool, designed: bool) -> Terms:
        """What the last evaluation has found, for whoever asked; what it was not asked for is zero."""
        wanted = {"inertial": True, "applied": True, "I_x": designed, "A_x": designed}
        asked = [wanted.get(name, linearized) for name in Terms._fields]
        found = zip(asked, self._terms, strict=True)
        return Terms(
            *[each.copy() if is_wanted else np.zeros(each.shape) for is_wanted, each in found]
        )  # memory that nobody reads
