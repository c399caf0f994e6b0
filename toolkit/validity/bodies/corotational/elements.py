"""Planar corotational beam elements: the linear element of a chain (`planar_chain`) in axes that turn with its chord.

An element of length L and nodal coordinates u_e = (x, y, rotation) at both ends has the deformed chord of length l and direction e_l,
n_l = e_l turned by +90 degrees, which has turned by alpha. Against the chord it deforms as the linear element does:

    a = l - L,    phi_i = rotation_i - alpha,    N = E A a / L,    m = S phi, S = E I / L [4 2; 2 4] without shear
    r = [-e_l, 0, e_l, 0] = da/du_e,    s = [-n_l, 0, n_l, 0] = l dalpha/du_e,    b_i = dphi_i/du_e = (1 at rotation i) - s / l
    force      f = N r + m_1 b_1 + m_2 b_2
    tangent    E A / L r r^T + sum_ij S_ij b_i b_j^T + N / l s s^T + (m_1 + m_2) / l^2 (r s^T + s r^T)

Rigid motions of any size leave no force. Crisfield, Non-linear Finite Element Analysis of Solids and Structures 1 (1991), chapter 7.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from toolkit.reduced_model.model import StressPoints
from toolkit.reduced_model.parts import BeamSections
from toolkit.validity.bodies.chains.planar_chain import planar_law


class Deformed(NamedTuple):
    """Deformed state of all elements, first axis elements; complex if the displacements are."""

    chord: np.ndarray  # l
    stretch: np.ndarray  # a
    bend: np.ndarray  # phi (n_e, 2)
    r: np.ndarray  # (n_e, 6)
    s: np.ndarray  # (n_e, 6)
    b: np.ndarray  # (n_e, 2, 6)


@dataclass(frozen=True)
class Corotational:
    """A frame of corotational elements; nodal displacements are (n,), three per node."""

    nodes: np.ndarray  # (n_nodes, 2)
    connectivity: np.ndarray  # (n_e, 2)
    made_of: BeamSections

    @cached_property
    def dofs(self) -> np.ndarray:
        """Numbers of the nodal coordinates of every element, (n_e, 6)."""
        return (3 * self.connectivity[:, :, None] + np.arange(3)).reshape(-1, 6)

    @cached_property
    def sides(self) -> np.ndarray:
        """Vectors from the first to the second end of every undeformed element, (n_e, 2)."""
        return self.nodes[self.connectivity[:, 1]] - self.nodes[self.connectivity[:, 0]]

    @cached_property
    def lengths(self) -> np.ndarray:
        """Lengths L of the undeformed elements, (n_e,)."""
        return np.linalg.norm(self.sides, axis=1)

    @cached_property
    def law(self) -> np.ndarray:
        """Axial force and end moments by elongation and rotations against the chord, (n_e, 3, 3)."""
        return planar_law(self.made_of, self.lengths)

    def deformed(self, u: np.ndarray) -> Deformed:
        """Chord lengths, deformations and their derivatives at displacements u; complex u gives complex steps."""
        moved, along = u.reshape(-1, 3)[self.connectivity], self.sides / self.lengths[:, None]
        across = np.column_stack([-along[:, 1], along[:, 0]])
        side = self.sides + moved[:, 1, :2] - moved[:, 0, :2]
        chord = np.sqrt((side * side).sum(axis=1))
        e = side / chord[:, None]
        alpha = _angle((e * along).sum(axis=1), (e * across).sum(axis=1), moved[:, :, 2].mean(axis=1))
        zero = 0 * chord
        r = np.column_stack([-e, zero, e, zero])
        s = np.column_stack([e[:, 1], -e[:, 0], zero, -e[:, 1], e[:, 0], zero])
        b = np.repeat(-s[:, None] / chord[:, None, None], 2, axis=1)
        b[:, 0, 2] += 1
        b[:, 1, 5] += 1
        return Deformed(chord, chord - self.lengths, moved[:, :, 2] - alpha[:, None], r, s, b)

    def end_forces(self, state: Deformed) -> tuple[np.ndarray, np.ndarray]:
        """Axial force N (n_e,) and moments m at both ends (n_e, 2)."""
        return self.law[:, 0, 0] * state.stretch, np.einsum("eij,ej->ei", self.law[:, 1:, 1:], state.bend)

    def force(self, u: np.ndarray) -> np.ndarray:
        """Internal forces on the nodal coordinates, (n,)."""
        state = self.deformed(u)
        force, moments = self.end_forces(state)
        each = force[:, None] * state.r + np.einsum("ei,eik->ek", moments, state.b)
        found = np.zeros(len(u), each.dtype)
        np.add.at(found, self.dofs, each)
        return found

    def tangent(self, u: np.ndarray) -> Any:
        """Derivative of `force`, sparse (n, n)."""
        state = self.deformed(u)
        (force, moments), r, s, b = self.end_forces(state), state.r, state.s, state.b
        turned = moments.sum(axis=1) / state.chord**2
        blocks = self.law[:, 0, 0][:, None, None] * _outer(r, r) + (force / state.chord)[:, None, None] * _outer(s, s)
        blocks += np.einsum("eik,eij,ejl->ekl", b, self.law[:, 1:, 1:], b)
        blocks += turned[:, None, None] * (_outer(r, s) + _outer(s, r))
        row, column = np.broadcast_arrays(self.dofs[:, :, None], self.dofs[:, None, :])
        return sparse.coo_array((blocks.ravel(), (row.ravel(), column.ravel())), shape=(len(u), len(u))).tocsc()

    def stress(self, u: np.ndarray, places: StressPoints) -> np.ndarray:
        """Stress at stress points, (n_stress,): stress_per_strain (eps - y kappa) at a fibre y of one of the ends of an element."""
        state, made_of = self.deformed(u), self.made_of
        kappa = self._curvature(state.bend)[places.element, places.end]
        eps = (state.stretch / self.lengths)[places.element]
        stress: np.ndarray = made_of.stress_per_strain[places.element] * (eps - made_of.fibre_distance[:, 0] * kappa)
        return stress

    def linear_stress(self, u: np.ndarray, places: StressPoints) -> np.ndarray:
        """Stress of the linear elements, (n_stress,): the derivative of `stress` at rest."""
        return self.stress(1e-30j * u, places).imag / 1e-30

    def _curvature(self, bend: np.ndarray) -> np.ndarray:
        """Curvature at both ends, (n_e, 2): what bends the section, without what shear turns it by."""
        moments = np.einsum("eij,ej->ei", self.law[:, 1:, 1:], bend)
        return moments * [-1, 1] / self.made_of.bending_stiffness


def _outer(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, :, None] * b[:, None, :]


def _angle(cosine: np.ndarray, sine: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Angle with this cosine and sine that is nearest to `near`; differentiable by complex steps."""
    angle = np.arctan2(np.real(sine), np.real(cosine))
    turns = np.round((np.real(near) - angle) / (2 * np.pi))
    return angle + np.arcsin(sine * np.cos(angle) - cosine * np.sin(angle)) + 2 * np.pi * turns
