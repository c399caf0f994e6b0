"""Unit systems by name: the numbers are the user's, the labels come from here."""

from __future__ import annotations

from math import prod
from typing import NamedTuple

from toolkit.foundation.errors import InputError

_LABELS = {
    "mm-t-s": {
        "length": "mm", "time": "s", "mass": "t", "force": "N", "stress": "MPa", "density": "t/mm^3", "torque": "N mm",
        "energy": "mJ", "angle": "rad", "area": "mm^2", "second_moment": "mm^4", "rate": "1/s", "none": "",
        "velocity": "mm/s", "acceleration": "mm/s^2", "angular_velocity": "rad/s", "power": "mW",
    },
    "m-kg-s": {
        "length": "m", "time": "s", "mass": "kg", "force": "N", "stress": "Pa", "density": "kg/m^3", "torque": "N m",
        "energy": "J", "angle": "rad", "area": "m^2", "second_moment": "m^4", "rate": "1/s", "none": "",
        "velocity": "m/s", "acceleration": "m/s^2", "angular_velocity": "rad/s", "power": "W",
    },
}  # fmt: skip
UNIT_SYSTEMS = tuple(_LABELS)

LARGEST, SMALLEST = 1e20, 1e-60
"""Numbers of any unit system, but zero, lie between these, and products and quotients of several still are floating-point numbers."""


def unit(system: str, quantity: str) -> str:
    """Label of a quantity, for example `unit("mm-t-s", "stress")` is "MPa".

    Raises
    ------
    InputError
        The unit system is unknown.
    """
    if system not in _LABELS:
        raise InputError(f"unknown unit system {system!r}; available: {', '.join(UNIT_SYSTEMS)}.")
    return _LABELS[system][quantity]


class Dimension(NamedTuple):
    """Exponents of mass, length and time; an angle has none."""

    mass: int = 0
    length: int = 0
    time: int = 0

    def power(self, exponent: int) -> Dimension:
        """Dimension of a power of the quantity."""
        return Dimension(*(exponent * each for each in self))

    def times(self, other: Dimension) -> Dimension:
        """Dimension of the product with another quantity."""
        return Dimension(*(a + b for a, b in zip(self, other, strict=True)))


NONE = Dimension()
LABELLED = {
    "none": NONE, "angle": NONE, "length": Dimension(0, 1, 0), "time": Dimension(0, 0, 1), "mass": Dimension(1, 0, 0),
    "force": Dimension(1, 1, -2), "stress": Dimension(1, -1, -2), "density": Dimension(1, -3, 0), "torque": Dimension(1, 2, -2),
    "energy": Dimension(1, 2, -2), "area": Dimension(0, 2, 0), "second_moment": Dimension(0, 4, 0),
    "rate": Dimension(0, 0, -1), "velocity": Dimension(0, 1, -1), "acceleration": Dimension(0, 1, -2),
    "angular_velocity": Dimension(0, 0, -1), "power": Dimension(1, 2, -3),
}  # fmt: skip
"""Dimensions of the quantities that `toolkit.foundation.units` has labels for."""

_IN_KG_M_S = {"m-kg-s": (1.0, 1.0, 1.0), "mm-t-s": (1e3, 1e-3, 1.0)}
"""Units of mass, length and time of each system, in kg, m and s."""


def factor(dimension: Dimension, source: str, target: str) -> float:
    """Factor that turns a number in the units of `source` into one in those of `target`.

    Raises
    ------
    InputError
        A unit system is unknown.
    """
    for system in (source, target):
        if system not in _IN_KG_M_S:
            raise InputError(f"unknown unit system {system!r}; available: {', '.join(UNIT_SYSTEMS)}.")
    sizes = zip(dimension, _IN_KG_M_S[source], _IN_KG_M_S[target], strict=True)
    return float(prod((old / new) ** exponent for exponent, old, new in sizes))


def dimension_of_label(label: str, units: str) -> Dimension:
    """Dimension that a unit's label such as "MPa" stands for.

    Raises
    ------
    InputError
        The unit system has no quantity with this label.
    """
    found = [dimension for quantity, dimension in LABELLED.items() if unit(units, quantity) == label]
    if not found:
        raise InputError(f"the unit {label!r} is none of {units}, so that numbers in it cannot be converted. Fix the label.")
    return found[0]
