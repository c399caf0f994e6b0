"""Base of all joints in space; a new joint is one such class with its rows."""

from __future__ import annotations

from typing import ClassVar

from toolkit.joints.joint import Joint
from toolkit.joints.places import AtPoint
from toolkit.joints.poses import SPACE, SpacePoses
from toolkit.joints.rows import forms_of
from toolkit.markers.about_axis import AboutAxis


class SpatialJoint(Joint):
    """Constraints between a marker on body a and one on body b in space: `constraint(scene)`, rows of forms of `poses`.

    Attributes
    ----------
    bodies
        Names of bodies a and b; `ground` is always there.
    """

    dimension: ClassVar[int] = 3
    symbol: ClassVar[str] = "ball"
    """Symbol that the joint is drawn as, by a name of `render.space.symbols`; nothing if empty, as of what stands beside another
    joint."""

    @property
    def poses(self) -> SpacePoses:
        """Poses of the two markers in space, of which the joint's rows are made."""
        return SPACE

    @property
    def curved(self) -> bool:
        """Whether the rows have second derivatives: always, as the pose itself is curved in the coordinates."""
        return True

    @property
    def feels_axes(self) -> bool:
        """Whether a row of the joint has an axis in it."""
        forms = forms_of(self.constraint(None))
        places = [place // 3 for form in forms for place, _ in form.linear]
        return any(vector % 4 for vector in [*places, *(v for form in forms for pair in form.pairs for v in pair[:2])])


class SpatialPointJoint(AtPoint, SpatialJoint):
    """A joint at one point, which belongs to both bodies in the undeformed configuration; or at one point of each."""


class AxisJoint(AboutAxis, SpatialPointJoint):
    """A joint about or along an axis; it is the third axis of both markers."""
