"""Units in which numbers are short: 9.74 MPa instead of 9.74e6 Pa."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.foundation.units import unit

_LADDERS = (
    {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
    {"N": 1.0, "kN": 1e3, "MN": 1e6},
    {"N mm": 1e-3, "N m": 1.0, "kN m": 1e3, "MN m": 1e6},
    {"mJ": 1e-3, "J": 1.0, "kJ": 1e3, "MJ": 1e6},
    {"mW": 1e-3, "W": 1.0, "kW": 1e3, "MW": 1e6},
    {"mm": 1e-3, "m": 1.0},
)
"""Units of one quantity, from the smallest to the largest."""
_LEAST, _MOST = 1e-2, 1e4
"""Sizes between which a number is short in its own unit."""


class Readable(NamedTuple):
    """Factor by which numbers are multiplied for a picture, and the label of their unit then."""

    factor: float
    label: str


def readable(largest: float, label: str) -> Readable:
    """Unit in which numbers are written in a picture.

    Parameters
    ----------
    largest : float
        Size of the largest of the numbers, not negative.
    label : str
        Of their own unit; one that has no neighbours stays.

    Returns
    -------
    factor, label : Readable
        The own unit where the largest number is short in it; else the largest unit in which it is not below 1.
    """
    ladder = next((each for each in _LADDERS if label in each), {})
    if not ladder or not np.isfinite(largest) or largest == 0 or _LEAST <= largest < _MOST:
        return Readable(1.0, label)
    size = largest * ladder[label]
    chosen = max(
        (name for name in ladder if ladder[name] <= size), key=ladder.__getitem__, default=min(ladder, key=ladder.__getitem__)
    )
    return Readable(ladder[label] / ladder[chosen], chosen)


def readable_stress(limit: float, units: str) -> Readable:
    """Readable unit for stresses up to a limit, in a system of units."""
    return readable(limit, unit(units, "stress"))
