"""Straight beam elements between two nodes, in space and in the plane: linear along and in torsion, Hermite cubic across.

Nodal coordinates of an element: x, y, z and the rotations about these axes at its first end, then at its second, all in the global axes.
With r in [0, 1] along the element, L its length, e_1 its direction and e_2, e_3 the principal axes of its section,

    displacement of the centre line   u(r)  = e_1 a + e_2 v + e_3 w                   = S(r) u_e
    rotation of the section           th(r) = e_1 phi - e_2 w'/L + e_3 v'/L           = T(r) u_e
    a point e_k of the section off the centre line moves by              th x e_k     = R_k(r) u_e

with a and phi linear, v the Hermite cubic of the ends' displacements along e_2 and rotations about e_3, and w that of the displacements
along e_3 and rotations about -e_2:

    a: (1 - r) u_1 + r u_2
    v: (1 - 3r^2 + 2r^3) v_1 + L (r - 2r^2 + r^3) th_1 + (3r^2 - 2r^3) v_2 + L (r^3 - r^2) th_2

An element of the plane is one whose nodes, displacements and e_2 lie in the plane; its coordinates are x, y and the rotation about z of
both ends, e_2 is its direction turned by +90 degrees, and e_3 = z.

The offset of a point of the section is no displacement of the nodes. So that the places of all points are products with one vector, the
element has one more coordinate, the *offset*, which is one in the undeformed shape xi and zero in every displacement: the point at y_2, y_3
is at ([S, 0] + [R_2, e_2] y_2 + [R_3, e_3] y_3) [u_e; 1].

With shear (Timoshenko's beam) the section turns against the line by a strain gamma that is constant along the element,

    th of bending = v'/L - gamma,    gamma = Phi / (1 + Phi) ((v_2 - v_1) / L - (th_1 + th_2) / 2),    Phi = 12 E B / (kappa G A L^2)

B the second moment, and v is the Hermite cubic of the slopes th_i + gamma: exact between loads at the nodes.

All functions are polynomial coefficients or matrices of all elements at once (first axis), for unit parameters of the section. Rotary
inertia of bending and torsion together is as the mass of the section's points has it. Without it the textbook matrices: Przemieniecki,
Theory of Matrix Structural Analysis (1968), chapters 5 and 11.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Scalar

SECOND, THIRD = 1, 2
"""Numbers of the section's principal axes e_2 and e_3 among the axes of an element."""
IN_PLANE = [0, 1, 5, 6, 7, 11]
"""Coordinates of an element of the plane among those of one in space."""

AXIAL = np.array([[1, 0], [-1, 1], [0, 0], [0, 0]])
"""Powers of r (rows) in the functions of u_1, u_2."""
HERMITE = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [-3, -2, 3, -1], [2, 1, -2, 1]])
"""Powers of r (rows) in the functions of v_1, L th_1, v_2, L th_2."""
TILTED = HERMITE[:, 1] + HERMITE[:, 3]
"""Powers of r in the deflection, in parts of the length, of slopes of one at both ends."""
POWERS = np.arange(4)
MOMENTS = 1 / (POWERS[:, None] + POWERS + 1)
"""int r^j r^k dr on [0, 1]."""


@dataclass(frozen=True, eq=False)
class BeamElements:
    """Beam elements at one design; complex where their ends, or Phi, make a complex step."""

    ends: np.ndarray  # (n_e, 2, 3)
    axes: np.ndarray  # (n_e, 3, 3) unit vectors e_1, e_2, e_3 as rows
    phi: np.ndarray | None = None  # (n_e, 2) Phi of deflections along e_2 and e_3; None without shear
    planar: bool = False  # whether they are elements of the plane

    @classmethod
    def in_space(cls, ends: np.ndarray, orientation: np.ndarray, phi: np.ndarray | None = None) -> BeamElements:
        """Elements in space between ends (n_e, 2, 3).

        e_3 is the orientation (n_e, 3) without its part along e_1, to which it must not be parallel.
        """
        along = (ends[:, 1] - ends[:, 0]) / length(ends)[:, None]
        third = orientation - (orientation * along).sum(axis=1)[:, None] * along
        third = third / np.sqrt((third**2).sum(axis=1))[:, None]
        return cls(ends, np.stack([along, np.cross(third, along), third], axis=1), phi)

    @classmethod
    def in_plane(cls, ends: np.ndarray, phi: np.ndarray | None = None) -> BeamElements:
        """Elements in the plane between ends (n_e, 2, 2), with Phi (n_e,)."""
        flat = np.concatenate([ends, np.zeros((len(ends), 2, 1))], axis=2)
        both = None if phi is None else np.column_stack([phi, 0 * phi])
        spatial = cls.in_space(flat, np.tile([0.0, 0.0, 1.0], (len(ends), 1)), both)
        return cls(flat, spatial.axes, both, planar=True)

    @cached_property
    def lengths(self) -> np.ndarray:
        """Lengths L of the elements, (n_e,)."""
        return length(self.ends)

    @property
    def planes(self) -> tuple[int, ...]:
        """Numbers of the axes that the elements deflect along: e_2, and in space e_3."""
        return (SECOND,) if self.planar else (SECOND, THIRD)

    @cached_property
    def shape(self) -> np.ndarray:
        """Coefficients of r^k in the displacement S(r) of the centre line in global axes, (n_e, 4, d, p)."""
        parts = [self._of_ends(0, AXIAL, 0), *(self._transverse(axis) for axis in (SECOND, THIRD))]
        found = sum(self.axes[:, None, k, :, None] * part[:, :, None, :] for k, part in enumerate(parts))
        return self._own(found[:, :, :2] if self.planar else found)

    @cached_property
    def rotation(self) -> np.ndarray:
        """Coefficients of r^k in the rotation T(r) of the section, (n_e, 4, p), in space about the global axes, (n_e, 4, 3, p)."""
        return self._own(self._rotation[:, :, 2] if self.planar else self._rotation)

    @cached_property
    def offsets(self) -> list[np.ndarray]:
        """Coefficients of r^k in [R(r), e] in every plane, (n_e, 4, d, p + 1).

        [R(r), e] moves a point of the section at a unit of e.
        """
        return [self._offset(axis) for axis in self.planes]

    @cached_property
    def component_mass(self) -> np.ndarray:
        """Component mass matrices M_ab = L int S_a^T S_b dr for unit mass per length, (n_e, d, d, p, p)."""
        return self.products(self.shape)

    @cached_property
    def rotary_mass(self) -> list[np.ndarray]:
        """Component mass matrices L int [R, e]_a^T [R, e]_b dr in every plane, for unit rho int y^2 dA.

        They are `component_mass` for the section's spread, one coordinate larger.
        """
        return [self.products(each) for each in self.offsets]

    @cached_property
    def strain(self) -> np.ndarray:
        """Row eps = a'/L of the axial strain, constant along the element, (n_e, p)."""
        return self._own(self._of_ends(0, AXIAL, 0)[:, 1] / self.lengths[:, None])

    @cached_property
    def twist_rate(self) -> np.ndarray:
        """Row phi'/L of the twist per length, constant along the element, (n_e, p)."""
        return self._own(self._of_ends(0, AXIAL, 3)[:, 1] / self.lengths[:, None])

    @cached_property
    def curvature(self) -> list[np.ndarray]:
        """Rows v''/L^2 at both ends in every plane, (n_e, 2, p); the strain at y is -y times it.

        Positive turns from e_1 to e_2 or e_3.
        """
        return [self._own(self._curvature(axis)) for axis in self.planes]

    @cached_property
    def stretching(self) -> np.ndarray:
        """Rows F (n_e, 1, p) of the stiffness F^T F for unit E A."""
        return self._root * self.strain[:, None]

    @cached_property
    def torsion(self) -> np.ndarray:
        """Rows F (n_e, 1, p) of the stiffness F^T F for unit G J (Saint-Venant)."""
        return self._root * self.twist_rate[:, None]

    @cached_property
    def bending(self) -> list[np.ndarray]:
        """Rows F (n_e, 2, p) of the bending stiffness F^T F in every plane, for unit E int y^2 dA.

        The curvature is linear along the element, and the integral of its square is that of its mean and of its difference between the
        ends, L (mean^2 + difference^2 / 12).
        """
        return [
            self._root * np.stack([each.mean(axis=1), (each[:, 1] - each[:, 0]) / np.sqrt(12)], axis=1) for each in self.curvature
        ]

    @cached_property
    def shearing(self) -> list[np.ndarray]:
        """Rows F (n_e, 1, p) of the shear stiffness F^T F in every plane, for unit kappa G A; zero without shear."""
        return [self._own(self._root * self._shear_strain(axis)[:, None]) for axis in self.planes]

    @cached_property
    def turning(self) -> list[np.ndarray]:
        """Rows F (n_e, 3, p) in every plane whose squares sum up to the integral of v'^2 along the element."""
        root = np.linalg.cholesky(MOMENTS[:3, :3])  # a slope is quadratic
        slopes = (self._slope(self._transverse(axis))[:, :3] for axis in self.planes)
        return [self._own(self._root * np.einsum("jk,ejp->ekp", root, each)) for each in slopes]

    def _own(self, coefficients: np.ndarray, *more: int) -> np.ndarray:
        """Coefficients of the coordinates that the elements have: all in space, some in the plane."""
        return coefficients[..., [*IN_PLANE, *more]] if self.planar else coefficients

    @property
    def _root(self) -> np.ndarray:
        return np.sqrt(self.lengths)[:, None, None]

    def _transverse(self, axis: int) -> np.ndarray:
        """Coefficients of r^k in the displacement v(r) or w(r) along e_2 or e_3, (n_e, 4, 12)."""
        scaled = self.lengths[:, None] * self._turned_about(axis)
        found = self._of_ends(axis, HERMITE[:, 0::2], 0) + _of_ends(scaled, HERMITE[:, 1::2], 3)
        if self.phi is None:
            return found
        return found + (self.lengths[:, None] * self._shear_strain(axis))[:, None, :] * TILTED[:, None]

    def _turned_about(self, axis: int) -> np.ndarray:
        """Axis about which a slope along `axis` turns, (n_e, 3)."""
        return self.axes[:, THIRD] if axis == SECOND else -self.axes[:, SECOND]

    def _shear_strain(self, axis: int) -> np.ndarray:
        """Row gamma of the strain by a shear force along `axis`, constant along the element, (n_e, 12)."""
        phi = np.zeros((len(self.ends), 2)) if self.phi is None else self.phi
        own, row = phi[:, axis - 1, None], np.zeros((len(self.ends), 12), np.result_type(self.axes, phi))
        for end, sign in ((0, -1), (6, 1)):
            row[:, end : end + 3] = sign * self.axes[:, axis] / self.lengths[:, None]
            row[:, end + 3 : end + 6] = -self._turned_about(axis) / 2
        return own / (1 + own) * row

    def _of_ends(self, axis: int, functions: np.ndarray, first: int) -> np.ndarray:
        return _of_ends(self.axes[:, axis], functions, first)

    def _slope(self, functions: np.ndarray) -> np.ndarray:
        """Coefficients of the derivative by the place along the element, (n_e, 4, 12)."""
        coefficients = np.zeros_like(functions)
        coefficients[:, :-1] = POWERS[1:, None] * functions[:, 1:]
        return coefficients / self.lengths[:, None, None]

    @cached_property
    def _rotation(self) -> np.ndarray:
        parts = [self._of_ends(0, AXIAL, 3), -self._bent(THIRD), self._bent(SECOND)]
        found: np.ndarray = sum(self.axes[:, None, k, :, None] * part[:, :, None, :] for k, part in enumerate(parts))
        return found

    def _bent(self, axis: int) -> np.ndarray:
        """Coefficients of r^k in the slope of the line less the strain of shear: what the section turns by, (n_e, 4, 12)."""
        found = self._slope(self._transverse(axis))
        if self.phi is not None:
            found[:, 0] -= self._shear_strain(axis)
        return found

    def _curvature(self, axis: int) -> np.ndarray:
        functions = self._transverse(axis)
        at_ends = np.stack([2 * functions[:, 2], 2 * functions[:, 2] + 6 * functions[:, 3]], axis=1)
        return at_ends / self.lengths[:, None, None] ** 2

    def _offset(self, axis: int) -> np.ndarray:
        turned = np.cross(self._rotation, self.axes[:, None, axis, :, None], axisa=2, axisb=2, axisc=2)
        coefficients = np.zeros((*turned.shape[:3], 13), dtype=turned.dtype)
        coefficients[..., :12] = turned
        coefficients[:, 0, :, 12] = self.axes[:, axis]
        return self._own(coefficients[:, :, :2] if self.planar else coefficients, 12)

    def products(self, functions: np.ndarray) -> np.ndarray:
        """Integrals L int S_a^T S_b dr, (n_e, d, d, p, p), of functions by their coefficients of r^k, (n_e, 4, d, p)."""
        integral = np.einsum("ejap,jk,ekbq->eabpq", functions, MOMENTS, functions, optimize=True)
        return self.lengths[:, None, None, None, None] * integral


def length(ends: np.ndarray) -> np.ndarray:
    """Lengths (n_e,) of elements with ends (n_e, 2, d)."""
    return np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1))


def at_place(coefficients: np.ndarray, ratio: Scalar | np.ndarray) -> np.ndarray:
    """Functions of one element, by their coefficients of r^k (4, ..), at one place along it."""
    return np.tensordot(ratio**POWERS, coefficients, axes=1)


def _of_ends(directions: np.ndarray, functions: np.ndarray, first: int) -> np.ndarray:
    """Coefficients (n_e, 4, 12) of functions (4, 2) of a component of the ends' displacements (`first` 0) or rotations (3)."""
    coefficients = np.zeros((len(directions), 4, 12), dtype=directions.dtype)
    coefficients[:, :, first : first + 3] = functions[:, 0, None] * directions[:, None, :]
    coefficients[:, :, first + 6 : first + 9] = functions[:, 1, None] * directions[:, None, :]
    return coefficients
