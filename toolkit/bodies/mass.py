"""Mass of rigid bodies in the plane and in space: a given one, or that of a uniform rod."""

from __future__ import annotations

from typing import Annotated

from toolkit.bodies.body import Body
from toolkit.description.description import Positive
from toolkit.description.quantity import Quantity


class GivenMass(Body):
    """Base of rigid bodies with explicit mass properties; the centre of mass is a point of the scene.

    Attributes
    ----------
    mass
        Mass of the body.
    center
        Point of the scene where the centre of mass is.
    """

    proportional = ("mass", "inertia")

    mass: Annotated[Positive, Quantity("mass")]
    center: str


class UniformRod(Body):
    """Base of uniform rods between two points.

    Attributes
    ----------
    between
        Points of the scene at its ends.
    area
        Area of the section, in length^2.
    density
        Mass/length^3.
    """

    proportional = ("density",)

    between: tuple[str, str]
    area: Annotated[Positive, Quantity("area")]
    density: Annotated[Positive, Quantity("density")]
