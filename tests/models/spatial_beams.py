"""Spatial beams for tests: one section along any polygon, all invariants of any Z, and the velocity field that they stand for."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from preprocessing.elements.beams import BeamPatch, SpatialBeam
from preprocessing.elements.section import Patch, SectionShape, rectangle
from preprocessing.reduction.chosen_basis import spatial_motions, undeformed
from preprocessing.reduction.discretisation import Discretisation
from preprocessing.reduction.invariants import contract_at
from toolkit.reduced_model.parts import SpatialInvariants, all_second_moments

VALUES = {
    "youngs_modulus": 70.0, "density": 2.7, "thickness": 0.3, "width": 0.5, "damping_mass": 0.2, "damping_stiffness": 0.01,
}  # fmt: skip
NU = 0.3


@dataclass(frozen=True, eq=False)
class Beams:
    """Elements of one section; complex where anything is."""

    nodes: np.ndarray  # (n_nodes, 3)
    connectivity: np.ndarray
    orientation: np.ndarray  # (n_elements, 3)
    shape: SectionShape = field(default_factory=rectangle)
    values: dict[str, Any] = field(default_factory=lambda: dict(VALUES))

    @property
    def discrete(self) -> Discretisation:
        patch = Patch(np.arange(len(self.connectivity)), {name: name for name in self.values})
        patches = [BeamPatch(patch, self.shape, 1 / (2 * (1 + NU)))]
        beams = SpatialBeam(self.nodes, self.connectivity, self.orientation, patches)
        return Discretisation(beams, {})

    @property
    def matrices(self) -> Any:
        return self.discrete.parts.at(self.values)

    def dense(self, name: str) -> np.ndarray:
        """Stiffness or mass without the offset."""
        return self.matrices.coordinates.of_nodes(getattr(self.matrices, name)).toarray()

    @property
    def complete(self) -> np.ndarray:
        """Z with every nodal coordinate, clamped or not."""
        return np.column_stack([undeformed(self.nodes), np.eye(6 * len(self.nodes))])

    @property
    def invariants(self) -> SpatialInvariants:
        return contract_at(self.discrete.parts, self.values, self.complete)

    @property
    def rigid(self) -> np.ndarray:
        return spatial_motions(self.nodes)


def crooked(rng: np.random.Generator) -> Beams:
    """Three random elements in space, two of them from one node."""
    return Beams(rng.normal(size=(4, 3)), np.array([[0, 1], [1, 2], [1, 3]]), rng.normal(size=(3, 3)))


def straight(n: int, direction: np.ndarray, orientation: np.ndarray, length: float = 10.0, **keys: Any) -> Beams:
    along = np.asarray(direction) / np.linalg.norm(direction)
    first = np.arange(n)
    return Beams(
        np.linspace(0, length, n + 1)[:, None] * along,
        np.column_stack([first, first + 1]),
        np.tile(np.asarray(orientation, float), (n, 1)),
        **keys,
    )


def kinetic_energy(beams: Beams, points: list[tuple[float, float]], q, v, translation, omega) -> float:
    """1/2 int rho |velocity|^2 dV of a body in motion, its section as equal masses at points (y_2, y_3); axes at rest at this moment.

        place = x + u(q) + (e + th(q) x e),   velocity = r' + omega x place + u(v) + th(v) x e,   e = y_2 e_2 + y_3 e_3

    Eight Gauss points along each element, exact for products of cubics.
    """
    ratios, weights = np.polynomial.legendre.leggauss(8)
    mesh, energy = beams.discrete.element, 0.0
    beams_of_mesh = mesh.elements(np.arange(len(mesh.connectivity)))
    shape, turn = beams_of_mesh.shape, beams_of_mesh.rotation
    area = beams.shape.values(beams.values)["area"]
    for k, (one, two) in enumerate(mesh.connectivity):
        dofs, along = mesh.dofs[k, :12], mesh.nodes[two] - mesh.nodes[one]
        for ratio, weight in zip((ratios + 1) / 2, weights / 2, strict=True):
            at = ratio ** np.arange(4)
            moved, turned = np.tensordot(at, shape[k], 1), np.tensordot(at, turn[k], 1)
            for y_2, y_3 in points:
                e = y_2 * mesh.axes[k, 1] + y_3 * mesh.axes[k, 2]
                place = mesh.nodes[one] + ratio * along + e + moved @ q[dofs] + np.cross(turned @ q[dofs], e)
                velocity = translation + np.cross(omega, place) + moved @ v[dofs] + np.cross(turned @ v[dofs], e)
                mass = beams.values["density"] * area * np.linalg.norm(along) * weight / len(points)
                energy += 0.5 * mass * velocity @ velocity
    return energy


def energy_of_invariants(inv: SpatialInvariants, q, v, translation, omega) -> float:
    """The same from the invariants: theory section 1, with the frame's axes along those of space."""
    Q, z, dz = all_second_moments(inv.second_moment), np.append(1.0, q), np.append(0.0, v)
    spin = np.array([[0, -omega[2], omega[1]], [omega[2], 0, -omega[0]], [-omega[1], omega[0], 0]])
    S, C = np.einsum("abij,i,j->ab", Q, z, z), np.einsum("abij,i,j->ab", Q, z, dz)
    elastic = sum(dz @ Q[a, a] @ dz for a in range(3))
    linear = spin @ inv.first_moment @ z + inv.first_moment @ dz
    whole = inv.mass * translation @ translation + 2 * translation @ linear + np.trace(spin @ S @ spin.T) + elastic
    return 0.5 * float(whole + 2 * np.sum(spin * C.T))
