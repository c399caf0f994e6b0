"""Settings judged by their errors and their price.

Errors of a setting relative to the reference, of responses and of their gradients.

With the reference R, g and the size s_x of what a relative change of the variable x refers to

    error of a response R_k:    |R_k - R| / |R|
    error of its gradient g_k:  max_x |g_k,x - g_x| s_x / max_x |g_x| s_x

so that a derivative which happens to be near zero is compared with those that matter. Where the denominator is less than
`reference.NEGLIGIBLE` of the other one, as that of a response which is zero, this part of the other one takes its place.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from toolkit.studies.tradeoff.budget import ErrorQuantity
from toolkit.studies.tradeoff.reference import Reference
from toolkit.studies.tradeoff.setting import Setting
from toolkit.studies.tradeoff.setting_outcome import SettingOutcome

NOISE = 1.05
"""Times that differ by less than this factor are equal: medians of a few runs say no more."""


@dataclass(frozen=True)
class JudgedSetting:
    """A setting, its outcome, its errors, and the largest part of any budget that an error takes.

    `ratio` counts the estimated error of the reference on top of that of the setting, so that 1 or less keeps the budget for sure.
    A setting that failed has no errors and an infinite ratio.
    """

    setting: Setting
    outcome: SettingOutcome
    errors: dict[ErrorQuantity, float]
    ratio: float
    worst: ErrorQuantity | None
    budgeted: frozenset[ErrorQuantity] = frozenset()

    @property
    def price(self) -> float:
        """Time in s of a run with gradients, or of one without if there are no design variables."""
        return self.outcome.medians[1]

    @property
    def kept(self) -> bool:
        """Whether it keeps the budget."""
        return self.ratio <= 1

    def largest(self, derived: bool) -> float:
        """Largest error of all responses that have a budget, or of all such gradients."""
        return max((self.errors[quantity] for quantity in self.budgeted if quantity.derived == derived), default=math.nan)


def judge(setting: Setting, outcome: SettingOutcome, reference: Reference, budget: dict[ErrorQuantity, float]) -> JudgedSetting:
    """Errors of an outcome against the reference and the budget."""
    if outcome.failed:
        return JudgedSetting(setting, outcome, {}, math.inf, None)
    found = errors(reference, outcome)
    ratios = {quantity: (found[quantity] + reference.error(quantity)) / limit for quantity, limit in budget.items()}
    worst = max(ratios, key=lambda quantity: ratios[quantity])
    return JudgedSetting(setting, outcome, found, ratios[worst], worst, frozenset(budget))


def cheapest(settings: Sequence[JudgedSetting]) -> JudgedSetting | None:
    """The fastest setting that keeps the budget; of those as fast within noise, the most exact."""
    kept = [each for each in settings if each.kept]
    if not kept:
        return None
    fastest = min(each.price for each in kept)
    return min((each for each in kept if each.price <= NOISE * fastest), key=lambda each: each.ratio)


def errors(reference: Reference, outcome: SettingOutcome) -> dict[ErrorQuantity, float]:
    """Quantity -> relative error; infinite for a number that does not exist."""
    found = {}
    for name, each in reference.limits.items():
        found[ErrorQuantity(name, False)] = abs(outcome.value(name) - each.value) / reference.scale(ErrorQuantity(name, False))
    for name, slopes in reference.slopes.items():
        worst = max((abs(outcome.slope(name, x) - each.value) * reference.sizes[x] for x, each in slopes.items()), default=0.0)
        found[ErrorQuantity(name, True)] = worst / reference.scale(ErrorQuantity(name, True))
    return {quantity: math.inf if math.isnan(error) else error for quantity, error in found.items()}


def pareto(points: Sequence[tuple[float, float]]) -> list[int]:
    """Numbers of the points (time, error) that no other dominates, by rising time; of equal points the first.

    A point dominates another if it is not larger in either and smaller in one. Points that are not finite belong to no set.
    """
    finite = [k for k, point in enumerate(points) if all(map(math.isfinite, point))]
    found, least = [], math.inf
    for k in sorted(finite, key=lambda k: points[k]):
        if points[k][1] < least:
            found.append(k)
            least = points[k][1]
    return found
