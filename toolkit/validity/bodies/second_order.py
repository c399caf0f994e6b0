"""Second-order displacement of a chain of beam elements: what its linear displacement u leaves out when elements turn.

With the deformations a, psi, phi of `element_sections`, the exact ones of an element whose chord turns with it are, to second order,

    elongation  a + L psi^2 / 2,    rotation of the chord  psi - psi a / L

Their virtual work under the linear end forces N = E A a / L, m = m_1 + m_2 leaves the forces of second order

    N_2 = E A psi^2 / 2 + m psi / L          along the element
    Q_2 = N psi + (m a / L - m_2) / L        across it,    m_2 = 12 E I psi a / L^2
    m_2 / 2                                  at each end

which the same loads do not balance. So the corotational displacement is u + u_2 + ..., K u_2 = -f_2(u).
Every number is a polynomial of u, so that the result is exactly four times as large for twice the displacement.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from toolkit.validity.bodies.element_sections import BENDING, Elements, Sections

STILL = 1e-9
"""Part of the largest movement of a node below which it is round-off: clamped nodes of computed shapes move by some."""


def stiffness_matrix(elements: Elements, made_of: Sections) -> Any:
    """K of the whole chain on its nodal coordinates, sparse (n, n)."""
    rows, dofs = elements.rows()[:, [0, 2, 3]], elements.dofs
    law = np.zeros((len(dofs), 3, 3))
    law[:, 0, 0] = made_of.axial / elements.lengths
    law[:, 1:, 1:] = (made_of.bending / elements.lengths)[:, None, None] * BENDING
    blocks = np.einsum("eia,eij,ejb->eab", rows, law, rows)
    row, column = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
    n = 3 * len(elements.nodes)
    return sparse.coo_array((blocks.ravel(), (row.ravel(), column.ravel())), shape=(n, n)).tocsc()


def second_order_forces(elements: Elements, made_of: Sections, u: np.ndarray) -> np.ndarray:
    """f_2(u) for displacements (n_t, n), (n_t, n)."""
    length, dofs = elements.lengths, elements.dofs
    elongation, turn, *bent = np.einsum("eka,tea->kte", elements.rows(), u[:, dofs])
    psi = turn / length
    m = 6 * made_of.bending / length * (bent[0] + bent[1])
    m_2 = 12 * made_of.bending * psi * elongation / length**2
    axial = made_of.axial * psi**2 / 2 + m * psi / length
    shear = made_of.axial * elongation / length * psi + (m * elongation / length - m_2) / length
    force = axial[:, :, None] * elements.along + shear[:, :, None] * elements.across
    each = np.concatenate([-force, m_2[:, :, None] / 2, force, m_2[:, :, None] / 2], axis=2)
    found = np.zeros_like(u)
    np.add.at(found.T, dofs, np.moveaxis(each, 0, -1))
    return found


def second_order_displacement(elements: Elements, made_of: Sections, held: np.ndarray, u: np.ndarray) -> np.ndarray:
    """u_2 for displacements u (n_t, n) of a chain whose frame is held by the rows `held` (m, n) u = 0, (n_t, n)."""
    return displacements_under(elements, made_of, held, -second_order_forces(elements, made_of, u))


def displacements_under(elements: Elements, made_of: Sections, held: np.ndarray, loads: np.ndarray) -> np.ndarray:
    """Linear displacements of all elements under loads (n_t, n) on the nodal coordinates, held in the same way, (n_t, n).

    Unknowns are scaled to a unit diagonal, because a skin is far stiffer in tension than in bending.
    """
    stiffness = stiffness_matrix(elements, made_of)
    scale = 1 / np.sqrt(stiffness.diagonal())
    border = held * scale
    border = sparse.csc_array(border / np.linalg.norm(border, axis=1)[:, None])
    spread = sparse.diags_array(scale)
    system = sparse.block_array([[spread @ stiffness @ spread, border.T], [border, None]], format="csc")
    solved = splu(system).solve(np.vstack([loads.T * scale[:, None], np.zeros((len(held), len(loads)))]))
    return (scale[:, None] * solved[: len(scale)]).T


def clamped_rows(elements: Elements, shapes: np.ndarray) -> np.ndarray:
    """Rows (m, n) of the nodes that a tangent frame is tied to: those that the shapes (n, n_f) of the basis do not move."""
    moves = np.abs(shapes).reshape(len(elements.nodes), -1).max(axis=1)
    nodes = np.flatnonzero(moves <= moves.min() + STILL * moves.max())
    return np.eye(shapes.shape[0])[(3 * nodes[:, None] + np.arange(3)).ravel()]


def mean_rows(elements: Elements) -> np.ndarray:
    """Rows (3, n) of mean displacement and rotation, which a frame on mean axes does not feel; nodes weigh as the elements beside them."""
    weight = np.bincount(elements.connectivity.ravel(), np.repeat(elements.lengths / 2, 2), len(elements.nodes))
    arm = elements.nodes - weight @ elements.nodes / weight.sum()
    found = np.zeros((3, 3 * len(elements.nodes)))
    found[0, 0::3], found[1, 1::3] = weight, weight
    found[2, 0::3], found[2, 1::3] = -weight * arm[:, 1], weight * arm[:, 0]
    return found
