"""Flexible bodies from a reduced-model file, with a moving frame or grounded."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import ConfigDict, Field, model_validator

from toolkit.bodies.body import ConstantNumbers, Placed
from toolkit.bodies.chain_strains import chain_strains
from toolkit.bodies.cut.cuttable_body import CuttableBody
from toolkit.bodies.model_body import is_zero
from toolkit.bodies.planar.body import FloatingNumbers, MarkerNumbers
from toolkit.bodies.planar.start_velocity import StartVelocity
from toolkit.description.description import Number, Pair
from toolkit.description.quantity import Quantity
from toolkit.kinematics.planar import rotation
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.entries.elastic import ElasticMatrices, elastic_matrices
from toolkit.reduced_model.model import Invariants, generalized_lengths

ACROSS = np.array([0.0, 0.0, 1.0])
"""The axis of all rotations in the plane."""


class Flexible(CuttableBody, StartVelocity):
    """A flexible body, which moves with its frame. `frame = "grounded"` fixes the reference condition (the clamp of its model) to the
    ground: then no frame coordinates exist, and no joint can move the body as a whole.

    Any parameter of the reduced model (thickness, youngs_modulus, ...) can be given by name and replaces its nominal value.

    Attributes
    ----------
    frame
        Whether the reference condition moves or is fixed to the ground.
    position
        Where the origin of the reduced model lies at the start, in units of length.
    angle
        Rotation of the reduced model's axes at the start, in rad.
    deflection
        Point of the body -> u_x, u_y, its displacement at the start since the undeformed body, in the axes of the reduced model, in units
        of length: what a response of the type `deflection` tells at time 0. The rest of the body takes the shape of least strain energy,
        as if forces at these points had bent it and let go. Statics, and `solver.start = "equilibrium"`, find their own shape.
    elastic_velocity
        Point of the body -> velocity of that displacement at the start, in length/time; the rest of the body moves in the shape of least
        strain energy. It holds, or is refused if the joints do not allow it; left out, the body starts with the velocities that the
        joints ask for, and without deforming where it can.
    """

    kind = "flexible"
    model_config = ConfigDict(extra="allow")  # against the base of all bodies, which allows none

    frame: Literal["moving", "grounded"] = "moving"
    position: Annotated[Pair, Quantity("length")] = (0.0, 0.0)
    angle: Annotated[Number, Quantity("angle")] = 0.0
    deflection: Annotated[dict[str, Pair], Quantity("length")] = Field(default_factory=dict)
    elastic_velocity: Annotated[dict[str, Pair], Quantity("length/time")] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _still(self) -> Flexible:
        if self.frame == "grounded" and any(self.frame_velocity()):
            raise ValueError('a grounded body cannot have a `velocity`; write frame = "moving", or leave it out')
        return self

    def means(self, field: str) -> bool:
        """Whether a field's numbers mean something, which velocities of a grounded body do not."""
        return super().means(field) and (self.has_frame or field not in ("velocity", "angular_velocity"))

    @property
    def has_frame(self) -> bool:
        """Whether the body has frame coordinates, which only a moving frame has."""
        return self.frame == "moving"

    @property
    def placement(self) -> np.ndarray:
        """Rotation matrix of the reduced model's axes at the start, (2, 2)."""
        return rotation(self.angle)

    def frame_axes(self, q: np.ndarray) -> np.ndarray:
        """Rotation matrix (2, 2) of the frame, by its angle among the body's coordinates (n,)."""
        return rotation(q[2])

    @property
    def deflected(self) -> Mapping[str, Mapping[str, tuple[Any, ...]]]:
        """Displacements of points at the start and their velocities as the scene writes them, by keys of the body's table."""
        return {"deflection": self.deflection, "elastic_velocity": self.elastic_velocity}

    def undeforming_point(self, width: int) -> tuple[np.ndarray, np.ndarray]:
        """Two zero positions and a zero angle, with `width` columns each."""
        return np.zeros((2, width)), np.zeros(width)

    @property
    def start_spin(self) -> np.ndarray:
        """Angular velocity omega at the start as a vector across the plane, (3,)."""
        return self.frame_velocity()[2] * ACROSS

    @property
    def only_axis(self) -> np.ndarray:
        """Axis that the frame turns about, across the plane, (3,)."""
        return ACROSS

    def spins(self, _q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Angular velocity omega of the frame as vectors across the plane, (n_t, 3)."""
        return v[:, 2, None] * ACROSS

    def position_at_rest(self, scene: Placed, point: str, name: str) -> np.ndarray:
        """Undeformed global position of an interface point, (2,)."""
        return np.array(self.position) + rotation(self.angle) @ self.point(scene, point, name)[0][:, 0]

    def nominal(self, scene: Placed) -> Invariants:
        """Invariants at the nominal design."""
        inv = scene.model(self.model).invariants
        assert isinstance(inv, Invariants)
        return inv

    def coordinate_names(self, scene: Placed) -> list[str]:
        """Names of the frame's coordinates, and of the elastic ones by their numbers."""
        elastic = [f"elastic coordinate {k}" for k in range(scene.model(self.model).n_f)]
        return ["x", "y", "rotation", *elastic] if self.has_frame else elastic

    def initial_state(self, scene: Placed) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and velocities at the start: the frame at its written place, the elastic ones in the given shape."""
        shape, rate = self.start_shapes(scene)
        if not self.has_frame:
            return shape, rate
        return np.concatenate([[*self.position, self.angle], shape]), np.concatenate([self.frame_velocity(), rate])

    def coordinate_lengths(self, scene: Placed) -> np.ndarray:
        """RMS displacement of the body per unit elastic coordinate."""
        elastic = generalized_lengths(self.nominal(scene))
        return np.concatenate([[1.0, 1.0, np.nan], elastic]) if self.has_frame else elastic

    def radius_of_gyration(self, scene: Placed) -> float:
        """Radius of gyration about the origin of the reference condition, at the nominal design."""
        inv = self.nominal(scene)
        return float(np.sqrt(inv.inertia[0, 0] / inv.mass))

    def marker(self, scene: Placed, point: str, name: str) -> MarkerNumbers:
        """Marker at an interface point; the placement of a grounded body is part of its Z."""
        position, angle = self.point(scene, point, name)
        columns = np.flatnonzero(np.any(position[:, 1:] != 0, axis=0) | (angle[1:] != 0))
        shape = np.column_stack([position[:, 1 + columns].T, angle[1 + columns]])
        if self.has_frame:
            frame = np.zeros((3, 3))
            z0 = [*position[:, 0], angle[0] - self.angle]
            return MarkerNumbers(np.array(z0), np.concatenate([np.arange(3), 3 + columns]), np.vstack([frame, shape]))
        A = rotation(self.angle)
        z0 = [*(np.array(self.position) + A @ position[:, 0]), angle[0]]
        return MarkerNumbers(np.array(z0), columns, np.column_stack([shape[:, :2] @ A.T, shape[:, 2]]))

    def constant(self, scene: Placed, gravity: np.ndarray) -> ConstantNumbers:
        """Constant terms of the body: always damping and stiffness, mass and weight only of a grounded body."""
        design = self.design_point(scene)
        if self.has_frame:
            row, column, (damping, stiffness) = self._elastic_damping(scene, design)
            strains = chain_strains(row, column, stiffness, design.model.n_f)
            strains = strains._replace(column=3 + strains.column)
            none = np.zeros(len(row)), np.zeros(3 + design.model.n_f)
            return ConstantNumbers(3 + row, 3 + column, none[0], damping, stiffness, none[1], strains)
        row, column, (mass, damping, stiffness) = elastic_matrices(design, "inertia", "damping", "stiffness")
        weight = design.value("first_moment")[:, 1:].T @ (rotation(self.angle).T @ gravity)
        strains = chain_strains(row, column, stiffness, design.model.n_f)
        return ConstantNumbers(row, column, mass, damping, stiffness, weight, strains)

    def _elastic_damping(self, scene: Placed, design: DesignPoint) -> ElasticMatrices:
        """Damping and stiffness of a body with a moving frame, without the mass-proportional damping, which is that of `drag`."""
        alpha = self.mass_damping(scene)
        if is_zero(alpha):
            return elastic_matrices(design, "damping", "stiffness")
        row, column, (damping, stiffness, mass) = elastic_matrices(design, "damping", "stiffness", "inertia")
        return ElasticMatrices(row, column, (damping - alpha * mass, stiffness))

    def undamped(self, scene: Placed) -> FloatingNumbers:
        """Invariants without entries, for a body without mass-proportional damping."""
        none, empty = np.zeros(0, int), np.zeros(0)
        return FloatingNumbers(0.0, np.zeros((1 + self.design_point(scene).model.n_f, 2)), none, none, empty, empty, np.zeros(()))

    def floating(self, scene: Placed) -> FloatingNumbers | None:
        """Invariants of a body with a moving frame."""
        if not self.has_frame:
            return None
        inv = self.invariants(scene)
        spin, told = self.stiffening(scene), (inv.inertia != 0) | (inv.gyroscopic != 0)
        stiffening = np.zeros(()) if spin is None else np.pad(spin[0], ((1, 0), (1, 0)))
        row, column = np.nonzero(told | (stiffening != 0))
        return FloatingNumbers(
            mass=inv.mass,
            moment=inv.first_moment.T,
            row=row,
            column=column,
            inertia=inv.inertia[row, column],
            gyroscopic=inv.gyroscopic[row, column],
            stiffening=stiffening if spin is None else stiffening[row, column],
        )
