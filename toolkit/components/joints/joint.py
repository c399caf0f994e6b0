"""Bases of all joints: their rows, and the points at which they grip their bodies; invalid rows are refused by name."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Annotated, ClassVar, Self

import numpy as np
from pydantic import model_validator

from toolkit.components.joints.kernels.laws import MOST_FORMS
from toolkit.components.joints.poses import PLANE, SPACE, PlanePoses, Poses, SpacePoses, plane_poses
from toolkit.components.joints.rows import BETWEEN, Row, RowQuantity, forms_of, row_numbers
from toolkit.components.markers.component import AboutAxis, AlongAxis, Component, Place, Skeleton, on_both
from toolkit.description.description import Description, Positive, Quantity, Scalar
from toolkit.foundation.errors import InputError
from toolkit.foundation.kinematics.orientation import unit_vector


class Joint(Component):
    """Constraints g(pose a, pose b) = f(t) between a marker on body a and one on body b: `constraint(scene)`, rows of forms of `poses`.

    A time curve is subtracted from the last row.

    Attributes
    ----------
    bodies
        Names of bodies a and b; `ground` is always there.
    """

    siblings: ClassVar[str] = "PlanarJoint or SpatialJoint"
    stated_by: ClassVar[str] = "constraint"

    bodies: tuple[str, str]

    @abstractmethod
    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """Rows of the joint.

        Without a scene their names and structure are right, their numbers need not be.
        """

    @property
    @abstractmethod
    def poses(self) -> Poses:
        """Poses of the two markers, of which the joint's rows are made."""

    @property
    def laws(self) -> list[Callable]:
        """Open formulas of the joint's rows."""
        return [row.law for row in self.constraint(None) if row.law is not None]

    @property
    def rows(self) -> Sequence[tuple[str, RowQuantity]]:
        """Name of each row of the constraint, for messages, and what the row measures; their number is the joint's size."""
        return [(row.name, row.quantity) for row in self.constraint(None)]

    @property
    def row_names(self) -> list[str]:
        """Names of the joint's rows."""
        return [name for name, _ in self.rows]

    @property
    @abstractmethod
    def curved(self) -> bool:
        """Whether the rows have second derivatives by the poses, or the poses such by what two bodies share."""

    def opening(self, _scene: Skeleton, _row: int, violation: float) -> float:
        """Size by which one row is open, in the unit of what it measures, where it is violated by so much."""
        return violation

    def parameters(self, scene: Skeleton) -> list[Scalar]:
        """Numbers that stand in the joint's rows."""
        return row_numbers(self.constraint(scene))

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: object) -> None:
        if cls.kind and cls.dimension and getattr(cls.constraint, "__isabstractmethod__", False):
            raise TypeError(
                f"{cls.__name__} has no `constraint`: state its rows as forms of the two poses, each with its name and what it "
                "measures, as the neighbouring files do."
            )
        super().__pydantic_init_subclass__(**kwargs)

    @model_validator(mode="after")
    def _two_bodies(self) -> Self:
        if self.bodies[0] == self.bodies[1]:
            raise ValueError(f"a joint ties two different bodies, not {self.bodies[0]!r} to itself")
        return self


class AtPoint(Description):
    """Base of joints at one point, which belongs to both bodies in the undeformed configuration; or at one point of each.

    Attributes
    ----------
    point
        Name of the point, or of the point on body a and that on body b.
    """

    bodies: tuple[str, str]
    point: Place

    @property
    def grips(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Bodies of the joint, each with the point where it is gripped."""
        first, second = on_both(self.point)
        return (self.bodies[0], first), (self.bodies[1], second)


class AtPoints(Description):
    """Base of joints that grip each body at a point of its own.

    Attributes
    ----------
    points
        Names of the point on body a and that on body b.
    """

    bodies: tuple[str, str]
    points: tuple[str, str]

    @property
    def grips(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Bodies of the joint, each with its own point."""
        return (self.bodies[0], self.points[0]), (self.bodies[1], self.points[1])

    def circles(self, _scene: Skeleton) -> list[tuple[int, float]]:
        """Circles of what rolls, for pictures: (number of the point, radius)."""
        return []

    def apart(self, scene: Skeleton) -> np.ndarray:
        """Vector from point b to point a in the undeformed configuration."""
        return scene.position(self.points[0]) - scene.position(self.points[1])


class JointBetweenPoints(AtPoints):
    """Base of joints that keep two points apart.

    Attributes
    ----------
    length
        L, in units of length; without it the distance in the undeformed configuration, which follows when a point moves.
    """

    length: Annotated[Positive | None, Quantity("length")] = None

    @model_validator(mode="after")
    def _two_points(self) -> Self:
        if self.points[0] == self.points[1]:
            raise ValueError(
                "a distance joint needs two different points; use a revolute (in space a spherical) joint to unite them"
            )
        return self

    def own_length(self, scene: Skeleton) -> Scalar:
        """Length that the joint keeps."""
        d = self.apart(scene)
        return np.sqrt(d @ d) if self.length is None else self.length


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


class Directed(AlongAxis, PlanarJoint):
    """Base of joints along an axis fixed in body b; the axis is given in the undeformed configuration.

    Attributes
    ----------
    axis
        Direction of the axis in the undeformed configuration, of any length.
    """

    @property
    def poses(self) -> PlanePoses:
        """Poses of the two markers, with the first axis along that of the joint and the second one its normal."""
        x, y = unit_vector(np.array(self.axis))
        return plane_poses(np.array([[x, -y], [y, x]]))


class DirectedAtPoint(Directed, PointJoint):
    """Base of joints along an axis at one point."""


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


NUMBERS, VECTORS = {2: 6, 3: 24}, {2: BETWEEN + 1, 3: 8}
"""Dimension -> those of the poses of both markers."""


def keeps_rows(joint: Joint, scene: Skeleton, known: Sequence[Row]) -> bool:
    """Whether the rows in this scene have the structure of the `known` ones.

    Other numbers may cut a profile into other pieces.
    """
    return [_structure(row) for row in joint.constraint(scene)] == [_structure(row) for row in known]


def check_rows(joint: Joint, scene: Skeleton) -> None:
    """Refuse rows that name what no pose has, or whose structure depends on the scene.

    Raises
    ------
    InputError
        Names the kind of the joint and the row.
    """
    rows = joint.constraint(scene)
    if [_structure(row) for row in rows] != [_structure(row) for row in joint.constraint(None)]:
        raise InputError(
            f"a {joint.kind!r} joint has other rows with a scene than without: `constraint(None)` gives the same names and terms as "
            "`constraint(scene)`, with any values."
        )
    for row in rows:
        _check_size(joint, row)
        for form in row.forms:
            places = [(place, NUMBERS[joint.dimension], "number") for place, _ in form.linear]
            places += [(vector, VECTORS[joint.dimension], "vector") for *pair, _ in form.pairs for vector in pair]
            for place, end, what in places:
                if not 0 <= place < end:
                    raise InputError(
                        f"row {row.name!r} of a {joint.kind!r} joint names {what} {place}; the poses of both markers have 0 to {end - 1}."
                    )


def _check_size(joint: Joint, row: Row) -> None:
    """Check the number of forms: one for a row without law, a few for a law."""
    count = len(row.forms)
    if row.law is None and count != 1:
        raise InputError(
            f"row {row.name!r} of a {joint.kind!r} joint has {count} forms and no law: a row is one form, or a law of forms."
        )
    if not 1 <= count <= MOST_FORMS:
        raise InputError(f"row {row.name!r} of a {joint.kind!r} joint has {count} forms, a law takes 1 to {MOST_FORMS}.")


def _structure(row: Row) -> tuple:
    """Everything of a row but its values."""
    terms = (([place for place, _ in form.linear], [pair[:2] for pair in form.pairs]) for form in row.forms)
    return (row.name, row.quantity, row.law, *terms)
