"""Memory in which one thread evaluates the equations of a system, again and again."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np

from toolkit.equations.equations import Plan, Terms, allocate_terms, allocate_work, of_variables
from toolkit.foundation.compiled.calls import in_memory


class EvaluationMemory(threading.local):
    """Memory in which one thread evaluates the equations of a system; every thread has its own.

    Parameters
    ----------
    plan
        Of the system, whose formulas run compiled.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan, self._terms = plan, allocate_terms(plan, float)
        self._state = np.zeros((3, plan.n))
        self._touched = plan.touched_variable * len(self._terms.I_x) + plan.touched_row
        self.terms: Any = in_memory(self._terms)
        work = allocate_work(plan, float)
        self.work: Any = in_memory(work)
        self.care = work.care
        """Care with which it is evaluated, see `Work`."""
        self.formula: Callable[..., Any] | None = None
        """The compiled equations, once they have been looked up."""

    def state(self, *vectors: np.ndarray) -> np.ndarray:
        """q, v and acc (n,) as the compiled equations take them."""
        self._state[:] = vectors
        return self._state

    def found(self, linearized: bool, designed: bool) -> Terms:
        """Copy of the terms that the last evaluation has found; those that it was not asked for are zero."""
        known = self._terms
        by_state = known.I_acc, known.I_q, known.A_q, known.A_v
        I_acc, I_q, A_q, A_v = [each.copy() for each in by_state] if linearized else np.zeros((4, len(known.I_acc)))
        by_design = np.zeros(known.I_x.shape, order="F"), np.zeros(known.A_x.shape, order="F")  # memory that nobody reads
        found = Terms(known.inertial.copy(), known.applied.copy(), I_acc, I_q, A_q, A_v, *by_design)
        if designed:  # few entries by each variable
            for to, of in ((found.I_x, known.I_x), (found.A_x, known.A_x)):
                np.put(to.T, self._touched, np.take(of.T, self._touched))
        return of_variables(self._plan, found)

    def applied_touched(self) -> np.ndarray:
        """Derivatives of the applied terms by the design that the last evaluation has found, at the entries that the plan names."""
        return np.take(self._terms.A_x.T, self._touched)
