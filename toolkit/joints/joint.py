"""Base of all joints, in the plane and in space alike."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar, Self

from pydantic import model_validator

from toolkit.joints.poses import Poses
from toolkit.joints.rows import Row, RowQuantity, row_numbers
from toolkit.markers.component import Component, Skeleton


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
    def laws(self) -> list[Any]:
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

    def opening(self, _scene: Skeleton, _row: int, violation: Any) -> Any:
        """Size by which one row is open, in the unit of what it measures, where it is violated by so much."""
        return violation

    def parameters(self, scene: Skeleton) -> list[Any]:
        """Numbers that stand in the joint's rows."""
        return row_numbers(self.constraint(scene))

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
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
