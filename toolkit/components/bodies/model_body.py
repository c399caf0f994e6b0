"""Base of flexible bodies in the plane and in space: a reduced model, its parameters and its interface points.

The shape that a flexible body starts in: the written displacements of some of its points, and the least strain energy that allows them.

    minimise q^T K q / 2   with   Z_P q = u_P of every written point P:     q = K^-1 Z^T (Z K^-1 Z^T)^-1 u

It is the shape in which forces at these points hold the body at rest, so that a beam that is let go was plucked there.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Mapping
from typing import Any, Literal

import numpy as np
from pydantic import ConfigDict

from toolkit.components.bodies.body import CENTRE, Body, FloatingNumbers, Placed, SpatialFloatingNumbers
from toolkit.description.description import FileName, Number, Scalar
from toolkit.description.design import BodyPoint
from toolkit.foundation.errors import InputError, listed, meant
from toolkit.reduced_model.design_point import DesignPoint, design_at
from toolkit.reduced_model.model import MEAN_AXES, ReducedModel, place_parameter
from toolkit.reduced_model.parts import SPIN_STIFFENING

AXES = "xyz"
UNMOVED_FLEXIBILITY = 1e-12
"""Flexibility, a part of the largest of the written displacements, below which no deformation moves a point that way."""
INDEPENDENT_FLEXIBILITY = 1e-9
"""Least eigenvalue of the flexibility, scaled to a unit diagonal, of displacements that can be chosen each on its own."""
NAMED_PART = 1e-6
"""Square of a displacement's part in those that cannot, from which it is named."""


def start_shape(stiffness: np.ndarray, points: dict[str, tuple[np.ndarray, np.ndarray]], where: str) -> np.ndarray:
    """Elastic coordinates (n_f,) at the start, or their velocities, real or complex.

    Parameters
    ----------
    stiffness : (n_f, n_f)
    points : point -> Z_P (d, n_f) of the elastic coordinates, and the written displacement u_P (d,) or its velocity
    where : path of the body's key, for messages

    Raises
    ------
    InputError
        No deformation moves a point as it is written, or not beside the others; names it.
    """
    Z = np.concatenate([rows for rows, _ in points.values()])
    u = np.concatenate([np.asarray(wish) for _, wish in points.values()])
    names = [(point, AXES[k]) for point, (rows, _) in points.items() for k in range(len(rows))]
    scale = 1 / np.sqrt(np.diag(np.real(stiffness)))
    flexible = scale[:, None] * _solved(scale[:, None] * stiffness * scale, scale[:, None] * Z.T, where)
    compliance = Z @ flexible
    size = np.real(np.diag(compliance))
    moves = size > UNMOVED_FLEXIBILITY * size.max(initial=0)
    for (point, axis), wish, free in zip(names, u, moves, strict=True):
        if not free and wish != 0:
            raise InputError(
                f"{where}.{point} asks for a displacement along {axis} of the body's own axes, but no deformation of the body moves the "
                "point that way: its reduced model holds it there, or has no shape for it. Write zero there, or another point."
            )
    chosen = compliance[np.ix_(moves, moves)]
    _refuse_dependent(
        np.real(chosen), [f"{point}.{axis}" for (point, axis), free in zip(names, moves, strict=True) if free], where
    )
    found: np.ndarray = flexible[:, moves] @ np.linalg.solve(chosen, u[moves])
    return found


def _solved(matrix: np.ndarray, sides: np.ndarray, where: str) -> np.ndarray:
    try:
        return np.linalg.solve(matrix, sides)
    except np.linalg.LinAlgError as error:
        raise InputError(
            f"{where} has no shape of least strain energy: the body's stiffness is singular, so that a part of it moves without any. "
            "Leave it out, or fix the reduced model."
        ) from error


def _refuse_dependent(compliance: np.ndarray, names: list[str], where: str) -> None:
    """Refuse displacements of which some follow from others."""
    size = np.sqrt(np.diag(compliance))
    squares, vectors = np.linalg.eigh(compliance / np.outer(size, size))
    if len(squares) and squares[0] < INDEPENDENT_FLEXIBILITY:
        shares = (vectors[:, squares < INDEPENDENT_FLEXIBILITY] ** 2).sum(
            axis=1
        )  # whatever vectors of equal ones the processor finds
        tied = [name for name, share in zip(names, shares, strict=True) if share > NAMED_PART]
        raise InputError(
            f"{where} writes displacements that the body's shapes do not allow each on its own: {', '.join(tied)}. Leave one of the points "
            "out, or give the reduced model more shapes."
        )


DEPENDENCE = ("affine", "derivatives")
"""Parts of a reduced model that tell how its arrays depend on its parameters."""

MASS_DAMPING = "damping_mass"
"""Parameter of a reduced model: alpha of its damping D = alpha M + c K."""

FRAME = "(frame)"
"""Name in place of an interface point: the origin of the body's frame, which turns with it but does not deform."""


class ModelBody(Body):
    """Base of bodies from a reduced-model file; its parameters are keys of the body's table.

    Attributes
    ----------
    model
        Path of the reduced model, relative to the scene's folder.
    extrapolation
        What to do where a parameter leaves its nominal value and the file holds only a derivative there: refuse, or follow the tangent.
    spin_stiffening
        Whether the centrifugal forces of its frame's spin stiffen the body: blades and discs that spin fast. It needs a reduced model that
        was built with `spin_stiffening = true` in `[basis]`, and a body of one frame, which turns. What accelerations of the frame, weight
        and forces at points of the body do to its stiffness is not in it.
    position
        Where the origin of the reduced model lies at the start, in units of length.
    deflection
        Point of the body -> its displacement at the start since the undeformed body, in the axes of the reduced model, in units of
        length: what a response of the type `deflection` tells at time 0. The rest of the body takes the shape of least strain energy,
        as if forces at these points had bent it and let go. Statics, and `solver.start = "equilibrium"`, find their own shape.
    elastic_velocity
        Point of the body -> velocity of that displacement at the start, in length/time; the rest of the body moves in the shape of least
        strain energy. It holds, or is refused if the joints do not allow it; left out, the body starts with the velocities that the
        joints ask for, and without deforming where it can.
    """

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Number]

    model: FileName
    extrapolation: Literal["none", "first-order"] = "none"
    spin_stiffening: bool = False

    @property
    def dependence(self) -> tuple[str, ...]:
        """Parts of the reduced model that tell how what the body needs depends on the parameters."""
        return DEPENDENCE

    @property
    def parted(self) -> bool:
        """Whether the body is cut into parts with floating frames of their own."""
        return False

    @property
    def deflected(self) -> Mapping[str, Mapping[str, tuple[Scalar, ...]]]:
        """Written displacements at the start and their velocities: key of the table -> point -> numbers in the body's axes."""
        written: Any = self
        return {"deflection": written.deflection, "elastic_velocity": written.elastic_velocity}

    def coordinate_names(self, scene: Placed) -> list[str]:
        """Names of the frame's coordinates, and of the elastic ones by their numbers."""
        return [*self.frame_names(), *(f"elastic coordinate {k}" for k in range(scene.model(self.model).n_f))]

    def start_shapes(self, scene: Placed) -> tuple[np.ndarray, np.ndarray]:
        """Elastic coordinates (n_f,) and their velocities at the start, see `start_shape`; zero where nothing is written."""
        shape, rate = (self._start_shape(scene, key) for key in ("deflection", "elastic_velocity"))
        return shape, rate

    def _start_shape(self, scene: Placed, key: str) -> np.ndarray:
        written = self.deflected[key]
        if not written:
            return np.zeros(scene.model(self.model).n_f)
        name = next(name for name, body in scene.bodies.items() if body is self)
        points = {point: (self.point(scene, point, name)[0][:, 1:], np.array(wish)) for point, wish in written.items()}
        return start_shape(self.invariants(scene).stiffness, points, f"bodies.{name}.{key}")

    def model_values(self) -> Mapping[str, Scalar]:
        """Parameters of the reduced model that the scene sets."""
        return self.model_extra or {}

    def design_point(self, scene: Placed, *parts: str) -> DesignPoint:
        """The reduced model at the scene's parameter values; `parts` as of `Scene.model`.

        What the model's arrays depend on is read only if a value is not the nominal one, be it by an imaginary step.
        """
        return scene.of_body(self, ("design", *parts), lambda: self._design_point(scene, *parts))

    def _design_point(self, scene: Placed, *parts: str) -> DesignPoint:
        model, first_order = scene.model(self.model), self.extrapolation == "first-order"
        if not self.has_frame and model.reference_condition == MEAN_AXES:
            raise InputError(
                f"the reduced model {self.model!r} floats about mean axes, so that no point of it stays where it is: a grounded body "
                'cannot be made of it. Write frame = "moving" and hold the body by joints, or preprocess with boundary = "clamped".'
            )
        places = {name: s for name, s in scene.arc_lengths(self).items() if place_parameter(name) in model.nominal}
        follows = {place_parameter(name): s for name, s in places.items()}
        moved = any(model.nominal.get(name) != value for name, value in {**self.model_values(), **follows}.items())
        model = scene.model(self.model, *(self.dependence if moved else ()), *parts)
        refuse_unknown_keys(self, self.model_values(), model, scene.bodies)
        design = design_at(model, self.model_values(), first_order)
        for name in places:
            if design.moves(f"interfaces.{name}.arc_length"):
                raise InputError(
                    f"the scene writes an arc length of interface point {name!r}, which the shape moves along the skin, and the body's "
                    "shapes follow it: their derivative at a fixed arc length is unknown. Leave arc_length out of the scene, or give the "
                    "point by its arc length in the skin file."
                )
        return design_at(model, {**self.model_values(), **follows}, first_order) if follows else design

    def stress_operator(self, scene: Placed) -> np.ndarray:
        """Stress per elastic coordinate at the scene's parameter values, (n_s, n_f) or of solids (n_s, 6, n_f)."""
        return self.design_point(scene).value("stress_operator")

    def invariants(self, scene: Placed) -> Any:
        """Invariants at the scene's parameter values."""
        return self.design_point(scene).invariants()

    def some_invariants(self, scene: Placed, *names: str) -> tuple[np.ndarray, ...]:
        """Invariants of the given names at the scene's parameter values; the others, which would cost time, are left out."""
        return self.design_point(scene).some_invariants(*names)

    def stiffening(self, scene: Placed) -> np.ndarray | None:
        """The matrices (k, n_f, n_f) of `parts.spin` at the scene's parameter values; None of a body that does not ask for them.

        Raises
        ------
        InputError
            Its reduced model does not hold them.
        """
        if not self.spin_stiffening:
            return None
        design = self.design_point(scene, "spin")
        if design.model.spin is None:
            name = next(name for name, body in scene.bodies.items() if body is self)
            toml = next(iter(design.model.source), "the file that it is built from")
            raise InputError(
                f"bodies.{name}.spin_stiffening = true, but its reduced model {self.model!r} does not tell how a spin stiffens the body. "
                f"Write spin_stiffening = true in the table [basis] of {toml} and build it again with ffrf-preprocess, or leave the key "
                "out of the scene."
            )
        return design.value(SPIN_STIFFENING)

    def mass_damping(self, scene: Placed) -> Scalar:
        """alpha of the damping D = alpha M + c K, in 1/time; 0 if elements have values of their own, see `damping_differs`."""
        design = self.design_point(scene)
        number = design.model.numbers.get(MASS_DAMPING)
        return 0.0 if number is None or self.damping_differs(scene) else design.parameter(number)

    def damping_differs(self, scene: Placed) -> bool:
        """Whether its elements have mass-proportional damping of their own, so that no one number times its mass is that of the body."""
        design = self.design_point(scene)
        own = [k for name, k in design.model.numbers.items() if name.startswith(f"{MASS_DAMPING}_")]
        return any(design.parameter(k) != 0 for k in own)

    def drag(self, scene: Placed) -> FloatingNumbers | SpatialFloatingNumbers | None:
        """Invariants times the mass-proportional damping of a body whose frame turns; None of other bodies.

        They damp all of its velocity, not only that of its deformation.
        """
        if not self.turns:
            return None
        alpha = self.mass_damping(scene)
        if is_zero(alpha):
            return self.undamped(scene)
        floating = self.floating(scene)
        return None if floating is None else floating.times(alpha)

    @abstractmethod
    def undamped(self, scene: Placed) -> FloatingNumbers | SpatialFloatingNumbers:
        """Value of `drag` where the damping is zero: invariants without entries."""

    def whole_mass(self, scene: Placed) -> Scalar:
        """Mass of the body by its reduced model."""
        return self.invariants(scene).mass

    def point(self, scene: Placed, point: str, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Z_P (d, 1 + n_f) and T_P of an interface point, the frame or the centre of mass.

        T_P is (1 + n_f,), in space (3, 1 + n_f).

        Raises
        ------
        InputError
            The point is no interface point of this body; lists those that are. Or its arc length is outside of the element.
        """
        if point == CENTRE:
            inv = self.invariants(scene)
            return inv.first_moment / inv.mass, self.undeforming_point(inv.first_moment.shape[-1])[1]
        written, design = scene.interface(point), self.design_point(scene)
        model = design.model
        if not isinstance(written, BodyPoint) or written.body != name:
            raise InputError(
                f"point {point!r} is not an interface point of flexible body {name!r}, so nothing can grip the body there. "
                f'Write {point} = {{ body = "{name}", interface = ... }} with one of: {_names(model)}.'
            )
        if written.interface == FRAME and FRAME not in (model.interfaces or {}):
            return self.undeforming_point(1 + model.n_f)
        refuse_unknown(model, written.interface, name)
        interface = design.interface(written.interface)
        if written.arc_length is None or place_parameter(written.interface) in model.nominal:
            return interface.here
        return interface.at(written.arc_length)

    @abstractmethod
    def undeforming_point(self, width: int) -> tuple[np.ndarray, np.ndarray]:
        """Z_P and T_P of the origin of the body's frame, which no elastic coordinate moves; the last axis has a width."""

    @property
    @abstractmethod
    def start_spin(self) -> np.ndarray:
        """Written angular velocity at the start in the axes of the reduced model, (3,); zero where nothing is written."""

    @property
    @abstractmethod
    def only_axis(self) -> np.ndarray | None:
        """Axis that the frame can turn about, if there is one alone, (3,) in the axes of the reduced model; None otherwise."""

    @abstractmethod
    def spins(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Angular velocity of its frame in the axes of the reduced model, (n_t, 3), from its coordinates and velocities (n_t, size)."""

    @property
    @abstractmethod
    def placement(self) -> np.ndarray:
        """Rotation matrix of the reduced model's axes at the start, (d, d)."""

    def position_at_rest(self, scene: Placed, point: str, name: str) -> np.ndarray:
        """Undeformed global position of an interface point, (d,)."""
        written: Any = self
        return np.array(written.position) + self.placement @ self.point(scene, point, name)[0][:, 0]


def refuse_unknown_keys(body: Body, keys: Iterable[str], model: ReducedModel, bodies: Mapping[str, Body]) -> None:
    """Refuse the first of these keys of a body that its reduced model has no parameter for.

    Raises
    ------
    InputError
        It names the body and the key, and lists its own keys and the parameters.
    """
    unknown = next((key for key in keys if key not in model.nominal), None)
    if unknown is None:
        return
    name = next(name for name, other in bodies.items() if other is body)
    own = type(body).model_fields
    raise InputError(
        f"bodies.{name} has no key {unknown!r}{meant(unknown, [*own, *model.parameters])}, and its reduced model {model.label} has no "
        f"parameter {unknown!r}. Keys: {listed(own)}; parameters: {listed(model.parameters)}. Use one of these names, or state the "
        "parameter in the skin file and run preprocessing again."
    )


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


def is_zero(damping: Scalar) -> bool:
    """Whether a number is zero, and not a complex step from zero."""
    return not isinstance(damping, complex) and damping == 0
