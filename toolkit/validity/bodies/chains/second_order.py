"""Second-order displacement of a chain of beam elements: what its linear displacement u leaves out when elements turn.

The deformations of an element, of its nodal coordinates u_e, and its energy are

    d = B u_e + u_e^T Q u_e / 2,    U = d^T S d / 2

with B and S of the linear element and Q of one that turns with its chord (`planar_chain`, `spatial_chain`). The forces of second order

    f_2 = B^T S (u_e^T Q u_e / 2) + (Q u_e)^T S B u_e

are not balanced by the loads of u. So the corotational displacement is u + u_2 + ..., K u_2 = -f_2(u). Every number is a polynomial of
u, so that the result is exactly four times as large for twice the displacement.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import scipy

STILL = 1e-9
"""Part of the largest movement of a node below which it is round-off: clamped nodes of computed shapes move by some."""
FEW = 100
"""Nodal coordinates up to which dense matrices cost less than the making of sparse ones."""


@dataclass(frozen=True, eq=False)
class Forms:
    """How all elements of a chain deform, with p coordinates and k deformations each; the first of these is the elongation."""

    count: int  # nodal coordinates of the chain
    dofs: np.ndarray  # (n_e, p) numbers of those of every element
    rows: np.ndarray  # B (n_e, k, p)
    law: np.ndarray  # S (n_e, k, k), symmetric
    curved: np.ndarray  # Q (n_e, k, p, p), symmetric

    def forces(self, u: np.ndarray) -> np.ndarray:
        """S B u_e of displacements (n_t, n), (n_t, n_e, k)."""
        found: np.ndarray = np.einsum("ekp,tep->tek", self.law @ self.rows, u[:, self.dofs])
        return found

    def turned(self, u: np.ndarray) -> np.ndarray:
        """Q u_e, by which displacements (n_t, n) change the rows B, (n_t, n_e, k, p)."""
        n_e, k, p = self.rows.shape
        found = self.curved.reshape(n_e, k * p, p) @ np.moveaxis(u[:, self.dofs], 0, -1)
        return np.moveaxis(found, -1, 0).reshape(len(u), n_e, k, p)

    def assembled(self, blocks: np.ndarray) -> Any:
        """The sum of blocks (n_e, p, p) on the nodal coordinates, (n, n); sparse where there are many."""
        row, column = np.broadcast_arrays(self.dofs[:, :, None], self.dofs[:, None, :])
        if self.count < FEW:
            found = np.zeros((self.count, self.count))
            np.add.at(found, (row, column), blocks)
            return found
        return scipy.sparse.coo_array((blocks.ravel(), (row.ravel(), column.ravel())), shape=(self.count, self.count)).tocsc()


def stiffness_matrix(forms: Forms) -> Any:
    """K of the whole chain on its nodal coordinates, (n, n); sparse where there are many."""
    return forms.assembled(np.swapaxes(forms.rows, 1, 2) @ forms.law @ forms.rows)


def second_order_forces(forms: Forms, u: np.ndarray) -> np.ndarray:
    """f_2(u) for displacements (n_t, n), (n_t, n)."""
    turned = forms.turned(u)
    growth = np.einsum("tekp,tep->tek", turned, u[:, forms.dofs]) / 2
    each = np.einsum("ekp,tek->tep", forms.law @ forms.rows, growth) + np.einsum("tekp,tek->tep", turned, forms.forces(u))
    found = np.zeros_like(u)
    np.add.at(found.T, forms.dofs, np.moveaxis(each, 0, -1))
    return found


def second_order_displacement(forms: Forms, held: np.ndarray, u: np.ndarray) -> np.ndarray:
    """u_2 for displacements u (n_t, n) of a chain whose frame is held by the rows `held` (m, n) u = 0, (n_t, n)."""
    return displacements_under(forms, held, -second_order_forces(forms, u))


def displacements_under(forms: Forms, held: np.ndarray, loads: np.ndarray) -> np.ndarray:
    """Linear displacements of all elements under loads (n_t, n) on the nodal coordinates, held in the same way, (n_t, n).

    Unknowns are scaled to a unit diagonal, because a skin is far stiffer in tension than in bending.
    """
    stiffness = stiffness_matrix(forms)
    scale = 1 / np.sqrt(stiffness.diagonal())
    border = held * scale
    border = border / np.linalg.norm(border, axis=1)[:, None]
    wanted = np.vstack([loads.T * scale[:, None], np.zeros((len(held), len(loads)))])
    if isinstance(stiffness, np.ndarray):
        none = np.zeros((len(held), len(held)))
        solved = np.linalg.solve(np.block([[scale[:, None] * stiffness * scale, border.T], [border, none]]), wanted)
    else:
        spread, rows = scipy.sparse.diags_array(scale), scipy.sparse.csc_array(border)
        solved = scipy.sparse.linalg.splu(
            scipy.sparse.block_array([[spread @ stiffness @ spread, rows.T], [rows, None]], format="csc")
        ).solve(wanted)
    return (scale[:, None] * solved[: len(scale)]).T


def clamped_rows(shapes: np.ndarray, per_node: int) -> np.ndarray:
    """Rows (m, n) of the nodes that a tangent frame is tied to: those that the shapes (n, n_f) of the basis do not move."""
    moves = np.abs(shapes).max(axis=1).reshape(-1, per_node).max(axis=1)
    nodes = np.flatnonzero(moves <= moves.min() + STILL * moves.max())
    return np.eye(shapes.shape[0])[(per_node * nodes[:, None] + np.arange(per_node)).ravel()]


def mean_rows(nodes: np.ndarray, connectivity: np.ndarray) -> np.ndarray:
    """Rows (m, n) of mean displacement and rotation, which a frame on mean axes does not feel; nodes weigh as the elements beside them."""
    d = nodes.shape[1]
    m = d * (d + 1) // 2
    lengths = np.linalg.norm(nodes[connectivity[:, 1]] - nodes[connectivity[:, 0]], axis=1)
    weight = np.bincount(connectivity.ravel(), np.repeat(lengths / 2, 2), len(nodes))
    arm = nodes - weight @ nodes / weight.sum()
    found = np.zeros((m, m * len(nodes)))
    for axis in range(d):
        found[axis, axis::m] = weight
    for row, (one, other) in enumerate(combinations(range(d), 2), start=d):
        found[row, one::m], found[row, other::m] = -weight * arm[:, other], weight * arm[:, one]
    return found
