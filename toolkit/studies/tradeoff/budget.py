"""Budgets: how large the relative error of each response, and of its gradient, may be."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from toolkit.foundation.errors import InputError, ToolkitError
from toolkit.foundation.listed_names import meant

DEFAULT = 1e-3
GRADIENT_SHARE = 10.0
"""A gradient's budget by default, in units of that of its response: an optimiser needs its direction, a reader all digits of the value."""
EVERY = "all"


class ErrorQuantity(NamedTuple):
    """What has a budget and an error: a response, or its gradient."""

    response: str
    derived: bool

    def __str__(self) -> str:
        return f"d({self.response})" if self.derived else self.response


class BudgetError(ToolkitError, ArithmeticError):
    """No setting keeps the budget."""


def read_budget(
    responses: Sequence[str], values: Iterable[str], gradients: Iterable[str], differentiated: bool
) -> dict[ErrorQuantity, float]:
    """Quantity -> largest relative error, from `RESPONSE=1e-3` and `all=1e-3`; what is not named has no limit.

    Nothing named means all responses. `d(RESPONSE)` among the values is the gradient, as among the gradients themselves.

    Raises
    ------
    InputError
        A response is unknown, a number is none or not positive, or there is no response to judge.
    """
    if not responses:
        raise InputError("the scene has no response to measure: name some in its table [responses].")
    texts = [_split(text) for text in values]
    derived = [(name[2:-1], limit) for name, limit in texts if name.startswith("d(") and name.endswith(")")]
    plain = [(name, limit) for name, limit in texts if not (name.startswith("d(") and name.endswith(")"))]
    own = _limits(responses, plain or [(EVERY, DEFAULT)])
    named = derived + [_split(text) for text in gradients]
    if named and not differentiated:
        raise InputError(
            "budgets of gradients need design variables: name some with --variables, or in the scene's table [design]."
        )
    slopes = _limits(responses, named) if named else {name: GRADIENT_SHARE * limit for name, limit in own.items()}
    found = {ErrorQuantity(name, False): limit for name, limit in own.items()}
    return found | ({ErrorQuantity(name, True): limit for name, limit in slopes.items()} if differentiated else {})


def _split(text: str) -> tuple[str, float]:
    name, _, number = (part.strip() for part in text.partition("="))
    try:
        limit = float(number)
    except ValueError:
        limit = math.nan
    if not (name and 0 < limit < math.inf):
        raise InputError(
            f"{text!r} is no budget: write RESPONSE=ERROR with a relative error above zero, for example {EVERY}=1e-3."
        )
    return name, limit


def _limits(responses: Sequence[str], named: list[tuple[str, float]]) -> dict[str, float]:
    """`all` first, so that single responses can differ from it."""
    found: dict[str, float] = {}
    for name, limit in sorted(named, key=lambda pair: pair[0] != EVERY or EVERY in responses):
        if name != EVERY and name not in responses:
            raise InputError(
                f"there is no response {name!r} to have a budget{meant(name, responses)}; the scene has "
                f"{', '.join(responses)}, and {EVERY}."
            )
        found |= dict.fromkeys(responses, limit) if name == EVERY and EVERY not in responses else {name: limit}
    return found
