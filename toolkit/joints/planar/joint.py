"""Base of all joints in the plane; a new joint is one such class with its rows."""

from __future__ import annotations

from typing import ClassVar

from toolkit.joints.joint import Joint
from toolkit.joints.places import AtPoint
from toolkit.joints.poses import PLANE, PlanePoses


class PlanarJoint(Joint):
    """Constraints between a marker on body a and one on body b in the plane: `constraint(scene)`, rows of forms of `poses`.

    Attributes
    ----------
    bodies
        Names of bodies a and b; `ground` is always there.
    """

    dimension: ClassVar[int] = 2

    @property
    def poses(self) -> PlanePoses:
        """Poses of the two markers in the plane, of which the joint's rows are made."""
        return PLANE

    @property
    def curved(self) -> bool:
        """Whether the rows have second derivatives by the poses."""
        return any(row.law is not None or any(form.pairs for form in row.forms) for row in self.constraint(None))


class PointJoint(AtPoint, PlanarJoint):
    """A joint at one point, which belongs to both bodies in the undeformed configuration; or at one point of each."""
