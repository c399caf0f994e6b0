"""Base of all joints, which promises nothing about the space that they are in."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar, Literal, Self, get_args

from pydantic import model_validator

from toolkit.markers.component import Component

RowQuantity = Literal["length", "angle"]
"""What a row of a constraint measures."""
ROW_QUANTITIES = get_args(RowQuantity)


class Joint(Component):
    """A constraint g(pose a, pose b) = f(t) between two bodies; a time curve is subtracted from its last row.

    Attributes
    ----------
    bodies
        Names of bodies a and b; `ground` is always there.
    """

    siblings: ClassVar[str] = "PlanarJoint or SpatialJoint"
    curved: ClassVar[bool] = True
    """Whether the rows have second derivatives by the poses."""

    bodies: tuple[str, str]

    @property
    @abstractmethod
    def rows(self) -> Sequence[tuple[str, RowQuantity]]:
        """Name of each row of the constraint, for messages, and what the row measures; their number is the joint's size."""

    @property
    def row_names(self) -> list[str]:
        """Names of the rows."""
        return [name for name, _ in self.rows]

    @model_validator(mode="after")
    def _two_bodies(self) -> Self:
        if self.bodies[0] == self.bodies[1]:
            raise ValueError(f"a joint ties two different bodies, not {self.bodies[0]!r} to itself")
        return self
