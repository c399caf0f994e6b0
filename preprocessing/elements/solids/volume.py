"""The volume of solid elements, from their geometry alone."""

from __future__ import annotations

from collections.abc import Iterable
from math import fsum

import numpy as np

from preprocessing.elements.solids.elements import ElementBlock, points_of

AT_ONCE = 300_000
"""Points of integration at once."""


def volume_of(blocks: Iterable[ElementBlock]) -> float:
    """Volume of all elements, in the plane their area."""
    return fsum(_volume(block) for block in blocks)


def _volume(block: ElementBlock) -> float:
    """Integral of the determinant of each element's map over the reference element, without its sign."""
    points, weights = points_of(block.kind)
    mapping, at_once = block.geometry.mapping(), max(1, AT_ONCE // len(weights))
    found = []
    for start in range(0, len(block.connectivity), at_once):
        elements = np.arange(start, min(start + at_once, len(block.connectivity)))
        found.append(float((np.abs(mapping.detDF(points, tind=elements)) * weights).sum()))
    return fsum(found)
