"""Components between two bodies: which bodies joints and loads grip where, their parameters, their axes, and their compiled formula."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Annotated, ClassVar, Protocol

import numpy as np
from pydantic import field_validator

from toolkit.components.curves.curve import Curve
from toolkit.description.description import Description, InSpace, Pair, Quantity, Scalar, Triple
from toolkit.foundation.kinematics.orientation import axes_along

Place = str | tuple[str, str]
"""A point that both bodies share, or each body's own point, where two flexible bodies meet."""


def on_both(place: Place) -> tuple[str, str]:
    """Names of the point on the first body and of that on the second."""
    return (place, place) if isinstance(place, str) else place


class Skeleton(Protocol):
    """Interface of a scene to its components: where the points are in the undeformed configuration."""

    def position(self, point: str) -> np.ndarray:
        """Undeformed global position of a point, shape (d,)."""


class Component(InSpace):
    """Base of joints and loads, with its compiled law, its parameters, and the bodies that it grips.

    `formula` of a load is the compiled law of its kind with all its derivatives; a subclass without one cannot be created. Its parameters
    enter the formula as arguments behind the two poses, so that their design derivatives come with the formula's. Joints state rows.
    """

    formula: ClassVar[Callable]
    stated_by: ClassVar[str] = "formula"
    """Name of the attribute by which a kind of component states its law."""

    @classmethod
    def law(cls) -> Callable:
        """Compiled formula of the component's law.

        Reached through an instance it would be bound to it, another one for each component.
        """
        return cls.formula

    @property
    @abstractmethod
    def grips(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Points that the component grips: (body, point) of marker a and of marker b."""

    @abstractmethod
    def parameters(self, scene: Skeleton) -> list[Scalar]:
        """Parameters of the component, real or complex.

        They are the numbers behind the two poses in the formula's arguments, of a joint those of its rows.
        """

    @property
    def axes(self) -> np.ndarray | None:
        """Axes (3, 3) of the component's markers in the undeformed configuration, as columns; None for those of space."""
        return None

    @property
    def feels_axes(self) -> bool:
        """Whether the component asks for more than the positions of its markers, in space; a needless True costs time alone."""
        return True

    @property
    def time_curve(self) -> Curve | None:
        """Time curve that drives or scales the component."""
        return None

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: object) -> None:
        if cls.kind and not hasattr(cls, cls.stated_by):
            raise TypeError(
                f"{cls.__name__} has no `{cls.stated_by}`: state the law and all its derivatives as one compiled function, "
                "as the neighbouring files do; a derivative that nobody wrote must not pass for zero."
            )
        super().__pydantic_init_subclass__(**kwargs)


class AboutAxis(Description):
    """Base of components about or along an axis; it is the third axis of both markers.

    Attributes
    ----------
    axis
        Direction of the axis in the undeformed configuration, of any length.
    """

    axis: Annotated[Triple, Quantity("none")]

    @field_validator("axis")
    @classmethod
    def _not_zero(cls, axis: Triple) -> Triple:
        if not any(axis):
            raise ValueError("an axis needs a direction, for example [0, 0, 1]")
        return axis

    @property
    def axes(self) -> np.ndarray:
        """Axes of the markers, (3, 3) as columns, the third one along the axis."""
        return axes_along(self.axis)


class AlongAxis(Description):
    """Base of components along an axis fixed in body b; the axis is given in the undeformed configuration.

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
