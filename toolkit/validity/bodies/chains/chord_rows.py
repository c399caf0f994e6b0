"""Rows of displacements that a frame on a chord does not feel, from the undeformed places of the chord's two points."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.near_ties import first_smallest
from toolkit.kinematics.beam_elements import BeamElements, at_place


def chord_rows(nodes: np.ndarray, connectivity: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Rows (3, n): both displacements of the first point, and that of the second across the line through both, (2,) each."""
    first, second = (displacement_rows(nodes, connectivity, point) for point in (one, other))
    side = other - one
    return np.vstack([first, (np.array([-side[1], side[0]]) / np.linalg.norm(side)) @ second])


def displacement_rows(nodes: np.ndarray, connectivity: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Rows (2, n) of the displacement at an undeformed place (2,) of the element that it is nearest to."""
    start, side = nodes[connectivity[:, 0]], nodes[connectivity[:, 1]] - nodes[connectivity[:, 0]]
    ratio = np.clip(np.einsum("ed,ed->e", place - start, side) / np.einsum("ed,ed->e", side, side), 0.0, 1.0)
    away = np.linalg.norm(start + ratio[:, None] * side - place, axis=1)
    e = first_smallest(away / np.linalg.norm(side, axis=1).sum())
    found = np.zeros((2, 3 * len(nodes)))
    own = (3 * connectivity[e][:, None] + np.arange(3)).ravel()
    found[:, own] = at_place(BeamElements.in_plane(nodes[connectivity[[e]]]).shape[0], ratio[e])
    return found
