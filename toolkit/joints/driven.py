"""Base of drivers in the plane and in space: a joint coordinate that follows a time curve."""

from __future__ import annotations

from pydantic import field_validator

from toolkit.curves.catalogue import Curve
from toolkit.description.description import Description


def smooth(curve: Curve) -> Curve:
    """Refuse a curve without second derivative: the acceleration of what it drives would not exist."""
    if why := curve.kink():
        raise ValueError(f"a driver needs a curve with a second derivative; {why}")
    return curve


class Driven(Description):
    """Base of drivers: a joint coordinate follows a curve; each kind says what the curve's values measure.

    Attributes
    ----------
    curve
        The joint coordinate over time.
    """

    curve: Curve
    _smooth = field_validator("curve")(smooth)

    @property
    def time_curve(self) -> Curve:
        """Time curve that the joint coordinate follows."""
        return self.curve
