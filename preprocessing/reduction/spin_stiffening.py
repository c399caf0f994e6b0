"""How a spin stiffens a body in its own frame: the geometric stiffness of the stress that its centrifugal forces cause.

With the forces F_k of each product of angular velocities (`preprocessing.elements.element`), for unit angular velocity,

    K u_k = F_k held as the body's frame is held, or in balance with the inertia of a body that floats,   S_k = Psi^T K_g(u_k) Psi

where K_g is that of the elements, linear in u. The frame's spin omega stiffens by omega^2 S in the plane, in space by
sum_ij omega_i omega_j S_ij (Wallrapp and Schwertassek, Int. J. Numer. Methods Eng. 32, 1991). Not in it is the stress by accelerations
of the frame, by weight and by forces at points of the body.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse

from preprocessing.elements.element import Element
from preprocessing.reduction.assembly import Matrices, symmetric
from preprocessing.reduction.discretisation import STEP, derivative_of
from preprocessing.reduction.solid_systems import free_system, held_system
from preprocessing.reduction.sparse_modes import ShiftedSystem
from preprocessing.reduction.stored_entries import ROUND_OFF, SHAPE_ROUND_OFF, AnyInvariants
from toolkit.foundation.value_types import Matrix
from toolkit.reduced_model.parts import Spin


@dataclass(frozen=True, eq=False)
class Spun:
    """Spinning body at one design; complex where a parameter made a complex step."""

    element: Element
    values: Mapping[str, complex]  # of the parameters
    matrices: Matrices
    map: sparse.csr_array  # (nodal, n^): nodal coordinates of those that the frame and ties leave free
    z: Matrix  # [xi, Psi] (nodal, 1 + n_f)
    motions: np.ndarray | None = None  # (n^, m) rigid motions of a body that floats about mean axes; None of one that is held

    @cached_property
    def stiffness(self) -> sparse.csr_array:
        """Stiffness on the free coordinates, (n^, n^)."""
        return self._on_free(self.matrices.stiffness)

    @cached_property
    def mass(self) -> sparse.csr_array:
        """Mass on the free coordinates, (n^, n^)."""
        return self._on_free(self.matrices.mass)

    @cached_property
    def loads(self) -> np.ndarray:
        """Centrifugal forces F_k (n^, k), for a floating body with what its inertia adds."""
        space, nodal = self.matrices.coordinates.space, self.map.shape[0]
        column = self._whole_z[:, [0]]
        xi = column if isinstance(column, np.ndarray) else column.toarray()
        by_pair = dict(zip(space.pairs, self.matrices.m, strict=True))
        forces = [sum(weight * (symmetric(by_pair[pair]) @ xi) for pair, weight in spin) for spin in space.spins]
        found = self.map.T @ np.hstack(forces)[:nodal]
        if self.motions is None:
            return np.asarray(found)
        inertia = self.mass @ self.motions
        return np.asarray(found - inertia @ np.linalg.solve(self.motions.T @ inertia, self.motions.T @ found))

    def stiffened(self, free: np.ndarray) -> np.ndarray:
        """Geometric stiffness Psi^T K_g(u_k) Psi (k, n_f, n_f) of displacements (n^, k) on the free coordinates."""
        moved, psi = self.matrices.coordinates.displacement(self.map @ free), self._whole_z[:, 1:]
        every = (self.element.geometric_stiffness(self.values, u) for u in moved.T)
        products = (psi.T @ (stiffness @ psi) for stiffness in every)
        return np.stack([symmetric(each.toarray() if sparse.issparse(each) else each) for each in products])

    @property
    def _whole_z(self) -> Matrix:
        return self.matrices.coordinates.undeformed(self.z)

    def _on_free(self, matrix: sparse.csr_array) -> sparse.csr_array:
        return (self.map.T @ self.matrices.coordinates.of_nodes(matrix) @ self.map).tocsr()


@dataclass(frozen=True, eq=False)
class SpinStiffening:
    """Spin stiffening of a body at its nominal design, with the displacements under its centrifugal forces."""

    nominal: Spun
    places: np.ndarray | None = None  # (n^, d), where each free coordinate is

    @cached_property
    def value(self) -> np.ndarray:
        """Spin stiffening S (k, n_f, n_f): k = 1 in the plane, in space 6 in the order of `spatial_model.PAIRS`."""
        return self.nominal.stiffened(self._moved)

    def by(self, matrices: Matrices) -> np.ndarray:
        """Spin stiffening S (k, n_f, n_f) by centrifugal forces on some masses alone, of a body that is held."""
        return self.nominal.stiffened(self._system.solve(replace(self.nominal, matrices=matrices).loads))

    def stored(self, inv: AnyInvariants, selected: bool) -> Spin:
        """Spin stiffening for the reduced model; `selected`: of shapes that select coordinates, without others' round-off."""
        return Spin(_without_round_off(self.value, inv) if selected else self.value)

    def rate(self, stepped: Spun) -> np.ndarray:
        """Derivative of the spin stiffening by what made a complex step, from K du = dF - dK u."""
        left = derivative_of(stepped.loads - stepped.stiffness @ self._moved + 0j)
        return np.asarray(derivative_of(stepped.stiffened(self._moved + 1j * STEP * self._system.solve(left)) + 0j))

    @cached_property
    def _moved(self) -> np.ndarray:
        return np.asarray(self._system.solve(self.nominal.loads))

    @cached_property
    def _system(self) -> ShiftedSystem:
        body, n = self.nominal, self.nominal.map.shape[1]
        if body.motions is None:
            return held_system(body.stiffness, sparse.csr_array((0, n)), self.places)
        return free_system(body.stiffness, body.mass, body.motions, self.places)


def _without_round_off(value: np.ndarray, inv: AnyInvariants) -> np.ndarray:
    """Spin stiffening of a full basis with zeros in place of round-off, measured by the masses of the coordinates."""
    root = np.sqrt(np.diag(inv.inertia_about_origin)[1:])
    parts = np.abs(value) / np.outer(root, root)
    return np.where(parts > ROUND_OFF * parts.max(initial=0), value, 0.0)


def without_round_off_of_rate(rate: np.ndarray, value: np.ndarray, parameter: float) -> np.ndarray:
    """A derivative, or zeros where it is round-off of a value that does not depend on the parameter."""
    changes = parameter == 0 or np.abs(rate * parameter).max(initial=0) > SHAPE_ROUND_OFF * np.abs(value).max(initial=0)
    return rate if changes else np.zeros_like(rate)
