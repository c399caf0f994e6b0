"""Planar corotational Euler-Bernoulli beam elements: the linear element of `beam.py` in axes that turn with its chord.

An element of length L and nodal coordinates u_e = (x, y, rotation) at both ends has the deformed chord of length l and direction e_l,
n_l = e_l turned by +90 degrees, which has turned by alpha. Against the chord it deforms as the linear element does:

    a = l - L,    phi_i = rotation_i - alpha,    N = E A a / L,    m = E I / L [4 2; 2 4] phi
    r = [-e_l, 0, e_l, 0] = da/du_e,    s = [-n_l, 0, n_l, 0] = l dalpha/du_e,    b_i = dphi_i/du_e = (1 at rotation i) - s / l
    force      f = N r + m_1 b_1 + m_2 b_2
    tangent    E A / L r r^T + E I / L sum_ij [4 2; 2 4]_ij b_i b_j^T + N / l s s^T + (m_1 + m_2) / l^2 (r s^T + s r^T)

Rigid motions of any size leave no force. Crisfield, Non-linear Finite Element Analysis of Solids and Structures 1 (1991), chapter 7.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from preprocessing.elements import beam
from preprocessing.mesh.curve_mesh import CurveMesh

BENDING = np.array([[4.0, 2.0], [2.0, 4.0]])


class Deformed(NamedTuple):
    """All elements in a deformed state, first axis elements; complex if the displacements are."""

    chord: np.ndarray  # l
    stretch: np.ndarray  # a
    bend: np.ndarray  # phi (n_e, 2)
    r: np.ndarray  # (n_e, 6)
    s: np.ndarray  # (n_e, 6)
    b: np.ndarray  # (n_e, 2, 6)


@dataclass(frozen=True)
class Corotational:
    """A frame of corotational elements with rectangular sections; nodal displacements are (n,), three per node."""

    mesh: CurveMesh
    modulus: np.ndarray  # (n_e,)
    thickness: np.ndarray  # (n_e,)
    width: np.ndarray  # (n_e,)

    @cached_property
    def lengths(self) -> np.ndarray:
        """L, (n_e,)."""
        return beam.length(self.mesh.ends)

    @cached_property
    def axial(self) -> np.ndarray:
        """E A, (n_e,)."""
        return self.modulus * self.thickness * self.width

    @cached_property
    def bending(self) -> np.ndarray:
        """E I, (n_e,)."""
        return self.axial * self.thickness**2 / 12

    def deformed(self, u: np.ndarray) -> Deformed:
        """Lengths, deformations and their derivatives at displacements u; complex u gives complex steps."""
        moved, (along, across) = u.reshape(-1, 3)[self.mesh.connectivity], beam.directions(self.mesh.ends)
        side = self.mesh.ends[:, 1] - self.mesh.ends[:, 0] + moved[:, 1, :2] - moved[:, 0, :2]
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
        return self.axial / self.lengths * state.stretch, (self.bending / self.lengths)[:, None] * (state.bend @ BENDING)

    def force(self, u: np.ndarray) -> np.ndarray:
        """Internal forces on the nodal coordinates, (n,)."""
        state = self.deformed(u)
        force, moments = self.end_forces(state)
        each = force[:, None] * state.r + np.einsum("ei,eik->ek", moments, state.b)
        found = np.zeros(len(u), each.dtype)
        np.add.at(found, self.mesh.dofs, each)
        return found

    def tangent(self, u: np.ndarray) -> Any:
        """Derivative of `force`, sparse (n, n)."""
        state = self.deformed(u)
        (force, moments), r, s, b = self.end_forces(state), state.r, state.s, state.b
        turned = moments.sum(axis=1) / state.chord**2
        blocks = (self.axial / self.lengths)[:, None, None] * _outer(r, r) + (force / state.chord)[:, None, None] * _outer(s, s)
        blocks += (self.bending / self.lengths)[:, None, None] * np.einsum("eik,ij,ejl->ekl", b, BENDING, b)
        blocks += turned[:, None, None] * (_outer(r, s) + _outer(s, r))
        row, column = np.broadcast_arrays(self.mesh.dofs[:, :, None], self.mesh.dofs[:, None, :])
        return sparse.coo_array((blocks.ravel(), (row.ravel(), column.ravel())), shape=(len(u), len(u))).tocsc()

    def stress(self, u: np.ndarray) -> np.ndarray:
        """Stress E (eps + f kappa t / 2) at both ends, there at the fibres f = +1 and -1, (n_e, 2, 2)."""
        state = self.deformed(u)
        kappa = (state.bend @ BENDING) * [-1, 1] / self.lengths[:, None]
        fibre = self.thickness[:, None, None] / 2 * np.array([1, -1])
        return self.modulus[:, None, None] * ((state.stretch / self.lengths)[:, None, None] + kappa[:, :, None] * fibre)


def _outer(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, :, None] * b[:, None, :]


def _angle(cosine: np.ndarray, sine: np.ndarray, near: np.ndarray) -> np.ndarray:
    """The angle that is nearest to `near` of all with this cosine and sine; differentiable by complex steps."""
    angle = np.arctan2(np.real(sine), np.real(cosine))
    turns = np.round((np.real(near) - angle) / (2 * np.pi))
    return angle + np.arcsin(sine * np.cos(angle) - cosine * np.sin(angle)) + 2 * np.pi * turns
