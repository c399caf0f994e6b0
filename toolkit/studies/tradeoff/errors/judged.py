"""A setting with its errors and its price."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from toolkit.studies.tradeoff.errors.accuracy import errors
from toolkit.studies.tradeoff.errors.reference import Reference
from toolkit.studies.tradeoff.errors.studied import Studied
from toolkit.studies.tradeoff.settings.record import Record
from toolkit.studies.tradeoff.settings.setting import Setting

NOISE = 1.05
"""Times that differ by less than this factor are equal: medians of a few runs say no more."""


@dataclass(frozen=True)
class Judged:
    """A setting, its record, its errors, and the largest part of any budget that an error takes.

    `ratio` counts the estimated error of the reference on top of that of the setting, so that 1 or less keeps the budget for sure.
    A setting that failed has no errors and an infinite ratio.
    """

    setting: Setting
    record: Record
    errors: dict[Studied, float]
    ratio: float
    worst: Studied | None
    budgeted: frozenset[Studied] = frozenset()

    @property
    def price(self) -> float:
        """Time in s of a run with gradients, or of one without if there are no design variables."""
        return self.record.seconds[1]

    @property
    def kept(self) -> bool:
        """Whether it keeps the budget."""
        return self.ratio <= 1

    def largest(self, derived: bool) -> float:
        """Largest error of all responses that have a budget, or of all such gradients."""
        return max((self.errors[quantity] for quantity in self.budgeted if quantity.derived == derived), default=math.nan)


def judge(setting: Setting, record: Record, reference: Reference, budget: dict[Studied, float]) -> Judged:
    """Errors of a record against the reference and the budget."""
    if record.failure:
        return Judged(setting, record, {}, math.inf, None)
    found = errors(reference, record)
    ratios = {quantity: (found[quantity] + reference.error(quantity)) / limit for quantity, limit in budget.items()}
    worst = max(ratios, key=lambda quantity: ratios[quantity])
    return Judged(setting, record, found, ratios[worst], worst, frozenset(budget))


def cheapest(settings: Sequence[Judged]) -> Judged | None:
    """The fastest setting that keeps the budget; of those as fast within noise, the most exact."""
    kept = [each for each in settings if each.kept]
    if not kept:
        return None
    fastest = min(each.price for each in kept)
    return min((each for each in kept if each.price <= NOISE * fastest), key=lambda each: each.ratio)
