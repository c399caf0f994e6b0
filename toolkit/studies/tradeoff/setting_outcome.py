"""What came of one setting: its values and gradients, or why it failed, and the times of its runs."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from statistics import median

from toolkit.studies.engine.outcome import RunOutcome


@dataclass(frozen=True, kw_only=True)
class SettingOutcome(RunOutcome):
    """A setting that was run; a number that does not exist is nan.

    Attributes
    ----------
    seconds
        Time of the first run with gradients, which no statement rests on.
    units, sizes
        Units of the responses; what a relative change of each variable refers to.
    method
        How the gradients came about.
    coordinates
        Of the run.
    primal, whole
        Times of the repeated runs in s: to the values; to values and gradients.
    """

    units: dict[str, str] = field(default_factory=dict)
    sizes: dict[str, float] = field(default_factory=dict)
    method: str = ""
    coordinates: int = 0
    primal: list[float] = field(default_factory=list)
    whole: list[float] = field(default_factory=list)

    def value(self, response: str) -> float:
        """Value of a response; nan if it does not exist."""
        return self.values.get(response, math.nan)

    def slope(self, response: str, variable: str) -> float:
        """Derivative of a response; nan if it does not exist."""
        return self.gradients.get(response, {}).get(variable, math.nan)

    @property
    def medians(self) -> tuple[float, float]:
        """Medians of the times to the values, and to values and gradients; nan before they are measured."""
        primal, whole = (median(times) if times else math.nan for times in (self.primal, self.whole))
        return primal, whole
