"""Unit systems by name: the numbers are the user's, the labels come from here."""

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
