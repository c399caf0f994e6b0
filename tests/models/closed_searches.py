"""Searches on mean squares in closed form, which cost no design of a scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from toolkit.studies.optimization.explored import SearchResult
from toolkit.studies.optimization.program import Values
from toolkit.studies.optimization.search import SearchRun
from toolkit.studies.store import DesignOutcome
from toolkit.studies.study_file import Search as SearchOptions

Residuals = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""r of a z, and its derivatives (r, z)."""


@dataclass(frozen=True)
class Squares:
    """The program of the least r . r of variables between 0 and `top`."""

    top: np.ndarray
    options: SearchOptions
    unit: float = 1.0

    @property
    def problem(self) -> Any:
        study = SimpleNamespace(search=self.options, objective=SimpleNamespace(scale=None))
        return SimpleNamespace(study=study, curved=("squares",))

    def scaled(self, design: np.ndarray) -> np.ndarray:
        return design

    def design(self, z: np.ndarray) -> np.ndarray:
        return np.clip(z, 0.0, self.top)

    def values(self, found: DesignOutcome) -> Values:
        r, r_z = found.values[0], found.gradients[0]
        f, df, curvature = r @ r / self.unit, 2 * r @ r_z / self.unit, 2 * r_z.T @ r_z / self.unit
        return Values(f, df, np.empty(0), np.empty((0, len(self.top))), curvature)


def nowhere(_: np.ndarray) -> bool:
    """Every design can be solved."""
    return False


def searched(
    residuals: Residuals, start: np.ndarray, fails: Callable[[np.ndarray], bool] = nowhere, **options: Any
) -> SearchResult:
    """A search from a start, of variables between 0 and 1, in which designs fail where it is said."""
    return search_of(residuals, len(start), fails, **options).run(start, None)


def search_of(residuals: Residuals, count: int = 2, fails: Callable[[np.ndarray], bool] = nowhere, **options: Any) -> SearchRun:
    """That search of so many variables, before it begins."""

    def solve(lane: int, design: np.ndarray, _: bool) -> DesignOutcome:
        r, r_z = residuals(design)
        return DesignOutcome(
            lane=lane, design=design, reason="a wall" if fails(design) else "", values=r[None], gradients=r_z[None]
        )

    program: Any = Squares(np.ones(count), SearchOptions(**options))
    evaluator: Any = solve
    return SearchRun(program, evaluator, 0, False, lambda _: None)
