"""Designs solved in all cases, each once: what a store holds already is not solved again."""

from __future__ import annotations

import numpy as np

from toolkit.studies.designs.solved_design import solve_design
from toolkit.studies.engine.outcome import DesignOutcome
from toolkit.studies.engine.store import DesignStore
from toolkit.studies.study.problem import Problem


class Evaluator:
    """Solves designs of a problem, and keeps them.

    Every number follows from the design and from what the same search has solved before it, so that a search which was killed and goes on
    from its store gives the same bits.
    """

    def __init__(self, problem: Problem, store: DesignStore) -> None:
        self.problem = problem
        self.store = store

    def __call__(self, lane: int, design: np.ndarray, warm: bool) -> DesignOutcome:
        """The design, from the store or solved now; `warm` begins statics in the nearest design of the same lane."""
        known = self.store.find((lane, design.tobytes()))
        if known is not None:
            return known
        start = self._nearest(lane, design) if warm and self.problem.kind == "static" else None
        found = solve_design(self.problem, lane, design, start, curvatures=True)
        self.store.keep(found.key, found)
        return found

    def _nearest(self, lane: int, design: np.ndarray) -> DesignOutcome | None:
        """The nearest design of the lane that could be solved, the earlier of two."""
        known = [each for each in self.store.of(lane) if not each.failed]
        distances = [float(np.sum(((each.design - design) / self.problem.scales) ** 2)) for each in known]
        return known[int(np.argmin(distances))] if known else None
