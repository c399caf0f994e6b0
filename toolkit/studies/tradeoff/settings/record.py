"""What is kept of one setting: its values and gradients, or why it failed, and the times of its runs."""

from __future__ import annotations

import math
from statistics import median
from typing import Any

from pydantic import BaseModel, ConfigDict

Numbers = dict[str, float]


class Record(BaseModel):
    """A setting that was run; a number that does not exist is None in the file and nan here.

    Attributes
    ----------
    key
        What it belongs to, see `store.Store.key`.
    labels
        Axis -> value, for people.
    failure
        Why there are no values; empty if there are.
    values, gradients
        Response -> value; response -> variable -> derivative.
    units, sizes
        Units of the responses; what a relative change of each variable refers to.
    method
        How the gradients came about.
    steps, newton_iterations, drift, coordinates
        Of the run.
    first
        Time of the first run with gradients in s, which no other statement rests on.
    primal, whole
        Times of the repeated runs in s: to the values; to values and gradients.
    """

    model_config = ConfigDict(extra="forbid", ser_json_inf_nan="null")
    key: str
    labels: dict[str, str]
    failure: str = ""
    values: dict[str, float | None] = {}
    gradients: dict[str, dict[str, float | None]] = {}
    units: dict[str, str] = {}
    sizes: Numbers = {}
    method: str = ""
    steps: int = 0
    newton_iterations: int = 0
    drift: float = 0.0
    coordinates: int = 0
    first: float = 0.0
    primal: list[float] = []
    whole: list[float] = []

    def value(self, response: str) -> float:
        """Value of a response; nan if it does not exist."""
        return _number(self.values.get(response))

    def slope(self, response: str, variable: str) -> float:
        """Derivative of a response; nan if it does not exist."""
        return _number(self.gradients.get(response, {}).get(variable))

    @property
    def seconds(self) -> tuple[float, float]:
        """Medians of the times to the values, and to values and gradients; nan before they are measured."""
        return _median(self.primal), _median(self.whole)


def _number(value: Any) -> float:
    return math.nan if value is None else value


def _median(times: list[float]) -> float:
    return median(times) if times else math.nan
