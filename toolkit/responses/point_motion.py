"""Velocities, accelerations, distances and deflections of points, and the angular velocity of a body."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from toolkit.components.bodies.model_body import ModelBody
from toolkit.foundation.errors import InputError
from toolkit.responses.marker_formula import MarkerFormula, MarkerVector, Motion, one_of, place_of, refuse_component
from toolkit.responses.response import Instant, OnePoint, Partials
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.dependence import items_of
from toolkit.system.quantities import STEP
from toolkit.system.solution import Solution, elastic_coordinates, flexible_body

if TYPE_CHECKING:
    from toolkit.scene.resolution import ResolvedScene


class OfRates(Instant):
    """Base of responses that are made of velocities or accelerations."""

    @property
    def needs_motion(self) -> bool:
        """Whether the response exists for a transient solution only: always true, as rates are zero at rest."""
        return True

    def check(self, scene: ResolvedScene) -> None:
        """Refuse rates in a quasi-static run, whose velocities are those between one equilibrium and the next.

        Raises
        ------
        InputError
            Says what can be asked for instead.
        """
        super().check(scene)
        if scene.solver.quasi_static:
            raise InputError(
                f"a quasi-static run (solver.quasi_static) knows no {self.kind}: it goes from one equilibrium to the next, and its "
                "velocities are those between them. Ask for places and angles, or run with inertia."
            )


class PointVector(OfRates, OnePoint, MarkerVector):
    """Base of vectors of one point of a body in global axes, of which a kind names the part of the point's motion."""

    part: ClassVar[Literal["rate", "acceleration"]]

    def formula(self, *motions: Motion) -> tuple[np.ndarray, Sequence[Motion]]:
        """Translational components of the chosen part of the motion, and their derivatives; rotations or axes follow them."""
        values = getattr(motions[0], self.part)
        d = dimension_of(values)
        return values[:d], [Motion(**{self.part: np.eye(d, len(values))})]


class Velocity(PointVector):
    """Velocity of a point of a body in global axes: one component, or its magnitude."""

    kind = "velocity"
    quantity = "velocity"
    part = "rate"


class Acceleration(PointVector):
    """Acceleration of a point of a body in global axes: one component, or its magnitude; gravity is not part of it. That of the scheme
    `paper` lags behind by a part of a step, so that it is of first order.
    """

    kind = "acceleration"
    quantity = "acceleration"
    part = "acceleration"


class AngularVelocity(OfRates, OnePoint, MarkerFormula):
    """Angular velocity of a body at a point: in the plane its rate of rotation, in space a component in global axes or its magnitude.

    In space it is omega = 1/2 sum_i e_i x e_i' with the body's axes e_i. Where a body deforms, its points turn differently.

    Attributes
    ----------
    component
        In space: one component, or the magnitude.
    """

    kind = "angular-velocity"
    quantity = "angular_velocity"

    component: Literal["x", "y", "z", "magnitude"] | None = None

    def check(self, scene: ResolvedScene) -> None:
        """Refuse a component in the plane, and its absence in space.

        Raises
        ------
        InputError
            It is missing there, or given in the plane.
        """
        super().check(scene)
        if scene.space.rotations_add != (self.component is None):
            raise InputError(
                'an angular velocity in space needs a `component`: "x", "y", "z" or "magnitude"; one in the plane has none.'
            )

    @property
    def chosen(self) -> int | None:
        """Number of the component in space, None for the magnitude; the only value in the plane."""
        return 0 if self.component is None else place_of(self.component)

    def formula(self, *motions: Motion) -> tuple[np.ndarray, Sequence[Motion]]:
        """Angular velocity from the body's axes and their rates, and its derivatives by both."""
        y, rate = motions[0].y, motions[0].rate
        if dimension_of(y) == 2:
            return rate[2:], [Motion(rate=np.eye(3)[2:])]
        omega = sum((np.cross(y[k : k + 3], rate[k : k + 3]) for k in (3, 6, 9)), np.zeros(3)) / 2
        by_y, by_rate = (np.zeros((3, 12), y.dtype) for _ in range(2))
        for k in (3, 6, 9):
            by_y[:, k : k + 3], by_rate[:, k : k + 3] = -skew(rate[k : k + 3]) / 2, skew(y[k : k + 3]) / 2
        return omega, [Motion(y=by_y, rate=by_rate)]


def dimension_of(pose: np.ndarray) -> int:
    """Dimension of space, 2 or 3, from the length of a pose."""
    return 2 if len(pose) == 3 else 3


def skew(vector: np.ndarray) -> np.ndarray:
    """Matrix (3, 3) of the cross product with a vector from the left."""
    x, y, z = vector
    zero = 0 * x
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]])


class PointDistance(MarkerVector):
    """Distance of two points of two bodies: its length, or a component of the way from the first to the second in global axes.

    Attributes
    ----------
    bodies
        Both bodies; one may be the ground.
    points
        The point on the first and that on the second.
    """

    kind = "distance"
    quantity = "length"

    bodies: tuple[str, str]
    points: tuple[str, str]

    @model_validator(mode="after")
    def _two_places(self) -> Self:
        first, second = self.points
        if self.bodies[0] == self.bodies[1] and first == second:
            raise ValueError(
                f"point {first!r} of {self.bodies[0]!r} has no distance from itself; name two bodies, or two points of one"
            )
        return self

    def markers(self) -> tuple[tuple[str, str], ...]:
        """Pairs of body and point: each point on its body."""
        return tuple(zip(self.bodies, self.points, strict=True))

    def formula(self, *motions: Motion) -> tuple[np.ndarray, Sequence[Motion]]:
        """Vector r_b - r_a from the first point to the second, and its derivatives by both motions."""
        a, b = (motion.y for motion in motions)
        d = dimension_of(a)
        side = np.eye(d, len(a))
        return b[:d] - a[:d], [Motion(y=-side), Motion(y=side)]


class Deflection(Instant):
    """Displacement of a point of a flexible body by its deformation alone, in the axes of the body's own frame: u = Z q_f.

    What it is measured from is the body's reference condition, which `ffrf inspect` names: a clamp, mean axes or a chord.

    Attributes
    ----------
    body
        Name of a flexible body.
    point
        Name of an interface point on it.
    component
        One component in the axes of the body's reduced model, or the magnitude.
    """

    kind = "deflection"
    quantity = "length"

    body: str
    point: str
    component: Literal["x", "y", "z", "magnitude"] = "magnitude"

    def check(self, scene: ResolvedScene) -> None:
        """Refuse a body that is rigid or has several frames, a point that is none of it, and a z component in the plane."""
        super().check(scene)
        refuse_component(self.component, scene, self.kind)
        found = flexible_body(scene, self.body)
        if found.parted:
            raise InputError(
                f"the deflection of body {self.body!r} is that in its own frame, and it has several: no frame is that of the whole body. "
                'Ask for the displacement of the point (type = "displacement"), or leave `frames` out.'
            )
        found.point(scene, self.point, self.body)

    def at(self, solution: Solution, step: int) -> Partials:
        """Component or magnitude of Z q_f at a step, with its partial derivatives."""
        return self.instants(solution)(step)

    def instants(self, solution: Solution) -> Callable[[int], Partials]:
        """Component or magnitude of Z q_f, step by step; Z and its design derivatives are found once for all steps."""
        system, where = solution.system, elastic_coordinates(solution, self.body)
        shape, shape_x = self._shape(system.scene), list[tuple[int, np.ndarray]]()
        for x, variable in enumerate(system.design):
            affected = items_of(system.scene, variable.paths, system.numbering.users)
            if not affected.isdisjoint({("bodies", self.body), ("points", self.point)}):
                moved = self._shape(system.scene.moved(variable, 1j * STEP))
                shape_x.append((x, np.imag(moved) / STEP))

        def look(step: int) -> Partials:
            q_f = solution.q[step, where]
            slope: np.ndarray = np.zeros((len(shape), system.n_q), system.dtype)
            slope[:, where] = shape
            design = np.zeros((len(shape), system.n_x))
            for x, change in shape_x:
                design[:, x] = change @ np.real(q_f)
            return one_of(Partials(shape @ q_f, q=slope, design=design), place_of(self.component), solution, step)

        return look

    def _shape(self, scene: ResolvedScene) -> np.ndarray:
        body = scene.bodies[self.body]
        assert isinstance(body, ModelBody)
        return body.point(scene, self.point, self.body)[0][:, 1:]
