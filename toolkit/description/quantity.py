"""Measure of a number, said beside its field: `mass: Annotated[Positive, Quantity("mass")]`."""

from __future__ import annotations

from typing import Any, NamedTuple

from toolkit.foundation.dimensions import LABELLED, NONE, Dimension
from toolkit.foundation.errors import InputError

ANGLE = "angle"
"""The one word without dimension that has a unit nevertheless."""


class Measure(NamedTuple):
    """Measure of one number: its dimension, and the power of an angle, which has a unit but no dimension."""

    dimension: Dimension
    angle: int = 0


class Quantity:
    """Measure of the numbers of a field: of all of them in one, or of each in its order.

    Words are those of `toolkit.foundation.dimensions.LABELLED`; factors stand apart by spaces, a slash divides by what follows it:
    "mass", "mass length^2", "length/time^2", "1/time", "none". Conversion of units, labels of gradients, schema and documentation read it.

    Parameters
    ----------
    each : one text for all numbers of the field, or one for each; none at all for what the owner of the record says of it

    Raises
    ------
    InputError
        A word names no quantity; lists those that do.
    """

    def __init__(self, *each: str) -> None:
        self.each = each
        self._measures = [_measure(text) for text in each]

    @property
    def of_owner(self) -> bool:
        """Whether the measure is said where the record stands, as that of the values of a time curve is."""
        return not self.each

    def measure_of(self, values: Measure, place: int = 0) -> Measure:
        """Measure of the number at a place of a field; `values` is what the owner of the record says that its values measure."""
        return values if self.of_owner else self.measure(place)

    def measure(self, place: int = 0) -> Measure:
        """Measure of the number at a place of a list, or of all numbers where one text stands for all."""
        return self._measures[place if len(self._measures) > 1 else 0]

    def __get_pydantic_json_schema__(self, core_schema: Any, handler: Any) -> dict[str, Any]:
        """JSON schema of the field with its measure in words, for those who write a file."""
        schema = handler(core_schema)
        if any(text != "none" for text in self.each) and "$ref" not in schema:
            schema["description"] = ", ".join(self.each)
        return schema


class PerTime(Quantity):
    """Coefficients of a polynomial of time: what its values measure, per time to the power of the place."""

    def measure_of(self, values: Measure, place: int = 0) -> Measure:
        """Measure of the coefficient at a place: `values` per time to the power of the place.

        The first coefficient is a value itself.
        """
        return Measure(values.dimension.times(LABELLED["time"].power(-place)), values.angle)


class OverAngle(Quantity):
    """Values of a curve whose argument is an angle where others have their time."""


OF_OWNER = Quantity()
"""Measure of a value of a time curve, which is said where the curve stands."""
OF_OWNER_PER_TIME = PerTime()
"""Measure of coefficients of a polynomial of time, which is said where the curve stands."""


def _measure(text: str) -> Measure:
    """Measure that a text such as "force time/length" stands for."""
    found, angle = NONE, 0
    for k, factors in enumerate(text.split("/")):
        for word in factors.split():
            name, _, power = word.partition("^")
            exponent = int(power or 1) * (-1 if k else 1)
            if name not in LABELLED and name != "1":
                raise InputError(
                    f"{text!r} names no quantity; its words are {', '.join(LABELLED)}, with powers such as length^2."
                )
            found = found.times(LABELLED.get(name, NONE).power(exponent))
            angle += exponent * (name == ANGLE)
    return Measure(found, angle)
