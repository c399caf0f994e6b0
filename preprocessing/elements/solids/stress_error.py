"""How far the stress of a mesh is from the truth, estimated by the stress recovered from it (Zienkiewicz and Zhu).

In the energy norm, with the compliance C of the material,

    error^2 = int (sigma* - sigma) . C (sigma* - sigma) dV / int (sigma . C sigma + (sigma* - sigma) . C (sigma* - sigma)) dV

which is zero for an exact stress and tends to the error relative to the true stress as elements become smaller. Where the true stress
has no bound, at sharp inner corners and at the rims of what is held rigidly, it falls slowly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from preprocessing.elements.solids.elements import ElementBlock, points_of
from preprocessing.elements.solids.recovered_stress import recovered, sample_points

REST = 1e-10
"""Energy of a load case, in parts of the largest energy per square of displacement, below which it is a rigid motion."""


@dataclass(frozen=True, eq=False)
class Elastic:
    """Elements of a body, and Lame's constants in any unit."""

    blocks: Sequence[ElementBlock]
    nodes: np.ndarray  # (n_nodes, d)
    lame: tuple[float, float]
    across: float = 0.0  # stress across the plane in parts of the sum of both in it: Poisson's ratio in plane strain

    def stress(self, block: ElementBlock, functions: Any, moved: np.ndarray) -> np.ndarray:
        """Stress at [e, point, a, b, k] from displacements (n_e, n_local, d, k) of some elements."""
        gradients = np.stack([each[0].grad for each in functions.basis], axis=-1)  # [a, e, point, p]
        slope = np.einsum("aeqp,epck->eqcak", gradients, moved, optimize=True)
        strain, first, shear = (slope + slope.swapaxes(2, 3)) / 2, *self.lame
        return first * np.einsum("eqaak->eqk", strain)[:, :, None, None] * np.eye(len(gradients))[..., None] + 2 * shear * strain

    def energy(self, stress: np.ndarray) -> np.ndarray:
        """Product sigma . C sigma at [e, point, k] of stresses at [e, point, a, b, k]."""
        first, shear = self.lame
        mean = np.einsum("eqaak->eqk", stress)
        return ((stress**2).sum(axis=(2, 3)) - first / (2 * shear + stress.shape[2] * first) * mean**2) / (2 * shear)


@dataclass(frozen=True, eq=False)
class StressErrors:
    """Estimated stress errors of k load cases."""

    relative: np.ndarray  # (k,) nan of one that is a rigid motion
    place: np.ndarray  # (k, d) centre of the element with the largest part of it


def stress_errors(body: Elastic, displacements: np.ndarray) -> StressErrors:
    """Estimated stress errors of displacements (n, k)."""
    k, d = displacements.shape[1], body.nodes.shape[1]
    moved = displacements.reshape(-1, d, k)
    samples = []
    for block in body.blocks:
        functions = block.functions_at(sample_points(block))
        found = body.stress(block, functions, moved[block.connectivity])
        samples.append(found.reshape(*found.shape[:2], -1))
    smooth = recovered(body.blocks, body.nodes, samples)
    energy, error, largest, place = np.zeros(k), np.zeros(k), np.full(k, -1.0), np.zeros((k, d))
    for block in body.blocks:
        for elements, functions in block.functions_in_parts():
            raw = body.stress(block, functions, moved[block.connectivity[elements]])
            off = smooth.at(block, elements, functions, points_of(block.kind)[0]).reshape(raw.shape) - raw
            energy += np.einsum("eqk,eq->k", body.energy(raw), functions.dx)
            each = np.einsum("eqk,eq->ek", body.energy(off), functions.dx)
            error += each.sum(axis=0)
            worst = each.argmax(axis=0)
            centre = body.nodes[block.connectivity[elements[worst]]].mean(axis=1)
            place[each.max(axis=0) > largest] = centre[each.max(axis=0) > largest]
            largest = np.maximum(largest, each.max(axis=0))
    stiff = energy / np.maximum((displacements**2).mean(axis=0), np.finfo(float).tiny)
    relative = np.sqrt(error / np.maximum(energy + error, np.finfo(float).tiny))
    return StressErrors(np.where(stiff > REST * stiff.max(initial=0.0), relative, np.nan), place)
