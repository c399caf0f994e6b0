"""Memory in which one thread evaluates the equations of a system, again and again."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np

from toolkit.equations.equations import Plan, Terms, allocate_terms, allocate_work, of_variables
from toolkit.foundation.compiled.calls import in_memory


class EvaluationMemory(threading.local):
    """Every thread has its own.

    Parameters
    ----------
    plan
        Of the system, whose formulas run compiled.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan, self._terms = plan, allocate_terms(plan, float)
        self._state = np.zeros((3, plan.n))
        self._touched = plan.touched_variable * plan.n + plan.touched_row
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
        copied = {"inertial", "applied", *(("I_acc", "I_q", "A_q", "A_v") if linearized else ())}
        found = Terms(
            *[
                each.copy() if name in copied else np.zeros(each.shape, order="F")  # memory that nobody reads
                for name, each in self._terms._asdict().items()
            ]
        )
        if designed:  # few entries by each variable
            for to, known in ((found.I_x, self._terms.I_x), (found.A_x, self._terms.A_x)):
                np.put(to.T, self._touched, np.take(known.T, self._touched))
        return of_variables(self._plan, found)
