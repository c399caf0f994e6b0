"""Beam elements behind a reduced model: their linear deformations, and what they are made of, read back from the model itself.

An element of length L, with direction e and normal n = e turned by +90 degrees, and nodal coordinates u_e = (x, y, rotation) at both ends:

    a     = e . (u_2 - u_1)                        its elongation
    psi   = n . (u_2 - u_1) / L                    rotation of its chord
    phi_i = rotation_i - psi                       rotations of its ends against the chord
    axial force E A a / L,   end moments E I / L [4 2; 2 4] phi,   curvature at the ends -(4 phi_1 + 2 phi_2) / L, (2 phi_1 + 4 phi_2) / L
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from toolkit.reduced_model.model import Mesh, StressPoints
from toolkit.reduced_model.thin_arrays import is_sparse, sparing

CURVATURE = np.array([[-4.0, -2.0], [2.0, 4.0]])
"""Curvature at both ends, times L, per rotation of the ends against the chord."""
BENDING = np.array([[4.0, 2.0], [2.0, 4.0]])
"""Moments at both ends, times L / EI, per rotation of the ends against the chord."""
SHEARED = np.array([[-3.0, -3.0], [-3.0, -3.0]])
"""What Phi / (1 + Phi) of a beam that shear deforms adds to them."""
SHEAR = 1e-6
"""Phi below which elements know no shear."""

ROUND_OFF = 1e-10
"""Strain of an element, in parts of its displacement over its length, below which it is round-off: no shape of the basis strains it."""
WEAK = 1e-6
"""Part of the largest below which a combination of widths is left at their mean: the basis does not tell it."""


@dataclass(frozen=True)
class Elements:
    """Geometry of straight two-node elements."""

    nodes: np.ndarray  # (n_nodes, 2)
    connectivity: np.ndarray  # (n_e, 2)

    @cached_property
    def dofs(self) -> np.ndarray:
        """Numbers of the nodal coordinates of every element, (n_e, 6)."""
        return (3 * self.connectivity[:, :, None] + np.arange(3)).reshape(-1, 6)

    @cached_property
    def lengths(self) -> np.ndarray:
        """Lengths, (n_e,)."""
        return np.linalg.norm(self._sides, axis=1)

    @cached_property
    def along(self) -> np.ndarray:
        """Directions e, (n_e, 2)."""
        return self._sides / self.lengths[:, None]

    @cached_property
    def across(self) -> np.ndarray:
        """Normals n, (n_e, 2)."""
        return np.column_stack([-self.along[:, 1], self.along[:, 0]])

    @cached_property
    def _sides(self) -> np.ndarray:
        return self.nodes[self.connectivity[:, 1]] - self.nodes[self.connectivity[:, 0]]

    def rows(self) -> np.ndarray:
        """Rows of a, L psi, phi_1, phi_2 in the nodal coordinates of each element, (n_e, 4, 6)."""
        found = np.zeros((len(self.connectivity), 4, 6))
        for end, sign in ((0, -1), (3, 1)):
            found[:, 0, end : end + 2] = sign * self.along
            found[:, 1, end : end + 2] = sign * self.across
        found[:, 2:] = -found[:, 1:2] / self.lengths[:, None, None]
        found[:, 2, 2] += 1
        found[:, 3, 5] += 1
        return found


@dataclass(frozen=True)
class Sections:
    """Rectangular sections of all elements."""

    modulus: np.ndarray  # (n_e,) that of the elements: E, or E / (1 - nu^2) in plane strain
    thickness: np.ndarray  # (n_e,)
    width: np.ndarray  # (n_e,)
    phi: np.ndarray  # (n_e,) 12 E I / (kappa G A L^2) of elements that shear deforms, else zero

    @property
    def rectangles(self) -> dict[str, np.ndarray]:
        """Modulus, thickness and width, without shear."""
        return {"modulus": self.modulus, "thickness": self.thickness, "width": self.width}

    @property
    def law(self) -> np.ndarray:
        """Moments at both ends, times L / EI, per rotation of the ends against the chord, (n_e, 2, 2)."""
        return BENDING + (self.phi / (1 + self.phi))[:, None, None] * SHEARED

    @property
    def axial(self) -> np.ndarray:
        """E A = E b t, (n_e,)."""
        return self.modulus * self.width * self.thickness

    @property
    def bending(self) -> np.ndarray:
        """E I = E b t^3 / 12, (n_e,)."""
        return self.axial * self.thickness**2 / 12


def sections(mesh: Mesh, places: StressPoints, operator: np.ndarray, stiffness: np.ndarray, modulus: float) -> Sections:
    """Sections that the stress operator B and the stiffness K of a reduced model stand for.

    In each element, with the strain eps = a / L and the curvature kappa of all shapes of the basis,

        (B_outer + B_inner) / 2 = E eps,    B_outer - B_inner = E t kappa
        K = sum_e b_e (E t L eps^T eps + E t^3 / 12 L int kappa^T kappa)

    of which the first two give E and t, and the third, by least squares, the widths b. Elements that shear deforms have the curvature
    kappa, which is without shear, in the mean of both ends, and 1 / (1 + Phi) of it in half their difference.

    Parameters
    ----------
    operator, stiffness : (n_s, n_f), (n_f, n_f)
    modulus : that of elements which no shape of the basis stretches; those that none bends get the mean thickness
    """
    elements = Elements(mesh.nodes, mesh.connectivity)
    shapes = np.einsum("ekp,epf->ekf", elements.rows(), mesh.recovery[elements.dofs, 1:])
    eps = shapes[:, 0] / elements.lengths[:, None]
    kappa = np.einsum("ij,ejf->eif", CURVATURE, shapes[:, 2:]) / elements.lengths[:, None, None]
    stress = np.zeros((len(eps), 2, 2, operator.shape[1]))
    stress[places.element, places.end, (1 - places.fibre) // 2] = operator
    mean, difference = stress.mean(axis=(1, 2)), stress[:, :, 0] - stress[:, :, 1]
    least = ROUND_OFF * np.linalg.norm(mesh.recovery[elements.dofs, 1:].reshape(len(eps), -1), axis=1) / elements.lengths
    found = _ratio(mean, eps, least)
    found = np.where(np.isnan(found), modulus, found)
    thickness, phi = _thickness(difference, kappa, least / elements.lengths, found)
    made_of = Sections(found, thickness, np.ones(len(found)), phi)
    return replace(made_of, width=_widths(elements.lengths, shapes[:, [0, 2, 3]], made_of, stiffness))


def _thickness(
    difference: np.ndarray, kappa: np.ndarray, least: np.ndarray, modulus: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Thickness and Phi of each element, (n_e,), by what all shapes do to the stress and the curvature at its ends, (n_e, 2, n_f)."""
    count = len(kappa)
    (even, odd), (bent, tilted) = ((each.mean(axis=1), (each[:, 1] - each[:, 0]) / 2) for each in (difference, kappa))
    thickness, softer = _ratio(even, bent, least) / modulus, _ratio(odd, tilted, least) / modulus
    phi = thickness / softer - 1
    phi = np.where(phi > SHEAR, phi, 0.0)  # not where one of them is unknown
    plain = _ratio(difference.reshape(count, -1), kappa.reshape(count, -1), least) / modulus
    thickness = np.where(phi > 0, thickness, plain)
    return np.where(np.isnan(thickness), np.nanmean(thickness), thickness), phi


def _ratio(stress: np.ndarray, strain: np.ndarray, least: np.ndarray) -> np.ndarray:
    """Stress per strain of each element, (n_e,), over all shapes (n_e, n); nan where they strain the element less than `least`."""
    squares = np.einsum("ef,ef->e", strain, strain)
    known = squares > least**2
    return np.where(known, np.einsum("ef,ef->e", stress, strain) / np.where(known, squares, 1.0), np.nan)


def _widths(lengths: np.ndarray, shapes: np.ndarray, made_of: Sections, stiffness: np.ndarray) -> np.ndarray:
    """Least squares of K = sum_e b_e sum_i r_ei^T r_ei by its normal equations, as deviations from one common width.

    `r` are the rows (n_e, 3, n_f) whose squares are the energies of an element of unit width.
    """
    root = np.linalg.cholesky(made_of.law)
    axial = np.sqrt(made_of.axial / lengths)[:, None] * shapes[:, 0]
    bending = np.sqrt(made_of.bending / lengths)[:, None, None] * np.einsum("eji,ejf->eif", root, shapes[:, 1:])
    rows = np.concatenate([axial[:, None], bending], axis=1)
    n, flat = len(rows), sparing(rows)
    products = _summed((flat @ flat.T) ** 2, n)
    wanted = np.asarray((flat @ stiffness * flat).sum(axis=1)).reshape(n, 3).sum(axis=1)
    common = wanted.sum() / products.sum()
    return common + np.linalg.lstsq(products, wanted - common * products.sum(axis=1), rcond=WEAK)[0]


def _summed(squares: Any, n: int) -> np.ndarray:
    """Sums over the three rows, and the three columns, of each of n elements, (n, n)."""
    if not is_sparse(squares):
        found: np.ndarray = squares.reshape(n, 3, n, 3).sum(axis=(1, 3))
        return found
    of_element = scipy.sparse.kron(scipy.sparse.eye_array(n), np.ones((1, 3)), "csr")
    sparse: np.ndarray = (of_element @ squares @ of_element.T).toarray()
    return sparse
