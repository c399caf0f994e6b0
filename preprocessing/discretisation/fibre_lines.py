"""What pictures of spatial beams show: every fibre whose stress is told, as a line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from preprocessing.elements.kinds.spatial_beam import SpatialBeam
from preprocessing.elements.section_shape import SectionShape, value_of
from toolkit.reduced_model.spatial_model import Surface


def fibre_lines(beams: SpatialBeam, z: np.ndarray, values: Mapping[str, Any]) -> Surface:
    """The lines for Z = [xi, Psi] (n, 1 + n_f), at the dimensions `values` of the sections."""
    first, triad = beams.first_rows, beams.axes
    position = np.zeros((int(first[-1]), 3, z.shape[1]))
    for each in beams.patches:
        dimensions = {quantity: values[name] for quantity, name in each.patch.parameters.items()}
        for element in each.patch.elements:
            offsets = _offsets(each.shape, dimensions) @ triad[element, 1:]
            ends = ((k, node) for k in range(len(offsets)) for node in beams.connectivity[element])
            for number, (k, node) in enumerate(ends, first[element]):
                position[number] = _moved(z, node, offsets[k])
    return Surface(position, np.zeros((0, 3), int), np.arange(len(position)).reshape(-1, 2))


def _offsets(shape: SectionShape, dimensions: Mapping[str, Any]) -> np.ndarray:
    """y_2, y_3 of every fibre, (n_fibres, 2)."""
    return np.array([[value_of(fibre.second, dimensions), value_of(fibre.third, dimensions)] for fibre in shape.fibres])


def _moved(z: np.ndarray, node: int, offset: np.ndarray) -> np.ndarray:
    """Place (3, 1 + n_f) of a point beside a node, at the offset (3,) when undeformed."""
    rows = z[SpatialBeam.per_node * node : SpatialBeam.per_node * (node + 1)]
    place = rows[:3] + np.cross(rows[3:], offset[:, None], axis=0)
    place[:, 0] += offset
    return place
