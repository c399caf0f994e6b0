"""Geometric stiffness of the beam elements behind a body: what their forces do to a lateral motion in the body's frame.

An element that turns, or bows, changes its deformations by d_2 = u_e^T Q u_e / 2 (`planar_chain`, `spatial_chain`). Forces s of the linear
element do the work s . d_2 on that and so add sum_k s_k Q_k to the stiffness. Linear FFRF lacks it. What the frame's own rotation does to
the forces at joints is in the equations of motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from toolkit.scene.resolution import ResolvedScene
from toolkit.solvers.direct_solve import MANY
from toolkit.solvers.static.static_matrix import StaticArray, as_dense, scaled_by
from toolkit.system.flexible_bodies import design_point
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.known_chain import chain
from toolkit.validity.bodies.compressed.many_coordinates import Flexibility, largest_ratio


@dataclass(frozen=True, eq=False)
class Stiffening:
    """How the elements of one body stiffen it under their forces, and soften it; matrices in its elastic coordinates."""

    behind: Chain
    stiffness: np.ndarray  # (n_f, n_f)

    def matrix(self, elastic: np.ndarray) -> StaticArray:
        """G at elastic coordinates (n_f,), (n_f, n_f); sparse where there are many."""
        forms, stiffening = self.behind.forms, self.behind.stiffening
        forces = forms.forces(self.behind.displacements(elastic[None]))[0, :, : stiffening.shape[1]]
        return self._elastic(forms.assembled(np.einsum("ek,ekpq->epq", forces, stiffening)))

    def of_axial(self, axial: np.ndarray) -> StaticArray:
        """G of axial forces (n_e,) alone, (n_f, n_f)."""
        return self._elastic(self.behind.forms.assembled(axial[:, None, None] * self.behind.stiffening[:, 0]))

    def yielding(self, forces: np.ndarray) -> np.ndarray:
        """K^-1 f of forces (n_f,), the body alone in its frame."""
        found: np.ndarray = self._scale * self._flexible(self._scale * forces)
        return found

    def softening(self, elastic: np.ndarray) -> float:
        """The largest part of its elastic stiffness that the forces take from any motion of the body in its frame."""
        G = scaled_by(self.matrix(elastic), self._scale)
        found = None if isinstance(G, np.ndarray) else largest_ratio(-G, scipy.sparse.csr_array(self._scaled), self._flexible)
        if found is None:
            half = np.linalg.solve(self._root, -as_dense(G))
            found = float(np.linalg.eigvalsh(np.linalg.solve(self._root, half.T))[-1])
        return max(found, 0.0)

    def deflections(self, elastic: np.ndarray, motions: np.ndarray) -> np.ndarray:
        """K^-1 G of motions (n_f, k): what the forces at elastic coordinates (n_f,) would bend the body by, to first order."""
        G = scaled_by(self.matrix(elastic), self._scale)
        bent: np.ndarray = self._scale[:, None] * self._flexible(np.asarray(G @ (motions / self._scale[:, None])))
        return bent

    @cached_property
    def forces(self) -> np.ndarray:
        """Axial forces of the elements, (n_e, n_f), positive in tension."""
        return self.behind.axial_forces(self.behind.shapes.T).T

    @cached_property
    def compliances(self) -> np.ndarray:
        """int w'^2 dx of every element under unit forces on all motions, (n_e,): which elements compression makes soft."""
        scaled = self._scale[:, None] * self.behind.shapes.T
        dofs, forms = self.behind.forms.dofs, self.behind.stiffening[:, 0]
        yielding = self._flexible(scaled)
        of_elements = np.einsum("fep,feq->epq", scaled[:, dofs], yielding[:, dofs])
        found: np.ndarray = np.einsum("epq,epq->e", forms, of_elements)
        return found

    def _elastic(self, nodal: scipy.sparse.csc_array) -> StaticArray:
        shapes = self._shapes
        found: StaticArray = shapes.T @ nodal @ shapes
        return found

    @cached_property
    def _shapes(self) -> StaticArray:
        return scipy.sparse.csr_array(self.behind.shapes) if len(self.stiffness) >= MANY else self.behind.shapes

    @cached_property
    def _flexible(self) -> Flexibility:
        """The inverse of the scaled stiffness."""
        if len(self.stiffness) < MANY:
            return lambda forces: np.linalg.solve(self._scaled, forces)
        factors = scipy.sparse.linalg.splu(scipy.sparse.csc_array(self._scaled))
        return lambda forces: factors.solve(forces)

    @cached_property
    def _scale(self) -> np.ndarray:
        return 1 / np.sqrt(np.diag(self.stiffness))

    @cached_property
    def _root(self) -> np.ndarray:
        """L of the scaled stiffness L L^T."""
        found: np.ndarray = np.linalg.cholesky(self._scaled)
        return found

    @cached_property
    def _scaled(self) -> np.ndarray:
        return self._scale[:, None] * self.stiffness * self._scale


def stiffening(scene: ResolvedScene, body: str) -> Stiffening | None:
    """The geometric stiffness of a flexible body; None if its reduced model does not hold its finite elements."""
    behind, design = chain(scene, body), design_point(scene, body)
    if behind is not None and Stiffening not in design.kept:
        design.kept[Stiffening] = Stiffening(behind, np.real(design.value("stiffness")))
    found: Stiffening | None = design.kept.get(Stiffening)
    return found
