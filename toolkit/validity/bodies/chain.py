"""Chains of beam elements behind a body: nodal displacements, deformations to second order, and elements as lines.

Second-order displacement of a chain of beam elements: what its linear displacement u leaves out when elements turn.

The deformations of an element, of its nodal coordinates u_e, and its energy are

    d = B u_e + u_e^T Q u_e / 2,    U = d^T S d / 2

with B and S of the linear element and Q of one that turns with its chord (`known_chain`). The forces of second order

    f_2 = B^T S (u_e^T Q u_e / 2) + (Q u_e)^T S B u_e

are not balanced by the loads of u. So the corotational displacement is u + u_2 + ..., K u_2 = -f_2(u). Every number is a polynomial of
u, so that the result is exactly four times as large for twice the displacement.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import ClassVar, NamedTuple

import numpy as np
import scipy

from toolkit.foundation.kinematics.beam_elements import BeamElements, at_place
from toolkit.foundation.near_ties import first_smallest
from toolkit.foundation.value_types import Matrix

UNMOVED_PART = 1e-9
"""Part of the largest movement of a node below which it is round-off: clamped nodes of computed shapes move by some."""
MOST_DENSE_COORDINATES = 100
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

    def assembled(self, blocks: np.ndarray) -> Matrix:
        """The sum of blocks (n_e, p, p) on the nodal coordinates, (n, n); sparse where there are many."""
        row, column = np.broadcast_arrays(self.dofs[:, :, None], self.dofs[:, None, :])
        if self.count < MOST_DENSE_COORDINATES:
            found = np.zeros((self.count, self.count))
            np.add.at(found, (row, column), blocks)
            return found
        return scipy.sparse.coo_array((blocks.ravel(), (row.ravel(), column.ravel())), shape=(self.count, self.count)).tocsc()


def stiffness_matrix(forms: Forms) -> Matrix:
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
    nodes = np.flatnonzero(moves <= moves.min() + UNMOVED_PART * moves.max())
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


@dataclass(frozen=True, eq=False)
class Chain(ABC):
    """A chain of elements with two nodes each, and how the elastic coordinates move them."""

    shapes: np.ndarray  # (n, n_f)
    held: np.ndarray  # (m, n) rows of displacements that the body's frame does not feel

    per_node: ClassVar[int]
    """Coordinates of a node: displacements, then rotations."""

    @property
    @abstractmethod
    def nodes(self) -> np.ndarray:
        """Undeformed positions of the nodes, (n_nodes, d)."""

    @abstractmethod
    def make_forms(self) -> Forms:
        """Deformations of the elements per displacement, to be kept as `forms`."""

    @abstractmethod
    def make_stiffening(self) -> np.ndarray:
        """Forms (n_e, k', p, p) whose sum, times the first k' forces of each element, is its geometric stiffness."""

    @cached_property
    def forms(self) -> Forms:
        """Deformations of the elements per displacement, and their law of forces."""
        return self.make_forms()

    @cached_property
    def stiffening(self) -> np.ndarray:
        """Forms of the geometric stiffness."""
        return self.make_stiffening()

    @property
    def is_full(self) -> bool:
        """Whether the basis holds all shapes that there are: all coordinates of nodes but those of the frame."""
        return self.shapes.shape[1] + len(self.held) >= self.shapes.shape[0]

    def displacements(self, elastic: np.ndarray) -> np.ndarray:
        """Nodal displacements (n_t, n) of elastic coordinates (n_t, n_f)."""
        return elastic @ self.shapes.T

    def second_order(self, u: np.ndarray) -> np.ndarray:
        """Displacements of second order that the linear displacements (n_t, n) lack."""
        return second_order_displacement(self.forms, self.held, u)

    def under(self, loads: np.ndarray) -> np.ndarray:
        """Linear displacements (n_t, n) of all elements under loads (n_t, n), whatever the basis holds."""
        return displacements_under(self.forms, self.held, loads)

    def axial_forces(self, u: np.ndarray) -> np.ndarray:
        """Axial forces of the elements (n_t, n_e), positive in tension, under displacements (n_t, n)."""
        return self.forms.forces(u)[:, :, 0]

    def by_node(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Displacements (n_t, n_nodes, d) and rotations (n_t, n_nodes, ..) of nodal displacements (n_t, n)."""
        each = u.reshape(len(u), -1, self.per_node)
        d = self.nodes.shape[1]
        return each[:, :, :d], each[:, :, d:]

    def distances(self, u: np.ndarray) -> np.ndarray:
        """Magnitudes (n_t, n_nodes) of nodal displacements (n_t, n)."""
        found: np.ndarray = np.linalg.norm(self.by_node(u)[0], axis=2)
        return found

    def rotations(self, u: np.ndarray) -> np.ndarray:
        """Angles (n_t, n_nodes) that nodal displacements (n_t, n) turn the nodes by."""
        found: np.ndarray = np.linalg.norm(self.by_node(u)[1], axis=2)
        return found


class Sides(NamedTuple):
    """Elements of a chain as straight lines: their nodes, lengths and directions."""

    ends: np.ndarray  # (n_e, 2)
    lengths: np.ndarray  # (n_e,)
    along: np.ndarray  # (n_e, d)


def sides_of(behind: Chain) -> Sides:
    """Straight lines of the undeformed elements of a chain."""
    numbers = behind.forms.dofs // behind.per_node
    ends = numbers[:, [0, -1]]
    sides = behind.nodes[ends[:, 1]] - behind.nodes[ends[:, 0]]
    lengths = np.linalg.norm(sides, axis=1)
    return Sides(ends, lengths, sides / lengths[:, None])


def chord_rows(nodes: np.ndarray, connectivity: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Rows (3, n): both displacements of the first point, and that of the second across the line through both, (2,) each."""
    first, second = (motion_rows(nodes, connectivity, point)[:2] for point in (one, other))
    side = other - one
    return np.vstack([first, (np.array([-side[1], side[0]]) / np.linalg.norm(side)) @ second])


def motion_rows(nodes: np.ndarray, connectivity: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Rows (3, n) of the displacement and the rotation at an undeformed place (2,) of the planar element that it is nearest to."""
    start, side = nodes[connectivity[:, 0]], nodes[connectivity[:, 1]] - nodes[connectivity[:, 0]]
    ratio = np.clip(np.einsum("ed,ed->e", place - start, side) / np.einsum("ed,ed->e", side, side), 0.0, 1.0)
    away = np.linalg.norm(start + ratio[:, None] * side - place, axis=1)
    e = first_smallest(away / np.linalg.norm(side, axis=1).sum())
    found, own = np.zeros((3, 3 * len(nodes))), (3 * connectivity[e][:, None] + np.arange(3)).ravel()
    element = BeamElements.in_plane(nodes[connectivity[[e]]])
    found[:2, own], found[2, own] = at_place(element.shape[0], ratio[e]), at_place(element.rotation[0], ratio[e])
    return found
