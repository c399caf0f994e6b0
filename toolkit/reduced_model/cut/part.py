"""A part of a chain of elements with a frame of its own, which goes through both of its ends.

The first node of a part stays in its place in the frame, and the last one on the line through both: the chord. The elastic coordinates are
the rotation of the first node, all coordinates of the nodes between, and of the last node its displacement along the chord and its
rotation. With the matrix C that gives the nodal coordinates from these, and all sums over the elements of the part,

    N = (sum N_e) C,   G = C^T (sum G_e) C,   H = C^T (sum H_e) C,   K = C^T (sum K_e) C,   stress operator = B C

All axes and the origin are those of the whole undeformed body.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.kinematics.beam_functions import AXIAL, HERMITE, slope
from toolkit.reduced_model.cut.chain import Place
from toolkit.reduced_model.elements import Elements
from toolkit.reduced_model.model import Invariants

SHORT = 1e-3
"""Distance of the ends of a part in parts of its length, below which no chord leads from one to the other."""


@dataclass(frozen=True)
class Part:
    """Elements from `first` up to, but without, `last` of a chain."""

    first: int
    last: int
    nodes: np.ndarray  # (n_nodes, 2) of the part, undeformed
    recovery: np.ndarray  # (3 n_nodes, 1 + n_f) Z on the nodal coordinates of the part
    invariants: Invariants
    stress_rows: np.ndarray  # numbers of its stress points among those of the body

    @property
    def n_f(self) -> int:
        """Elastic coordinates."""
        return self.recovery.shape[1] - 1

    def at(self, place: Place) -> tuple[np.ndarray, np.ndarray]:
        """Z_P (2, 1 + n_f) and T_P (1 + n_f,) of a point of one of its elements."""
        start = place.element - self.first
        local = self.recovery[3 * start : 3 * start + 6]
        if place.ratio in (0.0, 1.0):
            rows = local[:3] if place.ratio == 0 else local[3:]
            return rows[:2], rows[2]
        shape, turn = _functions(self.nodes[start : start + 2], place.ratio)
        return shape @ local, turn @ local


def coordinate_count(first: int, last: int) -> int:
    """Elastic coordinates of a part."""
    return 3 * (last - first)


def part_of(elements: Elements, first: int, last: int, stress_elements: np.ndarray) -> Part:
    """The part of a chain from one of its elements up to, but without, another.

    Parameters
    ----------
    elements
        At one design, real or complex.
    stress_elements
        Element of every stress point, (n_stress,).

    Raises
    ------
    InputError
        No chord leads from its first node to its last.
    """
    own = slice(first, last)
    nodes = elements.nodes[np.append(elements.connectivity[own, 0], elements.connectivity[last - 1, 1])]
    psi = _coordinates(nodes, first, last)
    z = np.zeros((1 + len(psi), 1 + psi.shape[1]), psi.dtype)
    z[0, 0], z[1:, 1:] = 1, psi
    where = 3 * np.arange(last - first)[:, None] + np.arange(6)
    whole = np.column_stack([np.zeros(last - first, int), 1 + where])

    def moment(blocks: np.ndarray) -> np.ndarray:
        return z.T @ _placed(blocks[own], whole, len(z)) @ z

    def square(blocks: np.ndarray) -> np.ndarray:
        return psi.T @ _placed(blocks[own], where, len(psi)) @ psi

    rows = np.flatnonzero((stress_elements >= first) & (stress_elements < last))
    columns = np.zeros((2, len(z)), elements.first_moment.dtype)
    for block, places in zip(elements.first_moment[own], whole, strict=True):
        columns[:, places] += block
    recovery = np.column_stack([np.column_stack([nodes, np.zeros(len(nodes))]).ravel(), psi])
    return Part(
        first, last, nodes, recovery,
        Invariants(
            mass=elements.mass[own].sum(),
            first_moment=columns @ z,
            inertia=_symmetric(moment(elements.inertia)),
            gyroscopic=_antisymmetric(moment(elements.gyroscopic)),
            stiffness=_symmetric(square(elements.stiffness)),
            damping=_symmetric(square(elements.damping)),
            stress_operator=_stress(elements.stress_operator[rows], where[stress_elements[rows] - first], psi),
        ),
        rows,
    )  # fmt: skip


def _coordinates(nodes: np.ndarray, first: int, last: int) -> np.ndarray:
    """Nodal coordinates per elastic coordinate, (3 n_nodes, n_f): of the first node, those between, and the last one."""
    chord, sides = nodes[-1] - nodes[0], np.real(np.diff(nodes, axis=0))
    length = np.sqrt(chord @ chord)
    if np.real(length) <= SHORT * np.sqrt((sides * sides).sum(axis=1)).sum():
        raise InputError(
            f"the part of a flexible body from node {first} to node {last} begins where it ends, so that its frame has no chord to "
            "turn with. Write other `frames`."
        )
    n = 3 * len(nodes)
    found = np.zeros((n, n - 3), chord.dtype)
    found[2, 0] = 1
    found[3 : n - 3, 1 : n - 5] = np.eye(n - 6)
    found[n - 3 : n - 1, n - 5] = chord / length
    found[n - 1, n - 4] = 1
    return found


def _placed(blocks: np.ndarray, places: np.ndarray, size: int) -> np.ndarray:
    """Sum of blocks (n_e, k, k) at places (n_e, k) of a square matrix."""
    found = np.zeros((size, size), blocks.dtype)
    np.add.at(found, (places[:, :, None], places[:, None, :]), blocks)
    return found


def _stress(rows: np.ndarray, places: np.ndarray, psi: np.ndarray) -> np.ndarray:
    """Rows (n_s, 6) on the coordinates of elements as rows on the elastic coordinates."""
    return np.einsum("sl,slf->sf", rows, psi[places])


def _functions(ends: np.ndarray, ratio: Any) -> tuple[np.ndarray, np.ndarray]:
    """Displacement (2, 6) and rotation (6,) of a point of a beam per coordinate of its ends."""
    side = ends[1] - ends[0]
    length = np.sqrt(side @ side)
    e = side / length
    n = np.array([-e[1], e[0]])
    powers = ratio ** np.arange(4)
    axial, across, turn = powers @ AXIAL, powers @ HERMITE, powers @ slope(HERMITE) / length
    scale = np.array([1.0, length, 1.0, length])
    shape, rotation = np.zeros((2, 6), side.dtype), np.zeros(6, side.dtype)
    for end, node in enumerate((slice(0, 2), slice(3, 5))):
        shape[:, node] = axial[end] * np.outer(e, e) + across[2 * end] * np.outer(n, n)
        rotation[node] = turn[2 * end] * n
    shape[:, [2, 5]] = np.outer(n, (across * scale)[[1, 3]])
    rotation[[2, 5]] = (turn * scale)[[1, 3]]
    return shape, rotation


def _symmetric(matrix: np.ndarray) -> np.ndarray:
    return (matrix + matrix.T) / 2


def _antisymmetric(matrix: np.ndarray) -> np.ndarray:
    return (matrix - matrix.T) / 2
