"""The stiffness of a chain of straight beams in its factors, read off its blocks.

An element between two nodes stores energy in its stretch e . (u_2 - u_1), in the difference of the rotations at its ends, and in the sum of
what they differ from the turn of its axis,

    EA/l,  s_1 = e . (u_2 - u_1);    EI/l,  s_2 = r_2 - r_1;    3 EI/l,  s_3 = r_1 + r_2 + g . (u_2 - u_1),   g = -2 n / l

No other element has a share in the block between both nodes, which therefore tells e, g, EA/l and EI/l; an element whose other node is
held is what all others leave of the block of a node. With these factors rigid motions have no energy, whatever is rounded.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

PER_NODE = 3
FACTOR_ROUND_OFF = 2e-14
"""Largest difference between an entry of a stiffness and what its factors make of it, in parts of the root of the product of both diagonal
entries: some roundings, 2e-15 in skins of 600 elements. Whatever else stiffens a body, a soft spring too, is no part of its factors. Of
an imaginary step, in parts of the largest entry of that, and for every node: derivatives by the shape are differences of neighbours."""


class Strains(NamedTuple):
    """Rows of B, all with as many entries, and the diagonal of D, in K = B^T D B."""

    column: np.ndarray  # (n_rows, 2 PER_NODE) ints; entries of a node that is held are 0
    value: np.ndarray
    weight: np.ndarray  # (n_rows,)


def no_strains() -> Strains:
    """Strains without rows, for a body whose stiffness is not factored."""
    return Strains(np.zeros((0, 2 * PER_NODE), np.int64), np.zeros((0, 2 * PER_NODE)), np.zeros(0))


def chain_strains(row: np.ndarray, column: np.ndarray, stiffness: np.ndarray, n_f: int) -> Strains:
    """Strains of a chain of beams that is held at one end, from the entries of its symmetric stiffness (n_f, n_f).

    The entries are real or complex. Other bodies have no strains.
    """
    count, rest = divmod(n_f, PER_NODE)
    first, second = row // PER_NODE, column // PER_NODE
    if rest or count < 2 or np.any(stiffness[np.abs(first - second) > 1] != 0):
        return no_strains()
    own, between = np.zeros((2, count, PER_NODE, PER_NODE), stiffness.dtype)
    for blocks, on in ((own, first == second), (between, first + 1 == second)):
        blocks[first[on], row[on] % PER_NODE, column[on] % PER_NODE] = stiffness[on]
    between = between[:-1]
    node = PER_NODE * np.arange(count)[:, None] + np.arange(PER_NODE)
    bend = between[:, 2, 2] / 2
    if not _bends(bend, between):
        return no_strains()
    free = _factors(np.column_stack([node[:-1], node[1:]]), bend, -between)
    left = own - _on_nodes(free, count)
    end = 0 if np.abs(left[0]).max() > np.abs(left[-1]).max() else count - 1
    bend = left[[end], 2, 2] / 4
    if not _bends(bend, left[[end]]):
        return no_strains()
    held = _factors(np.column_stack([np.zeros_like(node[:1]), node[[end]]]), bend, left[[end]])
    held.value[:, :PER_NODE] = 0
    found = Strains(*(np.concatenate(pair) for pair in zip(free, held, strict=True)))
    same = _same(own, _on_nodes(found, count), own, own) and _same(between, _between(free), own[:-1], own[1:])
    return found if same else no_strains()


def _bends(bend: np.ndarray, block: np.ndarray) -> bool:
    """Whether every element can be a beam: rotations have a stiffness, and displacements a share in it."""
    return bool(np.all(np.real(bend) > 0) and np.all(np.any(np.real(block[:, :2, 2]) != 0, axis=1)))


def _factors(column: np.ndarray, bend: np.ndarray, block: np.ndarray) -> Strains:
    """Three strains of every element on its columns (n, 6), from EI/l and the block of what pulls its second node to the first.

    The blocks are (n, 3, 3).
    """
    g = block[:, :2, 2] / (3 * bend)[:, None]
    e = np.column_stack([g[:, 1], -g[:, 0]]) / np.sqrt((g * g).sum(axis=1))[:, None]
    value = np.zeros((len(bend), 3, 2 * PER_NODE), block.dtype)
    value[:, 0, 0:2], value[:, 0, 3:5] = -e, e
    value[:, 1, 2], value[:, 1, 5] = -1, 1
    value[:, 2, 0:2], value[:, 2, 3:5], value[:, 2, [2, 5]] = -g, g, 1
    weight = np.column_stack([np.einsum("ni,nij,nj->n", e, block[:, :2, :2], e), bend, 3 * bend])
    return Strains(np.repeat(column, 3, axis=0), value.reshape(-1, 2 * PER_NODE), weight.ravel())


def _elements(strains: Strains) -> np.ndarray:
    """Stiffness of every element on the coordinates of both nodes, (n, 6, 6)."""
    value, weight = strains.value.reshape(-1, 3, 2 * PER_NODE), strains.weight.reshape(-1, 3)
    found: np.ndarray = np.einsum("nsi,ns,nsj->nij", value, weight, value)
    return found


def _on_nodes(strains: Strains, count: int) -> np.ndarray:
    """Sums of the elements' stiffness on each node, (count, 3, 3)."""
    blocks, node = _elements(strains), strains.column[::3, [0, PER_NODE]] // PER_NODE
    found = np.zeros((count, PER_NODE, PER_NODE), blocks.dtype)
    np.add.at(found, node[:, 0], blocks[:, :PER_NODE, :PER_NODE])
    np.add.at(found, node[:, 1], blocks[:, PER_NODE:, PER_NODE:])
    return found


def _between(strains: Strains) -> np.ndarray:
    """Blocks between both nodes of every element, (n, 3, 3)."""
    return _elements(strains)[:, :PER_NODE, PER_NODE:]


def _same(one: np.ndarray, other: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> bool:
    """Whether blocks (n, 3, 3) are the same but for round-off, compared with the diagonals of the blocks of their rows and columns."""
    by_row, by_column = (np.sqrt(np.abs(np.real(np.diagonal(each, axis1=1, axis2=2)))) for each in (rows, columns))
    size = by_row[:, :, None] * by_column[:, None, :]
    apart, largest = one - other, (np.abs(np.imag(one)) / size).max()
    steps = np.abs(np.imag(apart)) <= FACTOR_ROUND_OFF * len(one) * largest * size
    return bool(np.all(np.abs(np.real(apart)) <= FACTOR_ROUND_OFF * size) and np.all(steps))
