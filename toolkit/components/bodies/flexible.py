"""Flexible bodies from a reduced-model file, with a moving frame or grounded."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import ConfigDict, Field, model_validator

from toolkit.components.bodies.body import (
    QUATERNION,
    ConstantNumbers,
    FloatingNumbers,
    MarkerNumbers,
    Placed,
    SpatialBody,
    SpatialFloatingNumbers,
    SpatialMarkerNumbers,
    StartVelocity,
    pose_of,
)
from toolkit.components.bodies.chain_strains import chain_strains
from toolkit.components.bodies.cuttable_body import CuttableBody
from toolkit.components.bodies.model_body import is_zero
from toolkit.description.description import Number, Pair, Quantity, Triple
from toolkit.foundation.kinematics.orientation import angular_velocity, matrix_of, quaternion_of, rotation
from toolkit.reduced_model.design_point import DesignPoint, ElasticMatrices, elastic_matrices
from toolkit.reduced_model.model import Invariants, generalized_lengths
from toolkit.reduced_model.parts import SpatialInvariants, SurfaceLoad, all_second_moments, spatial_lengths

ACROSS = np.array([0.0, 0.0, 1.0])
"""The axis of all rotations in the plane."""


class Flexible(CuttableBody, StartVelocity):
    """A flexible body, which moves with its frame. `frame = "grounded"` fixes the reference condition (the clamp of its model) to the
    ground: then no frame coordinates exist, and no joint can move the body as a whole.

    Any parameter of the reduced model (density, youngs_modulus, ...) can be given by name and replaces its nominal value.

    Attributes
    ----------
    frame
        Whether the reference condition moves or is fixed to the ground.
    angle
        Rotation of the reduced model's axes at the start, in rad.
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

    def nominal(self, scene: Placed) -> Invariants:
        """Invariants at the nominal design."""
        inv = scene.model(self.model).invariants
        assert isinstance(inv, Invariants)
        return inv

    def initial_state(self, scene: Placed) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and velocities at the start: the frame at its written place, the elastic ones in the given shape."""
        shape, rate = self.start_shapes(scene)
        if not self.has_frame:
            return shape, rate
        return np.concatenate([[*self.position, self.angle], shape]), np.concatenate([self.frame_velocity(), rate])

    def coordinate_lengths(self, scene: Placed) -> np.ndarray:
        """RMS displacement of the body per unit elastic coordinate."""
        return np.concatenate([self.frame_lengths(), generalized_lengths(self.nominal(scene))])

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


class SpatialFlexible(CuttableBody, SpatialBody):
    """A flexible body, which moves with its frame. `frame = "grounded"` fixes the reference condition (the clamp of its model) to the
    ground: then no frame coordinates exist, and no joint can move the body as a whole.

    Any parameter of the reduced model (density, youngs_modulus, ...) can be given by name and replaces its nominal value.

    Attributes
    ----------
    orientation
        Rotation vector that turns the reduced model's axes to where they are at the start; its length is the angle in rad.
    """

    kind = "flexible"
    model_config = ConfigDict(extra="allow")  # against the base of all bodies, which allows none

    position: Annotated[Triple, Quantity("length")] = (0.0, 0.0, 0.0)
    orientation: Annotated[Triple, Quantity("angle")] = (0.0, 0.0, 0.0)
    deflection: Annotated[dict[str, Triple], Quantity("length")] = Field(default_factory=dict)
    elastic_velocity: Annotated[dict[str, Triple], Quantity("length/time")] = Field(default_factory=dict)

    @property
    def placement(self) -> np.ndarray:
        """Rotation matrix of the reduced model's axes at the start, (3, 3)."""
        return matrix_of(quaternion_of(np.array(self.orientation)))

    def initial_state(self, scene: Placed) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and velocities at the start: the frame at its written place, the elastic ones in the given shape."""
        shape, rate = self.start_shapes(scene)
        omega = self.placement.T @ self.spin
        q, v = self.frame_state(np.array(self.position), quaternion_of(np.array(self.orientation)), omega)
        return np.concatenate([q, shape]), np.concatenate([v, rate])

    def coordinate_lengths(self, scene: Placed) -> np.ndarray:
        """RMS displacement of the body per unit elastic coordinate."""
        return np.concatenate([self.frame_lengths(), spatial_lengths(self.nominal(scene))])

    def radius_of_gyration(self, scene: Placed) -> float:
        """Root of the mean square distance from the origin of the reference condition, at the nominal design."""
        inv = self.nominal(scene)
        return float(np.sqrt(inv.second_moment[:3, 0, 0].sum() / inv.mass))

    def nominal(self, scene: Placed) -> SpatialInvariants:
        """Invariants at the nominal design."""
        inv = scene.model(self.model).invariants
        assert isinstance(inv, SpatialInvariants)
        return inv

    def frame_axes(self, q: np.ndarray) -> np.ndarray:
        """Rotation matrix (3, 3) of the frame, by its quaternion or by the angle that it has turned from where it is placed."""
        if self.frame == "turning":
            return matrix_of(quaternion_of(q[self.moves] * self.unit_axis)) @ self.placement
        return matrix_of(q[self.moves : self.moves + QUATERNION])

    def undeforming_point(self, width: int) -> tuple[np.ndarray, np.ndarray]:
        """Three zero positions and a zero rotation vector, with `width` columns each."""
        return np.zeros((3, width)), np.zeros((3, width))

    @property
    def start_spin(self) -> np.ndarray:
        """Written angular velocity at the start, turned into the axes of the reduced model, (3,)."""
        return self.placement.T @ self.spin

    @property
    def only_axis(self) -> np.ndarray | None:
        """Axis of a turning frame in the axes of the reduced model, (3,); None of other frames."""
        return self.placement.T @ self.unit_axis if self.frame == "turning" else None

    def spins(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Angular velocity of the frame in the axes of the reduced model, (n_t, 3).

        It follows from the quaternion's rate, or lies along the axis of a turning frame.
        """
        at = self.moves
        if self.only_axis is not None:
            return v[:, at, None] * self.only_axis
        return angular_velocity(q[:, at : at + QUATERNION], v[:, at : at + QUATERNION])

    def marker(self, scene: Placed, point: str, name: str, axes: np.ndarray | None = None) -> SpatialMarkerNumbers:
        """Marker at an interface point; the placement of a body whose frame is no quaternion is part of its Z."""
        position, rotation = self.point(scene, point, name)
        columns = np.flatnonzero(np.any(position[:, 1:] != 0, axis=0) | np.any(rotation[:, 1:] != 0, axis=0))
        at, shape = position[:, 0], np.column_stack([position[:, 1 + columns].T, rotation[:, 1 + columns].T])
        axes, origin, A = np.eye(3) if axes is None else axes, np.array(self.position), self.placement
        if self.frame == "moving":
            axes, origin = A.T @ axes, 0 * origin
        else:
            at, shape = A @ at, np.column_stack([shape[:, :3] @ A.T, shape[:, 3:] @ A.T])
            if self.frame == "grounded":
                at, origin = at + origin, 0 * origin
            elif self.frame == "translating":
                origin = 0 * origin
        first = np.zeros((self.frame_size, 6))
        return SpatialMarkerNumbers(
            pose_of(at, axes, origin),
            np.concatenate([np.arange(self.frame_size), self.frame_size + columns]),
            np.vstack([first, shape]),
        )

    def constant(self, scene: Placed, gravity: np.ndarray) -> ConstantNumbers:
        """Constant terms of the body: always damping and stiffness, mass and weight only where the frame does not turn."""
        inv, size, m = self.invariants(scene), self.frame_size, self.moves
        whole, moment = size + len(inv.stiffness), self.placement @ inv.first_moment
        dtype = np.result_type(moment, inv.second_moment, inv.stiffness, inv.damping, inv.mass, gravity, self.mass_damping(scene))
        mass, damping, stiffness = np.zeros((3, whole, whole), dtype)
        damping[size:, size:], stiffness[size:, size:] = inv.damping, inv.stiffness
        force, alpha = np.zeros(whole, dtype), self.mass_damping(scene)
        if self.turns:
            if not is_zero(alpha):  # that part is `drag`
                damping[size:, size:] -= alpha * inv.second_moment[:3, 1:, 1:].sum(axis=0)
        else:
            force[m:], force[:m] = moment[:, 1:].T @ gravity, (inv.mass * gravity)[:m]
            mass[m:, m:], mass[:m, :m] = inv.second_moment[:3, 1:, 1:].sum(axis=0), inv.mass * np.eye(m)
            mass[:m, m:], mass[m:, :m] = moment[:m, 1:], moment[:m, 1:].T
            damping[:m], damping[m:, :m] = alpha * mass[:m], alpha * mass[m:, :m]
        row, column = np.nonzero((mass != 0) | (damping != 0) | (stiffness != 0))
        return ConstantNumbers(row, column, mass[row, column], damping[row, column], stiffness[row, column], force)

    def undamped(self, scene: Placed) -> SpatialFloatingNumbers:
        """Invariants without entries, for a body without mass-proportional damping."""
        none, moment = np.zeros(0, int), np.zeros((1 + self.design_point(scene).model.n_f, 3))
        return SpatialFloatingNumbers(0.0, moment, none, none, np.zeros((0, 9)), self.unit_axis, np.zeros(()))

    def surface_load(self, scene: Placed, surface: str) -> SurfaceLoad:
        """Load of a unit pressure on one of the surfaces that the reduced model names."""
        design = self.design_point(scene, "surface_loads")
        return SurfaceLoad(*(design.value(f"surface_loads.{surface}.{key}") for key in ("force", "moment")))

    def floating(self, scene: Placed) -> SpatialFloatingNumbers | None:
        """Invariants of a body whose frame turns; those of a turning frame in the undeformed configuration's axes."""
        if not self.turns:
            return None
        inv = self.invariants(scene)
        Q, moment, A = all_second_moments(inv.second_moment), inv.first_moment, self.placement
        if self.frame == "turning":
            Q, moment = np.einsum("ac,bd,cdij->abij", A, A, Q), A @ moment
        told, S = np.any(Q != 0, axis=(0, 1)), self._stiffening(scene)
        row, column = np.nonzero(told if S is None else told | np.any(S != 0, axis=(0, 1)))

        def entries(matrices: np.ndarray) -> np.ndarray:
            found: np.ndarray = np.moveaxis(matrices[:, :, row, column], 2, 0).reshape(len(row), 9)
            return found

        stiffening = np.zeros(()) if S is None else entries(S)
        return SpatialFloatingNumbers(inv.mass, moment.T, row, column, entries(Q), self.unit_axis, stiffening)

    def _stiffening(self, scene: Placed) -> np.ndarray | None:
        """S_ab - delta_ab tr S / 2 (3, 3, 1 + n_f, 1 + n_f), in the axes of a turning frame's undeformed configuration.

        As a change of the moments Q_ab this is the kinetic energy -omega_a omega_b S_ab / 2, because of Q_ab the energy has
        (tr Q delta_ab - Q_ab) / 2.
        """
        spin, A = self.stiffening(scene), self.placement
        if spin is None:
            return None
        S = all_second_moments(np.pad(spin, ((0, 0), (1, 0), (1, 0))))
        if self.frame == "turning":
            S = np.einsum("ac,bd,cdij->abij", A, A, S)
        return S - np.einsum("ab,ccij->abij", np.eye(3), S) / 2
