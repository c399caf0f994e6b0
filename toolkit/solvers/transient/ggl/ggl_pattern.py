"""Places of the numbers of a stabilised index-2 step: the sparsity pattern of its matrix, made once per run.

Unknowns are [a; lam; eta], rows those of coordinates, velocity constraints and position constraints (see `ggl_step`):

            a          lam        eta
    [ base matrix of [a; lam]    c_q B S     ]        B = I_q + A_q, all n rows
    [ phi_q            0         phi_q S     ]        S has the pattern of phi_q^T
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Products(NamedTuple):
    """A sparse product in triples: value[place] += left value * right value."""

    place: np.ndarray
    left: np.ndarray
    right: np.ndarray


class GglPattern(NamedTuple):
    """Pattern in compressed rows, symmetric and with a full diagonal, and where parts are found and put.

    The entries of phi_q are counted k = 0 ... n_phi - 1; S keeps its values in the same order.
    """

    indptr: np.ndarray
    indices: np.ndarray
    base: np.ndarray  # (n_entries,) place of the entries of the base pattern
    row: np.ndarray  # (n_phi,) number of its constraint
    coordinate: np.ndarray  # (n_phi,)
    lower: np.ndarray  # (n_phi,) the entry of the base pattern that holds it
    upper: np.ndarray  # (n_phi,) and its transpose
    position: np.ndarray  # (n_phi,) place in the rows of position constraints
    bent: Products  # B S: base entries, entries of S
    closing: Products  # phi_q S: entries of phi_q, entries of S


def ggl_pattern(indptr: np.ndarray, indices: np.ndarray, n_q: int) -> GglPattern:
    """Pattern of n_q coordinates and their multipliers, (n + 1,) and (n_entries,), extended by the multipliers eta."""
    n = len(indptr) - 1
    rows, columns = np.repeat(np.arange(n), np.diff(indptr)), np.asarray(indices, np.int64)
    lower = np.flatnonzero((rows >= n_q) & (columns < n_q))
    upper = np.searchsorted(rows * n + columns, columns[lower] * n + rows[lower])
    row, coordinate = rows[lower] - n_q, columns[lower]
    bent_left, bent_right = _pairs(columns, coordinate, n)
    closing_left, closing_right = _pairs(coordinate, coordinate, n)
    total = 2 * n - n_q
    keys = {
        "base": rows * total + columns,
        "position": (n + row) * total + coordinate,
        "bent": rows[bent_left] * total + n + row[bent_right],
        "closing": (n + row[closing_left]) * total + n + row[closing_right],
    }
    found = np.concatenate([*keys.values(), np.arange(total) * (total + 1)])
    pattern = np.unique(np.concatenate([found, found % total * total + found // total]))
    place = {name: np.searchsorted(pattern, key) for name, key in keys.items()}
    return GglPattern(
        np.searchsorted(pattern, np.arange(total + 1) * total),
        pattern % total,
        place["base"],
        row,
        coordinate,
        lower,
        upper,
        place["position"],
        Products(place["bent"], bent_left, bent_right),
        Products(place["closing"], closing_left, closing_right),
    )


def _pairs(columns: np.ndarray, coordinates: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """All pairs of a left entry in some column and a right entry at the coordinate of the same number."""
    by_column = np.argsort(columns, kind="stable")
    start = np.searchsorted(columns[by_column], np.arange(n + 1))
    counts = start[coordinates + 1] - start[coordinates]
    right = np.repeat(np.arange(len(coordinates)), counts)
    within = np.arange(len(right)) - np.repeat(np.cumsum(counts) - counts, counts)
    return by_column[start[coordinates[right]] + within], right
