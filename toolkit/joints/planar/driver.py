"""Drivers: the relative angle, or the position along an axis, follows a time curve."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from toolkit.curves.curve import Curve
from toolkit.description.quantity import Quantity
from toolkit.foundation.kernel import kernel
from toolkit.joints.driven import Driven
from toolkit.joints.joint import RowQuantity
from toolkit.joints.planar.joint import PointJoint
from toolkit.joints.planar.slider import AlongAxis, offset_along
from toolkit.kinematics.planar import unit_vector
from toolkit.markers.component import Skeleton


@kernel
def relative_angle(z, w, phi, phi_z, phi_zz, phi_zww):
    """phi = angle_a - angle_b."""
    phi[0] = z[2] - z[5]
    phi_z[0, 2], phi_z[0, 5] = 1, -1


class AngleDriver(Driven, PointJoint):
    """phi = angle_a - angle_b - f(t): the relative rotation since the undeformed configuration follows the curve.

    Attributes
    ----------
    curve
        Relative rotation over time, in rad; smooth, and zero at the start.
    """

    kind = "angle-driver"
    formula = relative_angle
    curved = False

    curve: Annotated[Curve, Quantity("angle")]

    @property
    def rows(self) -> list[tuple[str, RowQuantity]]:
        """The rotation."""
        return [("rotation", "angle")]

    def parameters(self, _scene: Skeleton) -> list[Any]:
        """None."""
        return []


class PositionDriver(Driven, AlongAxis):
    """phi = e . (r_a - r_b) - f(t): the offset along the axis e fixed in body b follows the curve.

    Attributes
    ----------
    curve
        Offset along the axis over time, in units of length; smooth, and equal to the given offset at the start.
    """

    kind = "position-driver"
    formula = offset_along

    curve: Annotated[Curve, Quantity("length")]

    @property
    def rows(self) -> list[tuple[str, RowQuantity]]:
        """The axis."""
        return [("axis", "length")]

    def parameters(self, _scene: Skeleton) -> list[Any]:
        """The axis."""
        return list(unit_vector(np.array(self.axis)))
