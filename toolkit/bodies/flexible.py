"""Flexible bodies from a reduced-model file, with a moving frame or grounded."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Literal

import numpy as np
from pydantic import ConfigDict, model_validator

from toolkit.bodies.body import Body, ConstantNumbers, FloatingNumbers, MarkerNumbers, Placed
from toolkit.description import Number, Pair
from toolkit.design_point import DesignPoint
from toolkit.errors import InputError
from toolkit.planar import rotation
from toolkit.reduced_model import MEAN_AXES, Invariants, ReducedModel, generalized_lengths, place_parameter

DEPENDENCE = ("affine", "derivatives")
"""Parts of a reduced model that tell how its arrays depend on its parameters."""

FRAME = "(frame)"
"""In place of an interface point: the origin of the body's frame, which turns with it but does not deform."""


class Flexible(Body):
    """A flexible body. `frame = "grounded"`: the reference condition is fixed to the ground, no frame coordinates exist.

    Any parameter of the reduced model (thickness, youngs_modulus, ...) can be given by name and replaces its nominal value.

    Attributes
    ----------
    model
        Path of the reduced model, relative to the scene's folder.
    frame
        Whether the reference condition is fixed to the ground or moves.
    position
        Where the origin of the reduced model lies at the start, in units of length.
    angle
        Rotation of the reduced model's axes at the start, in rad.
    velocity
        v_x, v_y of the moving frame's origin and omega at the start, in length/time and rad/time.
    extrapolation
        What to do where a parameter leaves its nominal value and the file holds only a derivative there: refuse, or follow the tangent.
    """

    kind = "flexible"
    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Number]

    model: str
    frame: Literal["grounded", "moving"] = "grounded"
    position: Pair = (0.0, 0.0)
    angle: Number = 0.0
    velocity: tuple[Number, Number, Number] = (0.0, 0.0, 0.0)
    extrapolation: Literal["none", "first-order"] = "none"

    @model_validator(mode="after")
    def _still(self) -> Flexible:
        if self.frame == "grounded" and any(self.velocity):
            raise ValueError('a grounded body cannot have a `velocity`; write frame = "moving", or leave it out')
        return self

    def numbers(self) -> Iterator[tuple[str, Any]]:
        """All numbers that mean something: a grounded body has no velocity."""
        return ((path, value) for path, value in super().numbers() if self.has_frame or not path.startswith("velocity."))

    @property
    def has_frame(self) -> bool:
        """Only a moving frame has coordinates."""
        return self.frame == "moving"

    def model_values(self) -> Mapping[str, Any]:
        """Parameters that the scene sets."""
        return self.model_extra or {}

    def design_point(self, scene: Placed, *parts: str) -> DesignPoint:
        """The reduced model at the scene's parameter values; `parts` as of `Scene.model`.

        What the model's arrays depend on is read only if a value is not the nominal one, be it by an imaginary step.
        """
        model, first_order = scene.model(self.model), self.extrapolation == "first-order"
        if not self.has_frame and model.reference_condition == MEAN_AXES:
            raise InputError(
                f"the reduced model {self.model!r} floats about mean axes, so that no point of it stays where it is: a grounded body "
                'cannot be made of it. Write frame = "moving" and hold the body by joints, or preprocess with boundary = "clamped".'
            )
        places = {name: s for name, s in scene.arc_lengths(self).items() if place_parameter(name) in model.nominal}
        follows = {place_parameter(name): s for name, s in places.items()}
        moved = any(model.nominal.get(name) != value for name, value in {**self.model_values(), **follows}.items())
        model = scene.model(self.model, *(DEPENDENCE if moved else ()), *parts)
        design = DesignPoint(model, self.model_values(), first_order)
        for name in places:
            if design.moves(f"interfaces.{name}.arc_length"):
                raise InputError(
                    f"the scene writes an arc length of interface point {name!r}, which the shape moves along the skin, and the body's "
                    "shapes follow it: their derivative at a fixed arc length is unknown. Leave arc_length out of the scene, or give the "
                    "point by its arc length in the skin file."
                )
        return DesignPoint(model, {**self.model_values(), **follows}, first_order) if follows else design

    def invariants(self, scene: Placed) -> Invariants:
        """Invariants at the scene's parameter values."""
        return self.design_point(scene).invariants()

    def point(self, scene: Placed, point: str, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Z_P (2, 1 + n_f) and T_P (1 + n_f,) of a point of the scene that is one of the body's interface points, or its frame.

        Raises
        ------
        InputError
            The point is no interface point of this body; lists those that are. Or its arc length is outside of the element.
        """
        written, design = scene.interface(point), self.design_point(scene)
        model = design.model
        if getattr(written, "body", None) != name:
            raise InputError(
                f"point {point!r} is not an interface point of flexible body {name!r}, so nothing can grip the body there. "
                f'Write {point} = {{ body = "{name}", interface = ... }} with one of: {_names(model)}.'
            )
        if written.interface == FRAME and FRAME not in (model.interfaces or {}):
            return np.zeros((2, 1 + model.n_f)), np.zeros(1 + model.n_f)
        refuse_unknown(model, written.interface, name)
        interface = design.interface(written.interface)
        moved = written.arc_length is not None and place_parameter(written.interface) not in model.nominal
        return interface.at(written.arc_length) if moved else interface.here

    def coordinate_names(self, scene: Placed) -> list[str]:
        """Elastic coordinates by number, after the frame."""
        elastic = [f"elastic coordinate {k}" for k in range(scene.model(self.model).n_f)]
        return ["x", "y", "rotation", *elastic] if self.has_frame else elastic

    def initial_state(self, scene: Placed) -> tuple[np.ndarray, np.ndarray]:
        """Undeformed at its place, given velocity of the frame."""
        elastic = np.zeros(scene.model(self.model).n_f)
        if not self.has_frame:
            return elastic, elastic
        return np.concatenate([[*self.position, self.angle], elastic]), np.concatenate([self.velocity, elastic])

    def coordinate_lengths(self, scene: Placed) -> np.ndarray:
        """RMS displacement of the body per unit elastic coordinate."""
        elastic = generalized_lengths(scene.model(self.model).invariants)
        return np.concatenate([[1.0, 1.0, np.nan], elastic]) if self.has_frame else elastic

    def radius_of_gyration(self, scene: Placed) -> float:
        """About the origin of the reference condition, at the nominal design."""
        inv = scene.model(self.model).invariants
        return float(np.sqrt(inv.inertia[0, 0] / inv.mass))

    def marker(self, scene: Placed, point: str, name: str) -> MarkerNumbers:
        """An interface point; the placement of a grounded body is part of its Z."""
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
        """Damping and stiffness always; mass and weight only of a grounded body."""
        inv = self.invariants(scene)
        elastic = (inv.stiffness != 0) | (inv.damping != 0)
        if self.has_frame:
            row, column = np.nonzero(elastic)
            return ConstantNumbers(
                3 + row, 3 + column, np.zeros(len(row)), inv.damping[row, column], inv.stiffness[row, column],
                np.zeros(3 + len(inv.stiffness)),
            )  # fmt: skip
        row, column = np.nonzero((inv.inertia[1:, 1:] != 0) | elastic)
        weight = inv.first_moment[:, 1:].T @ (rotation(self.angle).T @ gravity)
        mass = inv.inertia[1:, 1:][row, column]
        return ConstantNumbers(row, column, mass, inv.damping[row, column], inv.stiffness[row, column], weight)

    def floating(self, scene: Placed) -> FloatingNumbers | None:
        """Invariants of a body with a moving frame."""
        if not self.has_frame:
            return None
        inv = self.invariants(scene)
        row, column = np.nonzero((inv.inertia != 0) | (inv.gyroscopic != 0))
        return FloatingNumbers(inv.mass, inv.first_moment.T, row, column, inv.inertia[row, column], inv.gyroscopic[row, column])


def refuse_unknown(model: ReducedModel, interface: str, body: str) -> None:
    """Refuse an interface point that does not exist, and list those that do.

    Raises
    ------
    InputError
        There is none of that name.
    """
    if interface not in (model.interfaces or {}):
        raise InputError(
            f"flexible body {body!r} has no interface point {interface!r}; available: {_names(model)}. "
            "Add it to the interface points of the skin file and run preprocessing again."
        )


def _names(model: ReducedModel) -> str:
    return ", ".join(model.interfaces or {}) or "none"
