"""The stress of solids as point data for ParaView."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.responses.stress.von_mises import point_stress

COMPONENTS = {"XX": 0, "YY": 1, "ZZ": 2, "XY": 5, "YZ": 3, "XZ": 4}
"""Components of a symmetric tensor in the order of VTK -> their place in ours, xx, yy, zz, yz, xz, xy."""


def add_stress(mesh: Any, components: np.ndarray, label: str) -> None:
    """Give a mesh six components (n, 6) in the body's own axes, and von Mises' stress of these."""
    mesh.point_data[f"von Mises {label}"] = point_stress(components)
    mesh.point_data[label] = components[:, list(COMPONENTS.values())]
    array = mesh.GetPointData().GetArray(label)
    for place, name in enumerate(COMPONENTS):
        array.SetComponentName(place, name)
