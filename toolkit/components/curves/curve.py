"""Base of all time curves, with exact derivatives by time; they scale loads and lead drivers.

A curve's numbers may be complex (the complex step of the design derivatives); times are real, but for a check of the derivatives by time.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, SerializerFunctionWrapHandler, model_serializer
from pydantic_core import core_schema

from toolkit.description.description import Registered, Scalar
from toolkit.foundation.errors import SHORT, meant

if TYPE_CHECKING:
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

PLACEHOLDER = "any time curve"
"""Comment in a JSON schema of one class that stands for a curve of any kind."""
Rates = tuple[np.ndarray | Scalar, np.ndarray | Scalar, np.ndarray | Scalar]
"""Values f of a curve, and its derivatives f', f'' by time."""


def _any_curve(value: object) -> Curve:
    """Curve as it is, or one made from its table.

    Raises
    ------
    ValueError
        There is no such kind, or its table is wrong; pydantic puts the place before it.
    """
    if isinstance(value, Curve):
        return value
    if not isinstance(value, Mapping) or "type" not in value:
        raise ValueError(f"a time curve is a table with a `type`, one of: {', '.join(sorted(Curve.kinds))}")
    wanted = value["type"]
    kind = Curve.kinds.get(wanted) if isinstance(wanted, str) else None
    if kind is None:
        raise ValueError(
            f"type = {SHORT.repr(wanted)} is no kind of time curve{meant(str(wanted), Curve.kinds)}; "
            f"available: {', '.join(sorted(Curve.kinds))}"
        )
    found = kind.model_validate({key: item for key, item in value.items() if key != "type"})
    assert isinstance(found, Curve)
    return found


class CurvePart(NamedTuple):
    """A curve inside of another one, with the times between which it counts."""

    path: str
    curve: Curve
    shift: float = 0.0
    """Time of the whole when its own is zero."""
    begin: float = -np.inf
    end: float = np.inf


class Curve(Registered):
    """Base of all time curves; a new one is one subclass with `rates`, and with `corners` if it has some."""

    @abstractmethod
    def rates(self, time: np.ndarray) -> Rates:
        """f, f', f'' at the times, each (n_t,) or one number for all; complex-safe in the curve's numbers and in time.

        At a corner it may be those of either side.
        """

    def corners(self) -> tuple[Scalar, ...]:
        """Times where f, f', f'' or the third derivative jumps."""
        return ()

    def kink(self) -> str:
        """Sentence on where the slope jumps, and on what would be right; empty if it jumps nowhere.

        There is no second derivative where the slope jumps.
        """
        return ""

    @property
    def is_constant(self) -> bool:
        """Whether the curve has one value at all times."""
        return False

    def periods(self) -> tuple[float, ...]:
        """Periods of the oscillations that the curve holds, in time."""
        return ()

    def parts(self) -> tuple[CurvePart, ...]:
        """Curves that this curve is made of."""
        return ()

    def evaluate(self, time: np.ndarray) -> np.ndarray:
        """f, f', f'' at the times, shape (n_t, 3).

        At a corner that is hit exactly they are the mean of both sides, and so are their derivatives by the curve's numbers, as those
        of a central difference.
        """
        found = self._columns(time)
        hit = np.isin(np.real(time), np.real(np.array(self.corners())))
        if np.any(hit):
            left, right = (self._columns(_beside(time[hit], direction)) for direction in (-np.inf, np.inf))
            found = found.astype(np.result_type(found, left, right))
            found[hit] = _mean(left, right, found[hit], np.spacing(np.abs(np.real(time[hit]))))
        return found

    def _columns(self, time: np.ndarray) -> np.ndarray:
        return np.stack([np.broadcast_to(rate, time.shape) for rate in self.rates(time)], axis=1)

    @model_serializer(mode="wrap")
    def _with_type(self, plain: SerializerFunctionWrapHandler) -> dict[str, object]:
        """Table of the curve as a file would have it, with its `type`."""
        return {"type": self.kind, **plain(self)}

    @classmethod
    def __get_pydantic_core_schema__(cls, source: type, handler: GetCoreSchemaHandler) -> CoreSchema:
        """A field of the base takes a curve of any kind, or its table with the `type`; one of a kind takes that kind."""
        return handler(source) if cls.kind else core_schema.no_info_plain_validator_function(_any_curve)

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """The schema of files puts the kinds in the place of a curve of any kind."""
        return handler(schema) if cls.kind else {"$comment": PLACEHOLDER}


def _mean(left: np.ndarray, right: np.ndarray, here: np.ndarray, apart: np.ndarray) -> np.ndarray:
    """Mean of both sides (n, 3), which were evaluated a little `apart` (n,).

    Where f or f' does not jump it is what it is `here`.
    """
    mean = (left + right) / 2
    reach = 4 * apart[:, None] * np.maximum(np.abs(np.real(left)), np.abs(np.real(right)))[:, 1:]
    alike = np.abs(np.real(right - left))[:, :2] <= reach
    mean[:, :2] += np.where(alike, np.real(here - mean)[:, :2], 0)
    return mean


def _beside(time: np.ndarray, direction: float) -> np.ndarray:
    """Numbers next to the times, on one side; imaginary parts stay."""
    return np.nextafter(np.real(time), direction) + (1j * np.imag(time) if np.iscomplexobj(time) else 0)
