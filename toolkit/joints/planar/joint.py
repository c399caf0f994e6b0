"""Base of all joints; a new joint is one such class with its constraint and the constraint's derivatives by the two poses."""

from __future__ import annotations

from typing import ClassVar

from pydantic import model_validator

from toolkit.joints.places import AtPoint
from toolkit.markers.component import Component


class Joint(Component):
    """A constraint g(pose a, pose b, parameters) = f(t) between two bodies.

    `formula(z, w, phi, phi_z, phi_zz, phi_zww)` (see `joint_kernel`) fills g, g_z, g_zz and d(w^T g_zz w)/dz; if g is linear in the
    poses, `curved` is False and the last two stay zero. A time curve is subtracted from the last row.

    Attributes
    ----------
    bodies
        Names of bodies a and b; `ground` is always there.
    """

    curved: ClassVar[bool] = True

    bodies: tuple[str, str]

    @property
    def row_names(self) -> list[str]:
        """Names of the constraint's rows, for messages; their number is the joint's size."""
        raise NotImplementedError

    @model_validator(mode="after")
    def _two_bodies(self) -> Joint:
        if self.bodies[0] == self.bodies[1]:
            raise ValueError(f"a joint ties two different bodies, not {self.bodies[0]!r} to itself")
        return self


class PointJoint(AtPoint, Joint):
    """A joint at one point, which belongs to both bodies in the undeformed configuration; or at one point of each."""
