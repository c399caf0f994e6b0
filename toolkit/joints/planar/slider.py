"""Slider: a point of one body moves along a straight line fixed in the other, with or without its rotation locked."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import field_validator

from toolkit.description.description import Pair
from toolkit.description.quantity import Quantity
from toolkit.foundation.kernel import kernel
from toolkit.joints.joint import RowQuantity
from toolkit.joints.planar.joint import PointJoint
from toolkit.kinematics.planar import unit_vector
from toolkit.markers.component import Skeleton


@kernel
def offset_along(z, w, phi, phi_z, phi_zz, phi_zww):
    """phi = [e . d, angle_a - angle_b] with d = r_a - r_b, e = A(angle_b) (p_0, p_1), e' = J e, e'' = -e; J = [[0,-1],[1,0]]."""
    c, s = np.cos(z[5]), np.sin(z[5])
    e_x, e_y = c * z[6] - s * z[7], s * z[6] + c * z[7]
    d_x, d_y = z[0] - z[3], z[1] - z[4]
    along, across = e_x * d_x + e_y * d_y, -e_y * d_x + e_x * d_y
    phi[0] = along
    gradient = (e_x, e_y, -e_x, -e_y)
    turned = (-e_y, e_x, e_y, -e_x)
    turned_rate = 0 * z[0]
    for i in range(4):
        k = i if i < 2 else i + 1
        phi_z[0, k] = gradient[i]
        phi_zz[0, k, 5] = phi_zz[0, 5, k] = turned[i]
        phi_zww[0, k] = -gradient[i] * w[5] * w[5]
        turned_rate += gradient[i] * w[k]
    phi_z[0, 5], phi_zz[0, 5, 5] = across, -along
    phi_zww[0, 5] = -2 * turned_rate * w[5] - across * w[5] * w[5]
    turned_d_x, turned_d_y = c * d_x + s * d_y, -s * d_x + c * d_y
    rate_x, rate_y = w[0] - w[3], w[1] - w[4]
    turned_rate_x, turned_rate_y = c * rate_x + s * rate_y, -s * rate_x + c * rate_y
    phi_z[0, 6], phi_z[0, 7] = turned_d_x, turned_d_y
    phi_zz[0, 6, 5] = phi_zz[0, 5, 6] = turned_d_y
    phi_zz[0, 7, 5] = phi_zz[0, 5, 7] = -turned_d_x
    for i in range(2):
        k, sign = 3 * i, 1 - 2 * i
        phi_zz[0, 6, k] = phi_zz[0, k, 6] = sign * c
        phi_zz[0, 6, k + 1] = phi_zz[0, k + 1, 6] = sign * s
        phi_zz[0, 7, k] = phi_zz[0, k, 7] = -sign * s
        phi_zz[0, 7, k + 1] = phi_zz[0, k + 1, 7] = sign * c
    phi_zww[0, 6] = 2 * turned_rate_y * w[5] - turned_d_x * w[5] * w[5]
    phi_zww[0, 7] = -2 * turned_rate_x * w[5] - turned_d_y * w[5] * w[5]
    phi[1] = z[2] - z[5]
    phi_z[1, 2], phi_z[1, 5] = 1, -1


class AlongAxis(PointJoint):
    """Base of joints about an axis fixed in body b; the axis is given in the undeformed configuration.

    Attributes
    ----------
    axis
        Direction of the axis in the undeformed configuration, of any length.
    """

    axis: Annotated[Pair, Quantity("none")] = (1.0, 0.0)

    @field_validator("axis")
    @classmethod
    def _not_zero(cls, axis: Pair) -> Pair:
        if axis == (0.0, 0.0):
            raise ValueError("an axis needs a direction, for example [1, 0]")
        return axis


class Slider(AlongAxis):
    """phi = n . (r_a - r_b) = 0, n the normal of the axis: the point of body a slides along the axis fixed in body b.

    With `lock_rotation` also angle_a - angle_b = 0.

    Attributes
    ----------
    lock_rotation
        Whether the relative rotation is locked too.
    """

    kind = "slider"
    formula = offset_along

    lock_rotation: bool = False

    @property
    def rows(self) -> list[tuple[str, RowQuantity]]:
        """The normal direction, and the rotation if it is locked."""
        return [("normal", "length"), ("rotation", "angle")] if self.lock_rotation else [("normal", "length")]

    def parameters(self, _scene: Skeleton) -> list[Any]:
        """The normal."""
        x, y = unit_vector(np.array(self.axis))
        return [-y, x]
