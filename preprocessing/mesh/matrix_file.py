"""Finished matrices and coordinates of nodes from files of other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from preprocessing.foreign_files.apart import read_apart
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import LARGEST

ASYMMETRIC = 1e-9
"""Largest relative difference of entries that should be equal; programs write 6 to 16 digits."""
EXTREME = 1e60
"""No entry of a matrix is larger in any unit system, and the largest is not smaller than its inverse: products still are numbers."""
AGAIN = "Export it again."


def read_square(path: Path, n: int, dimension: int = 2) -> Any:
    """A symmetric matrix (n, n), sparse: Matrix Market, Abaqus' text, or SciPy's .npz.

    Raises
    ------
    InputError
        The file cannot be read, has another size, is not symmetric, holds no entry but zeros, or numbers that are not finite.
    """
    matrix = read_matrix(path, n, dimension)
    if matrix.shape != (n, n):
        raise InputError(
            f"the matrix {str(path)!r} has shape {matrix.shape}; its nodes have {n} coordinates. Give both of one model."
        )
    largest = abs(matrix).max() if matrix.nnz else 0.0
    if not largest >= 1 / EXTREME:
        raise InputError(f"the matrix {str(path)!r} holds no entry larger than {largest:g}. {AGAIN}")
    difference = abs(matrix - matrix.T).max()
    if not difference <= ASYMMETRIC * largest:
        raise InputError(
            f"the matrix {str(path)!r} is not symmetric (by {difference:g}). If it holds one triangle only, say so in its first line "
            "(%%MatrixMarket matrix coordinate real symmetric)."
        )
    return ((matrix + matrix.T) / 2).tocsr()


def read_matrix(path: Path, n: int, dimension: int = 2) -> Any:
    """A sparse matrix of n columns, the coordinates of nodes in space of a dimension; raises as `read_square`."""
    how = "as a matrix in Matrix Market, Abaqus' or SciPy's .npz format"
    found = read_apart("matrix", path, how, AGAIN, str(n), str(dimension))
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
    if len(value) and float(np.abs(value.astype(float)).max()) > EXTREME:
        raise InputError(f"the matrix {str(path)!r} has entries beyond {EXTREME:g}. Fix their unit.")
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
    if found.dtype.kind not in "iuf" or not np.all(np.isfinite(found)):
        raise InputError(f"{str(path)!r} holds other things than finite real numbers. Give {what}.")
    return found.astype(float)
