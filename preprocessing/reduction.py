"""Reference conditions and bases: what the elastic coordinates of the body mean.

A material point is u_P = S(x_P) Z [1; q_f] in the body frame, Z = [xi, Psi]: xi holds the nodal coordinates that reproduce
the undeformed shape, `S(x) xi = x`, Psi the displacements that belong to the elastic coordinates q_f.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Basis:
    """Z = [xi, Psi] with the words that the reduced-model file says about it."""

    z: np.ndarray  # (n, 1 + n_f)
    reference_condition: str
    description: str

    constant = True

    def rate(self, d_stiffness, d_mass, d_xi, d_rows):
        """[dxi, 0]."""
        return np.column_stack([d_xi, np.zeros_like(self.z[:, 1:])])


def undeformed(nodes: np.ndarray) -> np.ndarray:
    """xi (3 n_nodes,): node positions (n_nodes, 2) on the translations, and zero on the rotations, because the elements are straight."""
    return np.column_stack([nodes, np.zeros(len(nodes))]).ravel()


def tangent_frame(nodes: np.ndarray, node: int, name: str) -> Basis:
    """All nodal coordinates of nodes (n_nodes, 2) but the three of one, to which the frame is tied; nothing is reduced.

    The frame keeps the axes and the origin of the nodes' coordinates and moves with the clamped node as with a rigid wall.
    """
    n = 3 * len(nodes)
    free = np.delete(np.arange(n), np.arange(3) + 3 * (node % len(nodes)))
    psi = np.eye(n)[:, free]
    return Basis(
        np.column_stack([undeformed(nodes), psi]),
        f"tangent frame: the nodal coordinates of {name} are clamped in the frame of the undeformed shape",
        "frozen: identity on the free coordinates",
    )


@dataclass(frozen=True)
class BasisChoice:
    """Which basis."""

    kind: str = "full"


def choose_basis(choice, mass, stiffness, nodes, clamped_node, clamp, interface_rows):
    """The basis that was chosen."""
    return tangent_frame(nodes, clamped_node, clamp)
