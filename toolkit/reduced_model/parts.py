"""What a reduced model may hold beside its matrices: elements, sections, pieces, left-out shapes, spin, and space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

ELEMENT_COORDINATES = 6
"""Coordinates of an element: displacements x, y and the rotation of its first node, then of its second, in the axes of the model."""
SPATIAL_ELEMENT_COORDINATES = 12
"""The same in space: displacements along and rotations about x, y and z of its first node, then of its second."""
UNMOVED_PART = 1e-9
"""Part of the largest movement of a node below which it is round-off: clamped nodes of computed shapes move by some."""


@dataclass(frozen=True)
class Mesh:
    """The finite-element mesh, for pictures only; nodal coordinates are `recovery @ [1; q_f]`, per node x, y, rotation."""

    nodes: np.ndarray  # (n_nodes, 2), undeformed
    connectivity: np.ndarray  # (n_elements, 2)
    recovery: np.ndarray  # (3 n_nodes, 1 + n_f)
    outline: np.ndarray  # (n_rows, 2), the whole undeformed contour
    target_outline: np.ndarray  # (n_rows, 2), the whole target contour


@dataclass(frozen=True)
class Elements:
    """Invariants of every element on its own coordinates; those of a set of elements are their sums.

    With Z_e = [xi_e, 1] of an element, xi_e the undeformed places of its nodes, and otherwise as the invariants of the whole body. Models
    of beams have them whatever shapes their basis keeps.
    """

    nodes: np.ndarray  # (n_nodes, 2), undeformed
    connectivity: np.ndarray  # (n_elements, 2), first and second node
    mass: np.ndarray  # (n_elements,)
    first_moment: np.ndarray  # (n_elements, 2, 7)
    inertia: np.ndarray  # G (n_elements, 7, 7), symmetric
    gyroscopic: np.ndarray  # H (n_elements, 7, 7), antisymmetric
    stiffness: np.ndarray  # (n_elements, 6, 6)
    damping: np.ndarray  # (n_elements, 6, 6)
    stress_operator: np.ndarray  # (n_stress, 6), on the coordinates of the element that the stress point is in

    def held_nodes(self, mesh: Mesh | None) -> np.ndarray:
        """Numbers of the nodes that the frame of the whole body is tied to: those that no column of the mesh moves but by round-off."""
        if mesh is None:
            return np.zeros(0, int)
        moved: np.ndarray = mesh.recovery[:, 1:].reshape(len(mesh.nodes), -1)
        return np.flatnonzero(np.abs(moved).max(axis=1, initial=0.0) <= UNMOVED_PART * np.abs(moved).max(initial=0.0))

    def shapes(self, mesh: Mesh | None) -> np.ndarray | None:
        """Nodal coordinates per elastic coordinate of the whole body, (3 n_nodes, n_f); None if they were not stored."""
        return None if mesh is None else mesh.recovery[:, 1:]


@dataclass(frozen=True)
class SpatialElements:
    """Invariants of every element on its own coordinates, with Q[a, b] in the order of `SpatialInvariants`."""

    nodes: np.ndarray  # (n_nodes, 3), undeformed
    connectivity: np.ndarray  # (n_elements, 2), first and second node
    held: np.ndarray  # (n_held,) nodes that the frame of the whole body is tied to
    mass: np.ndarray  # (n_elements,)
    first_moment: np.ndarray  # (n_elements, 3, 13)
    second_moment: np.ndarray  # (n_elements, 6, 13, 13)
    stiffness: np.ndarray  # (n_elements, 12, 12)
    damping: np.ndarray  # (n_elements, 12, 12)
    stress_operator: np.ndarray  # (n_stress n_components, 12), on the coordinates of the element that the stress point is in

    def held_nodes(self, _mesh: Mesh | None) -> np.ndarray:
        """Numbers of the nodes that the frame of the whole body is tied to, as stored in `held`."""
        return self.held

    def shapes(self, _mesh: Mesh | None) -> np.ndarray | None:
        """Nodal coordinates per elastic coordinate, (6 n_nodes, n_f): all of nodes that are not held; None if none is held."""
        if not len(self.held):
            return None
        count = len(self.nodes)
        free = np.repeat(~np.isin(np.arange(count), self.held), SPATIAL_ELEMENT_COORDINATES // 2)
        found: np.ndarray = np.eye(len(free))[:, free]
        return found


@dataclass(frozen=True)
class BeamSections:
    """Stiffness and mass per length of straight beam elements, and the fibres whose stress the model tells.

    A section lies in the principal axes e_2 and e_3 of its element. In the plane there is one plane of bending: e_2 is the direction of the
    element turned by +90 degrees, and e_3 the z axis. The stress of a fibre at y_2, y_3 is

        stress_per_strain (eps - y_2 kappa_2 - y_3 kappa_3)

    with the axial strain eps and the curvatures kappa of the deflections along e_2 and e_3.
    """

    axis: np.ndarray  # (n_elements, 3), the e_3 of each section before it is made normal to its element
    stress_per_strain: np.ndarray  # (n_elements,), E or, in plane strain, E / (1 - nu^2)
    axial_stiffness: np.ndarray  # E A (n_elements,)
    bending_stiffness: np.ndarray  # E I (n_elements, 1), in space (n_elements, 2) of deflections along e_2 and e_3
    torsional_stiffness: np.ndarray  # G J (n_elements,), zero in the plane
    shear_stiffness: np.ndarray  # kappa G A (n_elements,), zero where shear does not deform the elements
    mass_per_length: np.ndarray  # (n_elements,)
    fibre_distance: np.ndarray  # y_2 (n_stress, 1), in space y_2 and y_3 (n_stress, 2), of every stress point

    def of_elements(self, first: int, last: int) -> BeamSections:
        """Sections of the elements from `first` up to, but without, `last`, without the fibres of stress points."""
        found = {name: array[first:last] for name, array in vars(self).items() if name != "fibre_distance"}
        return BeamSections(**found, fibre_distance=self.fibre_distance[:0])

    @property
    def real(self) -> BeamSections:
        """Sections without imaginary steps."""
        return BeamSections(**{name: np.real(array) for name, array in vars(self).items()})


@dataclass(frozen=True)
class Interior:
    """The nodes of a plane meshed body and the stress there, for pictures: points are `position @ [1; q_f]`.

    The stress at a node is the mean of the elements that meet there, each at that node: E `stress` @ q_f, where E is the parameter that
    `modulus` counts.
    """

    position: np.ndarray  # (n_points, 2, 1 + n_f)
    triangles: np.ndarray  # (n_triangles, 3) points; elements with more nodes are several
    stress: np.ndarray  # (n_points, 4, n_f) xx, yy, zz, xy in the body's axes, in parts of the modulus
    modulus: np.ndarray  # () number of the parameter


@dataclass(frozen=True)
class LeftOutShapes:
    """Static responses of all shapes that the basis leaves out, to unit loads, at the nominal design.

    With the nodal forces F of the loads, and the modes Phi and eigenvalues Lambda that are left out, which do no work on what is kept,

        C = F^T R F,    B R F,    R = Phi Lambda^-1 Phi^T

    The loads are, of every interface point in the order of their names, forces along the axes and moments about them (in the plane one);
    then what pulls at every mass alike, along each axis; what pulls along axis a as the place along b grows, a before b; and what pulls
    as each shape that is kept moves.
    """

    compliance: np.ndarray  # C (n, n): twice the energy of two loads, and what each moves along the other
    stress_operator: np.ndarray  # B R F (n_stress n_components, n)

    def __len__(self) -> int:
        return len(self.compliance)


def count_of_loads(points: int, dimension: int, n_f: int) -> int:
    """Number of unit loads on a body with so many interface points and elastic shapes."""
    return points * (3 if dimension == 2 else 6) + dimension + dimension**2 + n_f


@dataclass(frozen=True)
class Pieces:
    """Surface points by the piece that each belongs to: places are `position @ [1; u]`, u of the nodes of the element."""

    element: np.ndarray  # (n_points,)
    position: np.ndarray  # (n_points, 3, 13)


@dataclass(frozen=True)
class PieceLoads:
    """A unit pressure on a named surface, piece by piece: f and L of `SurfaceLoad`, on [1; u] of the nodes of the element.

    Under such forces at its ends the piece moves these as the pressure would at rest; how it deforms between them is not in it.
    """

    force: np.ndarray  # (n_elements, 3)
    moment: np.ndarray  # (n_elements, 3, 3, 13)


PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Components (a, b) of the six stored matrices Q[a, b]; the others are their transposes, Q[b, a] = Q[a, b]^T."""


@dataclass(frozen=True)
class SpatialInvariants:
    """Invariants of a spatial body, theory section 1, with Z = [xi, Psi] and n_f elastic coordinates.

        m     = t_a^T M_aa t_a             N[a, :] = t_a^T M_aa Z          Q[a, b] = Z^T M_ab Z
        K     = Psi^T K_fe Psi             D       = Psi^T D_fe Psi

    `stress_operator` maps the elastic coordinates to the stress at every stress point: six components (xx, yy, zz, yz, xz, xy) in the
    body's axes, or one (the stress of a fibre).
    """

    mass: np.ndarray  # ()
    first_moment: np.ndarray  # N (3, 1 + n_f)
    second_moment: np.ndarray  # Q (6, 1 + n_f, 1 + n_f) in the order of `PAIRS`
    stiffness: np.ndarray  # (n_f, n_f)
    damping: np.ndarray  # (n_f, n_f)
    stress_operator: np.ndarray  # (n_stress, 6 or 1, n_f)

    moments: ClassVar[tuple[str, ...]] = ("second_moment",)
    """Names of the arrays that are integrals of products of shapes."""

    @property
    def inertia_about_origin(self) -> np.ndarray:
        """Sum of Q[a, a] (1 + n_f, 1 + n_f): the kinetic energy's squares of deformation rates."""
        return self.second_moment[:3].sum(axis=0)

    def mass_across(self, axis: np.ndarray) -> np.ndarray:
        """Elastic mass that moves across an axis with unit vector n, sum_a Q[a, a] - sum_ab n_a n_b Q[a, b], (n_f, n_f)."""
        Q = all_second_moments(self.second_moment)
        return (np.einsum("aaij->ij", Q) - np.einsum("a,b,abij->ij", axis, axis, Q))[1:, 1:]


SURFACE_POSITION = "surface.position"
"""Item of the model that is where the points of its surface are."""


@dataclass(frozen=True)
class Surface:
    """The surface of a body, for pictures: points are `position @ [1; q_f]`.

    Stress points with six components are the surface's points, in their order; those with one are the ends of its lines in turn.
    """

    position: np.ndarray  # (n_points, 3, 1 + n_f)
    triangles: np.ndarray  # (n_triangles, 3) points, seen from outside counter-clockwise
    lines: np.ndarray  # (n_lines, 2) points; of beams, which have no triangles


@dataclass(frozen=True)
class SurfaceLoad:
    """A unit pressure on a named surface, normal to it in the undeformed body, theory chapter 12.

        f_a = - int n_a dA         L[a, b] = - int n_a (S Z)_b dA

    with the outer normal n and axes a and b of the body.
    """

    force: np.ndarray  # f (3,)
    moment: np.ndarray  # L (3, 3, 1 + n_f)


def all_second_moments(stored: np.ndarray) -> np.ndarray:
    """All nine Q[a, b] (3, 3, 1 + n_f, 1 + n_f) from the six that are stored."""
    found = np.zeros((3, 3, *stored.shape[1:]), stored.dtype)
    for matrix, (a, b) in zip(stored, PAIRS, strict=True):
        found[b, a] = matrix.T
        found[a, b] = matrix
    return found


def spatial_generalized_mass(inv: SpatialInvariants) -> np.ndarray:
    """Mass matrix of the undeformed, unrotated body in (r, rotation vector, q_f), theory section 1, scaled to a unit diagonal."""
    n, Q = len(inv.stiffness), all_second_moments(inv.second_moment)
    moments = Q[:, :, 0, 0]
    coupling = np.stack([Q[1, 2, 0, 1:] - Q[2, 1, 0, 1:], Q[2, 0, 0, 1:] - Q[0, 2, 0, 1:], Q[0, 1, 0, 1:] - Q[1, 0, 0, 1:]])
    x, y, z = inv.first_moment[:, 0]
    m = np.zeros((6 + n, 6 + n))
    m[:3, :3] = inv.mass * np.eye(3)
    m[:3, 3:6] = -np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    m[:3, 6:] = inv.first_moment[:, 1:]
    m[3:6, 3:6] = np.trace(moments) * np.eye(3) - moments
    m[3:6, 6:] = coupling
    m[6:, 6:] = Q[0, 0, 1:, 1:] + Q[1, 1, 1:, 1:] + Q[2, 2, 1:, 1:]
    m = np.triu(m) + np.triu(m, 1).T
    scale = 1 / np.sqrt(np.diag(m).clip(np.finfo(float).tiny))
    return scale[:, None] * m * scale


def spatial_lengths(inv: SpatialInvariants) -> np.ndarray:
    """RMS displacement of the whole body per unit of each elastic coordinate, sqrt(sum_a Q[a, a]_ii / m), shape (n_f,)."""
    return np.sqrt(np.diag(inv.second_moment[:3].sum(axis=0))[1:] / inv.mass)


SPIN_STIFFENING = "spin.stiffening"
"""The item of a reduced model."""


@dataclass(frozen=True)
class Spin:
    """Geometric stiffness of the stress under the centrifugal forces of unit spins, theory section 1.

    A spin omega of the frame adds omega^2 S to the stiffness in the plane, in space sum_ab omega_a omega_b S_ab.
    """

    stiffening: np.ndarray  # (1, n_f, n_f) S; in space (6, n_f, n_f), S_ab in the order of `spatial_model.PAIRS`


def stiffness_of_spin(stiffening: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Stiffness (n_f, n_f) added by a spin (3,), which is given in space in the axes of the reduced model."""
    if len(stiffening) == 1:
        found: np.ndarray = omega @ omega * stiffening[0]
        return found
    weights = [omega[a] * omega[b] * (1 if a == b else 2) for a, b in PAIRS]
    return np.tensordot(np.array(weights), stiffening, axes=1)
