"""Finished matrices and coordinates of nodes from files of other programs."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import numpy as np
from scipy import sparse

from preprocessing.foreign_files.apart import read_apart
from preprocessing.foreign_files.contents import MatrixEntries
from preprocessing.mesh.solid_mesh import SolidMesh
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import LARGEST

ASYMMETRY_TOLERANCE = 1e-9
"""Largest relative difference of entries that should be equal; programs write 6 to 16 digits."""
LARGEST_ENTRY = 1e60
"""No entry of a matrix is larger in any unit system, and the largest is not smaller than its inverse: products still are numbers."""
AGAIN = "Export it again."


def square_of(
    path: Path, n_nodes: int, dimension: int, labels: np.ndarray | None = None, degrees: Path | None = None
) -> tuple[sparse.csr_array, str]:
    """Symmetric matrix of all displacements of nodes, and remarks on how it was read, if any.

    Parameters
    ----------
    labels : number of every node in the file of the mesh, or None
    degrees : the .dof file of CalculiX, if the matrix has one

    Raises
    ------
    InputError
        The file cannot be read, has another size, names other nodes, is not symmetric, holds no entry but zeros, or numbers that are not
        finite.
    """
    n = dimension * n_nodes
    found = _read(path, n, dimension, degrees)
    remark = ""
    if "labels" in found:
        found, remark = _in_order_of_mesh(path, found, labels, n_nodes, dimension)
    matrix = _checked(path, found, n)
    if matrix.shape != (n, n):
        raise InputError(
            f"the matrix {str(path)!r} has shape {matrix.shape}; its nodes have {n} coordinates. Give both of one model."
        )
    largest = abs(matrix).max() if matrix.nnz else 0.0
    if not largest >= 1 / LARGEST_ENTRY:
        raise InputError(f"the matrix {str(path)!r} holds no entry larger than {largest:g}. {AGAIN}")
    difference = abs(matrix - matrix.T).max()
    if not difference <= ASYMMETRY_TOLERANCE * largest:
        raise InputError(
            f"the matrix {str(path)!r} is not symmetric (by {difference:g}). If it holds one triangle only, say so in its first line "
            "(%%MatrixMarket matrix coordinate real symmetric)."
        )
    return ((matrix + matrix.T) / 2).tocsr(), remark


def read_matrix(path: Path, n: int, dimension: int = 2) -> sparse.csr_array:
    """A matrix of n columns, the coordinates of nodes in space of a dimension, and of any rows; raises as `square_of`."""
    found = _read(path, n, dimension)
    if "labels" in found:
        raise InputError(
            f"{str(path)!r} is one of Abaqus or CalculiX, whose rows are those of nodes. Give a matrix with other rows as Matrix Market or "
            "SciPy's .npz."
        )
    return _checked(path, found, n)


def _read(path: Path, n: int, dimension: int, degrees: Path | None = None) -> MatrixEntries:
    """Entries that the reader of matrices finds, not checked yet; raises InputError if it refuses the file."""
    how = "as a matrix in Matrix Market, in Abaqus' or CalculiX's text or in SciPy's .npz format"
    beside = [degrees] if degrees is not None else []
    found = read_apart("matrix", path, how, AGAIN, str(n), str(dimension), *map(str, beside), drawn=beside)
    return cast("MatrixEntries", found)


def _in_order_of_mesh(
    path: Path, found: MatrixEntries, labels: np.ndarray | None, n_nodes: int, d: int
) -> tuple[MatrixEntries, str]:
    """Matrix entries with rows and columns in the order of the mesh's nodes, and remarks on it."""
    named, remark = found["labels"], ""
    if named is None:  # rows in the order of the nodes' numbers
        node = np.arange(n_nodes) if labels is None else np.argsort(labels, kind="stable")
    elif labels is not None:
        node = _nodes_of(path, named, labels)
    else:
        _refuse_number(path, named, n_nodes)
        node = np.arange(n_nodes)
        if not np.array_equal(named, node + 1):
            remark = (
                f"the matrices number their nodes from {named[0]} to {named[-1]}, and those of the body have no numbers: the first node of "
                "the body is taken for the lowest number, the second for the next, and so on"
            )
    row, column = (d * node[place // d] + place % d for place in (found["row"], found["column"]))
    return {**found, "row": row, "column": column, "shape": [d * n_nodes] * 2}, remark


def _refuse_number(path: Path, named: np.ndarray, n_nodes: int) -> None:
    if len(named) != n_nodes:
        raise InputError(
            f"the matrix {str(path)!r} names {len(named)} nodes, and the body has {n_nodes}. Give both of one model."
        )


def _nodes_of(path: Path, named: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """Node of the mesh of each of the rising numbers in a matrix, which are those of all nodes of the mesh.

    Raises
    ------
    InputError
        It names a number that only one of the two has.
    """
    for one, other, what in (
        (named, labels, "names node {}, which no element of the mesh has"),
        (labels, named, "lacks node {} of the mesh"),
    ):
        alone = np.setdiff1d(one, other)
        if len(alone):
            more = f" ({len(alone)} such nodes)" if len(alone) > 1 else ""
            raise InputError(
                f"the matrix {str(path)!r} {what.format(alone[0])}{more}. Give matrices and mesh of one model, free of supports."
            )
    if len(np.unique(labels)) < len(labels):
        raise InputError(
            "the mesh gives two nodes the same number, so that the matrices do not tell which they mean. Number its nodes anew."
        )
    order: np.ndarray = np.argsort(labels, kind="stable")
    return order


def _checked(path: Path, found: MatrixEntries, n: int) -> sparse.csr_array:
    """Sparse matrix of the entries that were found; raises InputError if its parts do not fit together."""
    (rows, columns), row, column, value = found["shape"], found["row"], found["column"], found["value"]
    numbers = value.dtype.kind in "iuf" and bool(np.all(np.isfinite(value)))
    if columns != n or not numbers:
        raise InputError(
            f"the matrix {str(path)!r} of shape {(rows, columns)} needs {n} columns of finite real numbers. Export it again."
        )
    if not np.ndim(row) == np.ndim(column) == np.ndim(value) == 1 or not len(row) == len(column) == len(value):
        raise InputError(f"the matrix {str(path)!r} has rows, columns and values that are no lines of one length. {AGAIN}")
    if rows > n + len(value):
        raise InputError(f"the matrix {str(path)!r} claims {rows} rows for {len(value)} entries. {AGAIN}")
    if len(row) and (row.min() < 0 or row.max() >= rows or column.min() < 0 or column.max() >= n):
        raise InputError(f"the matrix {str(path)!r} has entries outside of its shape {(rows, columns)}. {AGAIN}")
    if len(value) and float(np.abs(value.astype(float)).max()) > LARGEST_ENTRY:
        raise InputError(f"the matrix {str(path)!r} has entries beyond {LARGEST_ENTRY:g}. Fix their unit.")
    return sparse.csr_array(sparse.coo_array((value.astype(float), (row, column)), shape=(rows, n)))


def read_nodes(path: Path) -> np.ndarray:
    """Coordinates of nodes (n_nodes, 2) or (n_nodes, 3).

    Raises
    ------
    InputError
        The file cannot be read, does not hold two or three finite numbers for each node, or has all nodes at one place.
    """
    nodes = read_array(path, "the coordinates of nodes, x, y or x, y, z on every line")
    if nodes.ndim != 2 or nodes.shape[1] not in (2, 3) or not len(nodes):
        raise InputError(f"{str(path)!r} has shape {nodes.shape}; give finite numbers x and y, or x, y and z, for each node.")
    if float(np.abs(nodes).max()) > LARGEST or not np.ptp(nodes, axis=0).max() > 1 / LARGEST:
        raise InputError(f"the nodes of {str(path)!r} are all at one place, or beyond {LARGEST:g}. Fix their coordinates.")
    return nodes


def read_array(path: Path, what: str) -> np.ndarray:
    """An array of finite numbers (n, k) from .npy, .npz or, with commas, as text.

    Raises
    ------
    InputError
        The file cannot be read as `what` it should hold, or holds other things than finite numbers.
    """
    found = read_apart("table", path, f"as {what}", AGAIN)
    if not isinstance(found, np.ndarray) or found.dtype.kind not in "iuf" or not np.all(np.isfinite(found)):
        raise InputError(f"{str(path)!r} holds other things than finite real numbers. Give {what}.")
    return found.astype(float)


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
