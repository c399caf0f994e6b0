"""What drivers in the plane and in space share: a joint coordinate that follows a time curve."""

from __future__ import annotations

from pydantic import field_validator

from toolkit.description.description import Description
from toolkit.description.profile import Curve, is_smooth


def smooth(curve: Curve) -> Curve:
    """Refuse a curve without second derivative: the acceleration of what it drives would not exist."""
    if not is_smooth(curve):
        raise ValueError("a driver needs a curve with a second derivative; use interpolation = 'cubic' or a smooth-step")
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
        """The curve that is followed."""
        return self.curve
