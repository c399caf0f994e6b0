"""Result of a sweep: a row for every design, with values and gradients, or the reason why there are none."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.verdict import Verdict
from toolkit.studies.engine.outcome import DesignOutcome
from toolkit.studies.study.problem import Problem

Cell = int | float | str
NUMBER, FAILURE = "design", "failure"
"""Columns of the table beside those of variables and responses: the number of the design, and why it failed."""


def derivative(label: str, variable: str) -> str:
    """Name of the column of a derivative."""
    return f"d({label})/d({variable})"


def refuse_equal_columns(problem: Problem) -> None:
    """Refuse names of which two would be the same column of the table.

    Raises
    ------
    InputError
        A variable or a response is called like another column.
    """
    labels = {label: problem.responses[j] for label, (_, j) in problem.labels.items()}
    taken = {NUMBER: "the number of the design", FAILURE: "why a design failed"}
    taken |= {label: f"the response {name!r}" for label, name in labels.items() if label not in taken}
    taken |= {derivative(label, name): "a derivative" for label in labels for name in problem.variables}
    for name in problem.variables:
        if name in taken:
            raise InputError(
                f"variables.{name}: {name!r} is the column of a sweep's table that holds {taken[name]}. Give the variable another name."
            )
    for label, name in labels.items():
        if label in (NUMBER, FAILURE):
            raise InputError(
                f"responses.{name}: {name!r} is the column of a sweep's table that holds {taken[label]}. Give the response another name, "
                "or leave it out of sweep.responses."
            )


@dataclass(frozen=True)
class Swept:
    """Values and gradients of a study at many designs.

    Attributes
    ----------
    problem
        The study with its scene.
    designs
        Values of the variables, (designs, n).
    solved
        What came of each design, in their order; equal designs were solved once.
    verdict
        Whether the numbers can be trusted, by the runs at designs of extreme values.
    wall
        Time that the designs took, also before an interruption, in s.
    """

    problem: Problem
    designs: np.ndarray
    solved: tuple[DesignOutcome, ...]
    verdict: Verdict
    wall: float

    @property
    def responses(self) -> dict[str, tuple[int, int]]:
        """Response, with its case before it where cases have names -> index of case and response in the values of a design."""
        return self.problem.labels

    @property
    def units(self) -> dict[str, str]:
        """Response, with its case -> label of its unit."""
        return {label: self.problem.unit_of(self.problem.responses[j]) for label, (_, j) in self.responses.items()}

    @property
    def failed(self) -> int:
        """Number of designs that could not be solved."""
        return sum(each.failed for each in self.solved)

    def values(self, response: str) -> np.ndarray:
        """Values of a response at all designs, (designs,); nan where they failed."""
        place = self.responses[response]
        return np.array([math.nan if each.failed else each.values[place] for each in self.solved])

    def gradients(self, response: str) -> np.ndarray:
        """Derivatives of a response by the variables, (designs, n); nan where designs failed."""
        none = np.full(len(self.problem.variables), math.nan)
        place = self.responses[response]
        return np.array([none if each.failed else each.gradients[place] for each in self.solved])

    @property
    def columns(self) -> dict[str, list[Any]]:
        """Columns of the table: number of the design, variables, why it failed, responses and derivatives."""
        table: dict[str, list[Any]] = {NUMBER: list(range(1, len(self.designs) + 1))}
        table |= {name: self.designs[:, k].tolist() for k, name in enumerate(self.problem.variables)}
        table[FAILURE] = [each.reason for each in self.solved]
        table |= {label: self.values(label).tolist() for label in self.responses}
        if self.problem.study.sweep.gradients:
            for label in self.responses:
                slopes = self.gradients(label)
                table |= {derivative(label, name): slopes[:, k].tolist() for k, name in enumerate(self.problem.variables)}
        return table

    @property
    def said(self) -> str:
        """A sentence with the number of designs, failures and the time."""
        return f"{len(self.designs)} designs, {self.failed} of which could not be solved, in {self.wall:.1f} s."

    def record(self) -> dict[str, Any]:
        """A JSON object with the designs at which responses are least and largest; the table is in the CSV file."""
        low, high = self.problem.bounds
        return {
            "sweep": {
                "points": self.problem.study.sweep.kind,
                "variables": {
                    name: {"least": float(low[k]), "largest": float(high[k])} for k, name in enumerate(self.problem.variables)
                },
                "responses": {
                    label: {
                        "least": self._extreme(label, np.nanargmin),
                        "largest": self._extreme(label, np.nanargmax),
                        "unit": unit,
                    }
                    for label, unit in self.units.items()
                },
            },
            "failures": [
                {"design": k + 1, "variables": self._named(k), "reason": each.reason}
                for k, each in enumerate(self.solved)
                if each.failed
            ],
            "evaluations": len(self.designs),
            "failed": self.failed,
            "wall_s": self.wall,
            **self.verdict.record(),
        }

    def _extreme(self, label: str, where: Any) -> dict[str, Any]:
        values = self.values(label)
        k = int(where(values))
        return {"value": float(values[k]), "design": k + 1, "at": self._named(k)}

    def _named(self, k: int) -> dict[str, float]:
        return dict(zip(self.problem.variables, map(float, self.designs[k]), strict=True))
