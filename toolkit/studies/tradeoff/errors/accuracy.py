"""Errors of a setting relative to the reference, of responses and of their gradients.

With the reference R, g and the size s_x of what a relative change of the variable x refers to

    error of a response R_k:    |R_k - R| / |R|
    error of its gradient g_k:  max_x |g_k,x - g_x| s_x / max_x |g_x| s_x

so that a derivative which happens to be near zero is compared with those that matter. Where the denominator is less than
`reference.NEGLIGIBLE` of the other one, as that of a response which is zero, this part of the other one takes its place.
"""

from __future__ import annotations

import math

from toolkit.studies.tradeoff.errors.reference import Reference
from toolkit.studies.tradeoff.errors.studied import Studied
from toolkit.studies.tradeoff.settings.record import Record


def errors(reference: Reference, record: Record) -> dict[Studied, float]:
    """Studied number -> relative error; infinite for a number that does not exist."""
    found = {}
    for name, each in reference.limits.items():
        found[Studied(name, False)] = abs(record.value(name) - each.value) / reference.scale(Studied(name, False))
    for name, slopes in reference.slopes.items():
        worst = max((abs(record.slope(name, x) - each.value) * reference.sizes[x] for x, each in slopes.items()), default=0.0)
        found[Studied(name, True)] = worst / reference.scale(Studied(name, True))
    return {quantity: math.inf if math.isnan(error) else error for quantity, error in found.items()}
