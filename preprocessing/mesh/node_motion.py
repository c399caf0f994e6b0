"""The motion of a mesh's nodes by a shape variable, read from a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from preprocessing.mesh.matrix_file import read_array
from preprocessing.mesh.solid_mesh import SolidMesh
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import LARGEST


def read_motion(path: Path, mesh: SolidMesh, scale: float) -> np.ndarray:
    """Displacement of the nodes per unit of the variable, (n_nodes, 3), in the coordinates of the mesh times its scale.

    Raises
    ------
    InputError
        The file cannot be read, has not one row of three finite numbers for every node of the mesh file, or moves none of them.
    """
    field = read_array(path, "the displacements of nodes, x, y, z on every line")
    if field.shape != (mesh.n_file, 3):
        raise InputError(
            f"{str(path)!r} has shape {field.shape}; the mesh file has {mesh.n_file} nodes. Give a displacement x, y, z of each of them."
        )
    if np.abs(field).max() > LARGEST:
        raise InputError(f"{str(path)!r} holds displacements beyond {LARGEST:g}. Fix their unit.")
    field = scale * (field if mesh.in_file is None else field[mesh.in_file])
    if not np.any(field):
        raise InputError(f"{str(path)!r} moves no node of the elements. Give displacements that are not all zero.")
    return field
