"""Base of all joints in space; a new joint is one such class with its rows."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar

from toolkit.joints.joint import Joint, RowQuantity
from toolkit.joints.kernels.spatial.forms import Row, forms_of, row_numbers
from toolkit.joints.places import AtPoint
from toolkit.markers.about_axis import AboutAxis
from toolkit.markers.component import Skeleton


class SpatialJoint(Joint):
    """Constraints between a marker on body a and one on body b: `constraint(scene)`, made of the forms in `forms`.

    Attributes
    ----------
    bodies
        Names of bodies a and b; `ground` is always there.
    """

    dimension: ClassVar[int] = 3
    stated_by: ClassVar[str] = "constraint"
    symbol: ClassVar[str] = "ball"
    """What it is drawn as, by a name of `render.space.symbols`; nothing if empty, as of what stands beside another joint."""

    @abstractmethod
    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """The rows; without a scene their names and structure are right, their numbers need not be."""

    @property
    def rows(self) -> list[tuple[str, RowQuantity]]:
        """Name and quantity of the constraint's rows; their number is the joint's size."""
        return [(row.name, row.quantity) for row in self.constraint(None)]

    @property
    def feels_axes(self) -> bool:
        """Whether a row has an axis in it."""
        forms = forms_of(self.constraint(None))
        places = [place // 3 for form in forms for place, _ in form.linear]
        return any(vector % 4 for vector in [*places, *(v for form in forms for pair in form.pairs for v in pair[:2])])

    def parameters(self, scene: Skeleton) -> list[Any]:
        """The numbers that stand in its rows."""
        return row_numbers(self.constraint(scene))


class SpatialPointJoint(AtPoint, SpatialJoint):
    """A joint at one point, which belongs to both bodies in the undeformed configuration; or at one point of each."""


class AxisJoint(AboutAxis, SpatialPointJoint):
    """A joint about or along an axis; it is the third axis of both markers."""
