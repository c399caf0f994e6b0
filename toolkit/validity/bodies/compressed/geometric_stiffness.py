"""Geometric stiffness of the beam elements behind a body: what their axial forces do to a lateral motion in the body's frame.

An element whose deflection w against the body's axes has the chord's rotation psi and the ends' rotations phi against the chord grows
shorter by half of

    int w'^2 dx = L psi^2 + L / 30 phi^T [4 -1; -1 4] phi        (the cubic deflection of an Euler-Bernoulli element)

so that its axial force N adds N times this form to the stiffness. Linear FFRF lacks it. What the frame's own rotation does to the forces
at joints is in the equations of motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csc_array, csr_array
from scipy.sparse.linalg import splu

from toolkit.scene.scene import Scene
from toolkit.solvers.direct_solve import MANY
from toolkit.solvers.static.stability.static_array import StaticArray, as_dense, scaled_by
from toolkit.system.flexible_bodies import flexible_body
from toolkit.validity.bodies.compressed.many_coordinates import Flexibility, largest_ratio
from toolkit.validity.bodies.deformation import Chain, chain

SHORTENING = np.array([[4.0, -1.0], [-1.0, 4.0]]) / 30
"""int w'^2 dx / L of a cubic deflection against the chord, by the rotations of the ends."""


@dataclass(frozen=True)
class Stiffening:
    """How the elements of one body stiffen it under tension, and soften it under compression; rows in its elastic coordinates."""

    forces: np.ndarray  # (n_e, n_f) axial forces, positive in tension
    turns: np.ndarray  # (n_e, 3, n_f) rows whose squares sum up to int w'^2 dx
    stiffness: np.ndarray  # (n_f, n_f)

    def matrix(self, elastic: np.ndarray) -> StaticArray:
        """G at elastic coordinates (n_f,), (n_f, n_f); sparse where there are many."""
        tension = np.repeat(self.forces @ elastic, self.turns.shape[1])[:, None]
        found: StaticArray = self._rows.T @ (tension * self._rows)
        return found

    def softening(self, elastic: np.ndarray) -> float:
        """The largest part of its elastic stiffness that compression takes from any motion of the body in its frame."""
        G, last = scaled_by(self.matrix(elastic), self._scale), len(self.stiffness) - 1
        found = None if isinstance(G, np.ndarray) else largest_ratio(-G, csr_array(self._scaled), self._flexible)
        if found is None:
            found = float(eigh(-as_dense(G), self._scaled, eigvals_only=True, subset_by_index=[last, last])[0])
        return max(found, 0.0)

    @cached_property
    def compliances(self) -> np.ndarray:
        """int w'^2 dx of every element under unit forces on all motions, (n_e,): which elements compression makes soft."""
        flat = (self.turns * self._scale).reshape(-1, len(self._scale))
        return np.einsum("rf,fr->r", flat, self._flexible(flat.T)).reshape(-1, 3).sum(axis=1)

    @cached_property
    def _rows(self) -> StaticArray:
        """`turns` under each other, (3 n_e, n_f)."""
        flat = self.turns.reshape(-1, len(self.stiffness))
        return csr_array(flat) if len(self.stiffness) >= MANY else flat

    @cached_property
    def _flexible(self) -> Flexibility:
        """The inverse of the scaled stiffness."""
        if len(self.stiffness) < MANY:
            return lambda forces: np.linalg.solve(self._scaled, forces)
        factors = splu(csc_array(self._scaled))
        return lambda forces: factors.solve(forces)

    @cached_property
    def _scale(self) -> np.ndarray:
        return 1 / np.sqrt(np.diag(self.stiffness))

    @cached_property
    def _scaled(self) -> np.ndarray:
        return self._scale[:, None] * self.stiffness * self._scale


def axial_forces(behind: Chain, u: np.ndarray) -> np.ndarray:
    """Of the elements under displacements (n_t, n), (n_t, n_e), positive in tension."""
    elongation = np.einsum("ep,tep->te", behind.elements.rows()[:, 0], u[:, behind.elements.dofs])
    return elongation * behind.made_of.axial / behind.elements.lengths


def stiffening(scene: Scene, body: str) -> Stiffening | None:
    """The geometric stiffness of a flexible body; None if its reduced model does not hold its finite elements."""
    behind = chain(scene, body)
    if behind is None:
        return None
    length = behind.elements.lengths
    shapes = np.einsum("ekp,epf->ekf", behind.elements.rows(), behind.shapes[behind.elements.dofs])
    root = np.sqrt(length)[:, None, None]
    chord = shapes[:, 1:2] / root  # sqrt(L) psi
    ends = root * np.einsum("ji,ejf->eif", np.linalg.cholesky(SHORTENING), shapes[:, 2:])
    forces = axial_forces(behind, behind.shapes.T).T
    stiffness = np.real(flexible_body(scene, body).invariants(scene).stiffness)
    return Stiffening(forces, np.concatenate([chord, ends], axis=1), stiffness)
