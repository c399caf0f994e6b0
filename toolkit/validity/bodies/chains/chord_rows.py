"""Rows of displacements that a frame on a chord does not feel, from the undeformed places of the chord's two points."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.near_ties import first_smallest
from toolkit.validity.bodies.chains.element_sections import Elements


def chord_rows(elements: Elements, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Rows (3, n): both displacements of the first point, and that of the second across the line through both, (2,) each."""
    first, second = displacement_rows(elements, one), displacement_rows(elements, other)
    side = other - one
    return np.vstack([first, (np.array([-side[1], side[0]]) / np.linalg.norm(side)) @ second])


def displacement_rows(elements: Elements, place: np.ndarray) -> np.ndarray:
    """Rows (2, n) of the displacement at an undeformed place (2,) of the element that it is nearest to."""
    start = elements.nodes[elements.connectivity[:, 0]]
    ratio = np.clip(np.einsum("ed,ed->e", place - start, elements.along) / elements.lengths, 0.0, 1.0)
    away = np.linalg.norm(start + (ratio * elements.lengths)[:, None] * elements.along - place, axis=1)
    e = first_smallest(away / elements.lengths.sum())
    r, length, found = ratio[e], elements.lengths[e], np.zeros((2, 3 * len(elements.nodes)))
    ends = ((1 - r, 1 - 3 * r**2 + 2 * r**3, r - 2 * r**2 + r**3), (r, 3 * r**2 - 2 * r**3, r**3 - r**2))
    for end, (axial, lateral, turn) in enumerate(ends):
        own = elements.dofs[e, 3 * end : 3 * end + 3]
        found[:, own[:2]] = axial * np.outer(elements.along[e], elements.along[e])
        found[:, own[:2]] += lateral * np.outer(elements.across[e], elements.across[e])
        found[:, own[2]] = turn * length * elements.across[e]
    return found
