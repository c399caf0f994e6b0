"""Memory in which one thread evaluates the equations of a system, again and again."""

from __future__ import annotations

import threading
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
        self.terms: Any = in_memory(self._terms)
        self.work: Any = in_memory(allocate_work(plan, float))

    def found(self, linearized: bool, designed: bool) -> Terms:
        """What the last evaluation has found, for whoever asked; what it was not asked for is zero."""
        wanted = {"inertial": True, "applied": True, "I_x": designed, "A_x": designed}
        return Terms(
            *(
                values.copy() if wanted.get(name, linearized) else np.zeros_like(values)
                for name, values in zip(Terms._fields, self._terms, strict=True)
            )
        )
