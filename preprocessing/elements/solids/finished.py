"""Whether finished matrices of another program are those of a free body of displacement-based elements."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from preprocessing.mesh.solid_mesh import SolidMesh, rigid_motions, translations
from toolkit.foundation.errors import InputError

UNEQUAL = 1e-9
"""Largest difference, relative to the largest entry, of parts of a mass matrix that should be equal or zero."""
RESISTED = 1e-6
"""Largest force against a rigid motion, relative to those of a motion of the same size of single nodes."""


def refuse_swapped(mesh: SolidMesh, mass: Any, stiffness: Any) -> None:
    """Refuse swapped matrices: a mass matrix without inertia of translations, while the stiffness matrix resists them.

    Raises
    ------
    InputError
        They are swapped.
    """
    motion = translations(*mesh.nodes.shape)
    resisted = [np.abs(matrix @ motion).max() > RESISTED * (abs(matrix) @ np.abs(motion)).max() for matrix in (mass, stiffness)]
    if resisted == [False, True]:
        raise InputError(
            "a motion of the whole body meets no mass, but stiffness: the two files are swapped. Give the mass matrix as mass, and the "
            "stiffness matrix as stiffness."
        )


def scalar_mass(mass: Any, d: int) -> Any:
    """Mass matrix (n_nodes, n_nodes) of one of d components, which is the same for all.

    Raises
    ------
    InputError
        It is not: the elements are none of displacements alone.
    """
    first, limit, axes = mass[0::d, 0::d], UNEQUAL * abs(mass).max(), range(d)
    coupled = max(abs(mass[a::d, b::d]).max() for a in axes for b in axes if a != b)
    if coupled > limit or max(abs(mass[a::d, a::d] - first).max() for a in axes) > limit:
        what = " and ".join(("x", "y") if d == 2 else ("x, y", "z"))
        raise InputError(
            f"the mass matrix treats {what} differently or couples them, as displacement-based solids do not. Export it in the order "
            f"{what} of node 0, {what} of node 1, ..., without rotations, and all of it."
        )
    return first


def without_constant(scalar: Any, constant: Mapping[tuple[int, int], Any], mesh: SolidMesh) -> Any:
    """A scalar mass matrix without concentrated masses M_ab of nodes, which it holds as the exported model does.

    Raises
    ------
    InputError
        There is not more mass than these at a node.
    """
    at_nodes = slice(0, mesh.n, mesh.dimension)
    left = (scalar - constant[0, 0][at_nodes, at_nodes]).tocsr()
    if np.any(left.diagonal() <= 0):
        raise InputError(
            "the mass matrix does not hold the concentrated masses of the mesh file: at a node it has less than these. Export mass and "
            "mesh from one model, or leave the masses out: leave_out in [mesh]."
        )
    return left


def refuse_supports(mesh: SolidMesh, stiffness: Any) -> None:
    """Refuse a stiffness matrix that resists rigid motions.

    Raises
    ------
    InputError
        It names the motion.
    """
    centred = rigid_motions(mesh.nodes - mesh.nodes.mean(axis=0))
    names = ("x", "y", "rotation") if mesh.dimension == 2 else ("x", "y", "z", "rotation about x", "about y", "about z")
    for axis, motion in zip(names, centred.T, strict=True):
        force, own = np.abs(stiffness @ motion).max(), (abs(stiffness) @ np.abs(motion)).max()
        if force > RESISTED * own:
            raise InputError(
                f"the stiffness matrix resists a rigid motion ({axis}) by {force / own:.0e} of the forces of its elements. Export it "
                "without supports, with nodes in the same order, and with all displacements of every node."
            )
