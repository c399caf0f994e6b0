"""Choices that round-off does not decide: the largest of near equals, the bases of modes, a few of many instants.

Which of all bases of the same modes is told: a rule that does not see the last digits.

Modes of equal frequency (bending of a square beam in two planes) are told apart by round-off alone: every turn of them within
their space is as good, and another processor finds another one. So they are turned, one after the other, until a coordinate that
moves strongly in their space moves in one mode only, and there to the positive side. Which coordinate that is depends on the
space and not on the modes that happened to be found.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

TIE_BAND = 1e-6
"""Part of the largest by which sizes that mean the same may differ: round-off of a mechanism's state is far below, a difference
that a reader would see far above."""
RESULT_TIE_BAND = 1e-9
"""Band for values of which one is the result: what stiff bodies leave of their digits."""


def first_largest(sizes: np.ndarray, band: float = TIE_BAND) -> int:
    """Number of the first size (n,) that is the largest but for a part `band` of it.

    Where a size is not a number, it is that of the first such one.
    """
    lost = np.isnan(sizes)
    if lost.any():
        return int(np.argmax(lost))
    largest = sizes.max()
    return int(np.argmax(sizes >= largest - band * abs(largest)))


def first_smallest(sizes: np.ndarray, band: float = TIE_BAND) -> int:
    """Number of the first size (n,), not negative, that is the smallest but for a part `band` of the largest."""
    return int(np.argmax(sizes <= sizes.min() + band * sizes.max()))


EQUAL_EIGENVALUES = 1e-6
"""Relative distance below which two eigenvalues count as equal. The round-off of the stiffness matrix moves the eigenvalues of
the wing's skin by 1e-10 (30 elements) to 1e-8 (200); at this distance it turns single vectors by 1e-4 to 1e-2, which then mean nothing."""
STRONG_COORDINATE = 0.45
"""Part of the strongest motion from which a coordinate counts as strong, and the first such one is taken: not 1/2, which regular
meshes meet exactly."""


def clusters(eigenvalues: np.ndarray) -> Iterator[tuple[int, int]]:
    """First mode, and first mode behind, of all runs of equal eigenvalues, which are in order."""
    below, above = np.abs(eigenvalues[:-1]), np.abs(eigenvalues[1:])
    apart = np.diff(eigenvalues) > EQUAL_EIGENVALUES * np.maximum(below, above)
    borders = [0, *(np.flatnonzero(apart) + 1).tolist(), len(eigenvalues)]
    yield from pairwise(borders)


def told_apart(eigenvalues: np.ndarray, shapes: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Modes (n, m) turned within each run of equal eigenvalues (m,), and with signs, as the rule says.

    Parameters
    ----------
    sizes : (n,) by which coordinates are multiplied to be compared
    """
    found = shapes.copy()
    for first, behind in clusters(eigenvalues):
        found[:, first:behind] = _turned(shapes[:, first:behind], sizes)
    return found


def _turned(shapes: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    left, found = shapes, []
    while left.shape[1]:
        moves = sizes * np.linalg.norm(left, axis=1)
        place = int(np.argmax(moves > STRONG_COORDINATE * moves.max()))
        along = left[place] / np.linalg.norm(left[place])
        found.append(left @ along)
        left = left @ _perpendicular(along)
    return np.column_stack(found)


def _perpendicular(unit: np.ndarray) -> np.ndarray:
    """Orthonormal columns (m, m - 1) of all that is perpendicular to a unit vector (m,): those of a reflection."""
    normal = unit.copy()
    normal[0] += np.copysign(1.0, unit[0])
    return (np.eye(len(unit)) - 2 * np.outer(normal, normal) / (normal @ normal))[:, 1:]


def spread(last: int, most: int) -> list[int]:
    """Numbers of instants spread evenly over a motion.

    Parameters
    ----------
    last
        Number of the last instant; the first is 0.
    most
        How many are wanted at most.

    Returns
    -------
    chosen
        Rising numbers from 0 to `last`, both among them.
    """
    return sorted({int(k) for k in np.linspace(0, last, min(most, last + 1)).round()})
