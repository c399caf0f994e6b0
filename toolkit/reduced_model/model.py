"""The reduced model of one flexible body, the only thing the two halves of the project share; its file is in `reduced_model_file`."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.reduced_model.dependence import Derivatives, SparsePolynomial
from toolkit.reduced_model.parts import (
    BeamSections,
    Elements,
    Interior,
    LeftOutShapes,
    Mesh,
    PieceLoads,
    Pieces,
    SpatialElements,
    SpatialInvariants,
    Spin,
    Surface,
    SurfaceLoad,
)

MEAN_AXES = "mean axes (Buckens)"
"""The reference condition of a body whose frame is held by none of its points."""


@dataclass(frozen=True)
class Invariants:
    """Invariants of a planar body, theory section 1, with Z = [xi, Psi] and n_f elastic coordinates.

        m     = t_a^T M_aa t_a             N[a, :] = t_a^T M_aa Z
        G     = Z^T (M_11 + M_22) Z        H       = Z^T (M_12 - M_21) Z
        K     = Psi^T K_fe Psi             D       = Psi^T D_fe Psi

    `stress_operator` maps the elastic coordinates to the stress at every stress point.
    """

    mass: np.ndarray  # ()
    first_moment: np.ndarray  # (2, 1 + n_f)
    inertia: np.ndarray  # G (1 + n_f, 1 + n_f), symmetric
    gyroscopic: np.ndarray  # H (1 + n_f, 1 + n_f), antisymmetric
    stiffness: np.ndarray  # (n_f, n_f)
    damping: np.ndarray  # (n_f, n_f)
    stress_operator: np.ndarray  # (n_stress, n_f)

    moments: ClassVar[tuple[str, ...]] = ("inertia", "gyroscopic")
    """Names of the arrays that are integrals of products of shapes."""

    @property
    def inertia_about_origin(self) -> np.ndarray:
        """Matrix G (1 + n_f, 1 + n_f) of the kinetic energy's squares of rotation and deformation rates."""
        return self.inertia

    def mass_across(self, _axis: np.ndarray) -> np.ndarray:
        """Elastic mass moving across an axis, (n_f, n_f): all of it, as every rotation axis in the plane is normal to it."""
        return self.inertia[1:, 1:]


@dataclass(frozen=True)
class InterfacePoint:
    """Point where joints and loads may act, as polynomials of its arc length s along the body.

        Z_P(s) = sum_k position[k] (s - arc_length)^k        position of the point: Z_P [1; q_f]
        T_P(s) = sum_k rotation[k] (s - arc_length)^k        its rotation: T_P [1; q_f]

    The polynomials hold for arc lengths inside `arc_length_range` (one finite element). At a node the range is that one
    point and only k = 0 exists: the discretised curve has a kink there and no derivative by s.
    """

    arc_length: np.ndarray  # ()
    arc_length_range: np.ndarray  # (2,)
    position: np.ndarray  # (n_powers, d, 1 + n_f), d: dimension of space
    rotation: np.ndarray  # (n_powers, 1 + n_f); in space a rotation vector, (n_powers, 3, 1 + n_f)

    @property
    def here(self) -> tuple[np.ndarray, np.ndarray]:
        """Shape functions Z_P (2, 1 + n_f) and T_P (1 + n_f,) at the point's own arc length."""
        return self.position[0], self.rotation[0]

    def at(self, arc_length: float | complex) -> tuple[np.ndarray, np.ndarray]:
        """Shape functions Z_P (2, 1 + n_f) and T_P (1 + n_f,) at an arc length inside the range.

        Raises
        ------
        InputError
            The arc length is outside the range, or complex at a node, where no derivative exists.
        """
        low, high = self.arc_length_range
        if not low <= np.real(arc_length) <= high or (low == high and np.imag(arc_length) != 0):
            raise InputError(
                f"arc length {np.real(arc_length):g} of an interface point is outside [{low:g}, {high:g}], where its "
                "derivative holds (a node has none). Rerun preprocessing with the point at the wanted place, off a node."
            )
        powers = (arc_length - self.arc_length) ** np.arange(len(self.position))
        return np.tensordot(powers, self.position, axes=1), np.tensordot(powers, self.rotation, axes=1)


def place_parameter(interface: str) -> str:
    """Name of the parameter that is an interface point's arc length, in models whose basis follows the point."""
    return f"arc_length_{interface}"


@dataclass(frozen=True)
class StressPoints:
    """Stress point of each row of the stress operator: element number, its end (0 or 1), the fibre (+1 outer, -1 inner)."""

    element: np.ndarray  # (n_stress,)
    end: np.ndarray  # (n_stress,)
    fibre: np.ndarray  # (n_stress,)


@dataclass(frozen=True)
class Shape:
    """Points whose distance to a target shape is of interest; their position is `position @ [1; q_f]`."""

    position: np.ndarray  # (n_points, 2, 1 + n_f)
    target: np.ndarray  # (n_points, 2)
    arc_length: np.ndarray  # (n_points,)


@dataclass(frozen=True)
class Outline:
    """The boundary of a meshed body, for pictures: points are `position @ [1; q_f]`.

    Stress points along the boundary are the middles of its edges, in their order.
    """

    position: np.ndarray  # (n_points, 2, 1 + n_f)
    edges: np.ndarray  # (n_edges, 3) first, middle and last point; the first twice where an edge is straight


@dataclass(frozen=True)
class ReducedModel:
    """Everything the runtime knows about one flexible body, in the units of its file.

    Its arrays are items: the invariants by their names, `interfaces.C.position`, `shape.target` and so on. An item depends on the
    parameters as its polynomial in `affine` says, exactly for every value; what no polynomial says stands in `derivatives`, at the
    nominal design. The preprocessing differentiates every item by every parameter: what stands in neither does not depend on it.
    Parts that `load` was not asked for are None.

    Attributes
    ----------
    dimension
        Of space, 2 or 3.
    reference_condition
        What the body's frame is tied to, in words.
    nominal_units
        Parameter -> unit.
    input_hash
        SHA-256 of all files that the model was built from.
    inputs, source, changes
        Each of these files by its place relative to the model's own file; the text of the TOML file among them; and what the command
        changed in it. Empty for a model that was built from no files.
    left_out
        Of a basis of few shapes: the slowest vibration of the shapes that it leaves out, in cycles per time, inf if there are none; under
        the name `interface` if its interface points are held in them, `frame` if its frame is alone. Empty where nobody has found it out.
    stress_errors, stress_error_at
        Of a meshed body: load cases of its own with the error of their stress in the energy norm, as it is estimated from the mesh, and
        where most of the largest is made. Empty where nobody has estimated it.
    face_errors
        Of a solid in pieces, under forces and moments at its interface points, against its mesh without cuts; positive where it is too
        soft. "least" and "largest" are those under all of them at once.
    composition
        What the body was made of. `nodes` and `volume` are numbers; `elements`, `interface_points`, `clamp`, `groups`, `masses`,
        `left_out`, `remarks` and `not_listed` are JSON texts, see `toolkit.reduced_model.composition`. Any may be missing.
    plain
        Whether its file is plain HDF5 of another program, in which no checksum tells a flipped bit.
    bytes_read
        Part that was read -> its bytes in the file, 0 if the file has no such part.
    """

    dimension: int
    units: str  # name of the unit system, "mm-t-s" or "m-kg-s"
    reference_condition: str
    basis: str  # "frozen" or "differentiated", with what it consists of
    nominal: dict[str, float]  # parameter -> value
    nominal_units: dict[str, str]
    input_hash: str
    writers: dict[str, str]  # program -> version
    invariants: Invariants | SpatialInvariants
    derivatives: dict[str, Derivatives] | None = None  # item -> derivatives by all parameters, as far as no polynomial tells them
    affine: dict[str, SparsePolynomial] | None = None  # invariant -> polynomial of the parameters
    interfaces: dict[str, InterfacePoint] | None = None
    stress: StressPoints | None = None
    shape: Shape | None = None
    mesh: Mesh | None = None
    outline: Outline | None = None
    interior: Interior | None = None
    elements: Elements | SpatialElements | None = None  # of bodies that keep all nodal coordinates
    element_derivatives: dict[str, Derivatives] | None = None  # the same as `derivatives`, of the items of `elements`
    element_affine: dict[str, SparsePolynomial] | None = None  # the same as `affine`
    sections: BeamSections | None = None  # of bodies of beams
    section_derivatives: dict[str, Derivatives] | None = None  # the same as `derivatives`, of the items of `sections`
    section_affine: dict[str, SparsePolynomial] | None = None  # the same as `affine`
    surface: Surface | None = None  # of spatial bodies
    surface_loads: dict[str, SurfaceLoad] | None = None  # name of a surface -> unit pressure on it
    spin: Spin | None = None  # of bodies whose file asks for it
    left_out_shapes: LeftOutShapes | None = None  # of beams whose basis keeps few shapes
    pieces: Pieces | None = None  # of solids in pieces, which are `elements`
    piece_loads: dict[str, PieceLoads] | None = None  # of these: the same as `surface_loads`, piece by piece
    richer_invariants: Invariants | SpatialInvariants | None = None  # of a frozen basis: the same as `invariants`, in more shapes
    richer_derivatives: dict[str, Derivatives] | None = None  # the same as `derivatives`
    richer_affine: dict[str, SparsePolynomial] | None = None  # the same as `affine`
    richer_interfaces: dict[str, InterfacePoint] | None = None  # the same as `interfaces`
    richer_shape: Shape | None = None  # the same as `shape`
    richer_spin: Spin | None = None  # the same as `spin`
    richer_surface_loads: dict[str, SurfaceLoad] | None = None  # the same as `surface_loads`
    inputs: dict[str, str] = field(default_factory=dict)  # file that it was built from, beside the model's -> its SHA-256
    source: dict[str, str] = field(default_factory=dict)  # the one of them that describes the body -> its text
    changes: dict[str, float] = field(default_factory=dict)  # parameter -> value other than that of the text
    left_out: dict[str, float] = field(
        default_factory=dict
    )  # what is held -> slowest frequency of the shapes that the basis lacks
    stress_errors: dict[str, float] = field(
        default_factory=dict
    )  # load case -> estimated error of the mesh, in parts of the stress
    stress_error_at: dict[str, float] = field(
        default_factory=dict
    )  # axis -> coordinate of the place where the largest of them is made
    face_errors: dict[str, float] = field(
        default_factory=dict
    )  # force or moment -> by how much faces between pieces change what it moves, in parts of that
    composition: dict[str, str | int | float] = field(default_factory=dict)  # what the body was made of -> number or JSON text
    inputs_from: Path | None = field(default=None, compare=False)  # folder that the names of `inputs` start from
    path: Path | None = field(default=None, compare=False)
    plain: bool = field(default=False, compare=False)
    bytes_read: dict[str, int] = field(default_factory=dict, compare=False)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the design parameters; polynomials and derivatives refer to them by number."""
        return tuple(self.nominal)

    @cached_property
    def numbers(self) -> dict[str, int]:
        """Number of each parameter."""
        return {name: k for k, name in enumerate(self.nominal)}

    @cached_property
    def told(self) -> dict[Hashable, Any]:
        """Data on items that the model's design points have looked up, see `dependence.Told`."""
        return {}

    @property
    def n_f(self) -> int:
        """Number of elastic coordinates."""
        return len(self.invariants.stiffness)

    @property
    def keeps_all(self) -> bool:
        """Whether the elastic coordinates are all nodal ones, or all but those that the frame takes up."""
        return any(words in self.basis for words in ("identity on", "all coordinates"))

    @property
    def nodal_shapes(self) -> np.ndarray | None:
        """Nodal coordinates of the elements, once these are loaded, per elastic coordinate (n, n_f); None if nobody stored them."""
        if self.elements is None or (self.dimension == 3 and not (self.keeps_all or self.in_pieces)):
            return None
        return self.elements.shapes(self.mesh)

    @property
    def in_pieces(self) -> bool:
        """Whether the body is a solid in pieces, which are its elements; the errors of their faces are then known."""
        return bool(self.face_errors)

    @property
    def elements_called(self) -> str:
        """Word for the model's elements in messages: "pieces" or "elements"."""
        return "pieces" if self.in_pieces else "elements"

    @property
    def label(self) -> str:
        """Name of the file in quotes, for messages."""
        return repr(self.path.name) if self.path else "(not from a file)"

    def dependence(self, item: str) -> tuple[dict[str, Derivatives] | None, dict[str, SparsePolynomial] | None]:
        """Derivatives and polynomials of the group that an item belongs to; None where they were not loaded."""
        group = dependence_group(item)
        return getattr(self, f"{group}derivatives"), getattr(self, f"{group}affine")

    @property
    def all_derivatives(self) -> dict[str, Derivatives]:
        """Derivatives by item, of all groups that were loaded."""
        return {**(self.derivatives or {}), **(self.element_derivatives or {}), **(self.section_derivatives or {})}

    @property
    def all_polynomials(self) -> dict[str, SparsePolynomial]:
        """Polynomials by item, of all groups that were loaded."""
        return {**(self.affine or {}), **(self.element_affine or {}), **(self.section_affine or {})}

    def item(self, name: str) -> np.ndarray:
        """Array at the nominal design, by its item name."""
        group, *rest = name.split(".")
        if not rest:
            return getattr(self.invariants, name)
        owner = getattr(self, group)
        return getattr(owner[rest[0]] if len(rest) == 2 else owner, rest[-1])


OWN_GROUPS = {"elements": "element_", "piece_loads": "element_", "sections": "section_"}
"""Part -> what the names of the groups of its derivatives and polynomials begin with; all other parts share one group of each."""


def dependence_group(item: str) -> str:
    """Prefix of the names of the groups with an item's derivatives and polynomial; empty for most items."""
    return OWN_GROUPS.get(item.partition(".")[0], "")


def generalized_mass(inv: Invariants) -> np.ndarray:
    """Mass matrix of the undeformed, unrotated body in (r, theta, q_f), theory section 1, scaled to a unit diagonal."""
    n = len(inv.stiffness)
    m = np.zeros((3 + n, 3 + n))
    m[0, 0] = m[1, 1] = inv.mass
    m[2, 0], m[2, 1] = -inv.first_moment[1, 0], inv.first_moment[0, 0]
    m[2, 2] = inv.inertia[0, 0]
    m[3:, :2] = inv.first_moment[:, 1:].T
    m[3:, 2] = inv.gyroscopic[0, 1:]
    m[3:, 3:] = inv.inertia[1:, 1:]
    m = np.tril(m) + np.tril(m, -1).T
    scale = 1 / np.sqrt(np.diag(m).clip(np.finfo(float).tiny))
    return scale[:, None] * m * scale


def generalized_lengths(inv: Invariants) -> np.ndarray:
    """RMS displacement of the whole body per unit of each elastic coordinate, sqrt(G_ii / m), shape (n_f,)."""
    return np.sqrt(np.diag(inv.inertia)[1:] / inv.mass)


_BEGIN = "chord: the first point stays in its place in the frame and the second on the line through both, of "
_BETWEEN = "/"
"""No name of an interface point has it."""


class Chord(NamedTuple):
    """Two interface points that the frame of a body goes through."""

    first: str
    second: str

    @property
    def condition(self) -> str:
        """Reference condition of the chord in words."""
        return f"{_BEGIN}{self.first}{_BETWEEN}{self.second}"


def chord_of(reference_condition: str) -> Chord | None:
    """Interface points of a chord from its reference condition; None of any other reference condition."""
    if not reference_condition.startswith(_BEGIN):
        return None
    first, _, second = reference_condition.removeprefix(_BEGIN).partition(_BETWEEN)
    return Chord(first, second)
