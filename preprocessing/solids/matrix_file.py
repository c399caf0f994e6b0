"""Finished matrices and coordinates of nodes from files of other programs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from scipy import io, sparse

from toolkit.errors import InputError, without_content

MATRIX_MARKET = b"%%MatrixMarket"
FAILURES = (OSError, ValueError, KeyError, IndexError, TypeError, AttributeError, EOFError, BadZipFile)
"""What readers raise on files that are not what their names say."""
ASYMMETRIC = 1e-9
"""Largest relative difference of entries that should be equal; programs write 6 to 16 digits."""


def read_square(path: Path, n: int, dimension: int = 2) -> Any:
    """A symmetric matrix (n, n), sparse: Matrix Market, Abaqus' text, or SciPy's .npz.

    Raises
    ------
    InputError
        The file cannot be read, has another size, is not symmetric, or holds numbers that are not finite.
    """
    matrix = read_matrix(path, n, dimension)
    if matrix.shape != (n, n):
        raise InputError(
            f"the matrix {str(path)!r} has shape {matrix.shape}; its nodes have {n} coordinates. Give both of one model."
        )
    difference = abs(matrix - matrix.T).max()
    if not difference <= ASYMMETRIC * abs(matrix).max():
        raise InputError(
            f"the matrix {str(path)!r} is not symmetric (by {difference:g}). If it holds one triangle only, say so in its first line "
            "(%%MatrixMarket matrix coordinate real symmetric)."
        )
    return ((matrix + matrix.T) / 2).tocsr()


def read_matrix(path: Path, n: int, dimension: int = 2) -> Any:
    """A sparse matrix of n columns, the coordinates of nodes in space of a dimension; raises as `read_square`."""
    with _reading(path, "a matrix in Matrix Market, Abaqus' or SciPy's .npz format"):
        if path.suffix == ".npz":
            found = sparse.csr_array(sparse.load_npz(path))
        elif _starts_with(path, MATRIX_MARKET):
            found = sparse.csr_array(io.mmread(path))
        else:
            found = _abaqus(path, n, dimension)
    if found.shape[1] != n or found.dtype.kind not in "iuf" or not np.all(np.isfinite(found.data)):
        raise InputError(
            f"the matrix {str(path)!r} of shape {found.shape} needs {n} columns of finite real numbers. Export it again."
        )
    return found.astype(float)


def read_nodes(path: Path) -> np.ndarray:
    """Coordinates of nodes (n_nodes, 2) or (n_nodes, 3).

    Raises
    ------
    InputError
        The file cannot be read, or does not hold two or three finite numbers for each node.
    """
    nodes = read_array(path, "the coordinates of nodes, x, y or x, y, z on every line")
    if nodes.ndim != 2 or nodes.shape[1] not in (2, 3) or not len(nodes):
        raise InputError(f"{str(path)!r} has shape {nodes.shape}; give finite numbers x and y, or x, y and z, for each node.")
    return nodes


def read_array(path: Path, what: str) -> np.ndarray:
    """An array of finite numbers (n, k) from .npy, .npz or, with commas, as text.

    Raises
    ------
    InputError
        The file cannot be read as `what` it should hold, or holds other things than finite numbers.
    """
    with _reading(path, what):
        if path.suffix in (".npy", ".npz"):
            loaded = np.load(path, allow_pickle=False)
            found = np.asarray(loaded if path.suffix == ".npy" else loaded[loaded.files[0]])
        else:
            found = np.loadtxt(path, delimiter=",", ndmin=2)
    if found.dtype.kind not in "iuf" or not np.all(np.isfinite(found)):
        raise InputError(f"{str(path)!r} holds other things than finite real numbers. Give {what}.")
    return found.astype(float)


def _abaqus(path: Path, n: int, d: int) -> Any:
    """Lines `node, direction, node, direction, value`, of one triangle or of both."""
    rows = np.loadtxt(path, delimiter=",", ndmin=2, comments="*")
    if rows.shape[1] != 5 or np.any(rows[:, :4] < 1) or np.any(rows[:, [1, 3]] > d) or np.any(rows[:, [0, 2]] > n // d):
        raise ValueError(f"lines of Abaqus are node, direction 1 to {d}, node, direction, value, with nodes from 1 to {n // d}")
    where = d * (rows[:, [0, 2]].astype(int) - 1) + rows[:, [1, 3]].astype(int) - 1
    found = sparse.coo_array((rows[:, 4], where.T), shape=(n, n)).tocsr()
    below, above = sparse.tril(found, -1), sparse.triu(found, 1)
    return found + found.T - sparse.diags_array(found.diagonal()) if not below.nnz or not above.nnz else found


def _starts_with(path: Path, start: bytes) -> bool:
    with path.open("rb") as file:
        return file.read(len(start)) == start


@contextmanager
def _reading(path: Path, what: str) -> Iterator[None]:
    """Failures of readers as errors of the input."""
    if not path.is_file():
        raise InputError(f"there is no file {str(path)!r}. Mend the path; it is relative to the TOML file.")
    try:
        yield
    except FAILURES as error:
        raise InputError(f"{str(path)!r} cannot be read as {what} ({without_content(str(error))}). Export it again.") from error
