"""From the numbers of a scene to the plan of the compiled loop: pattern first, then everything that is stored on it."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.compilation.arrays.body_arrays import constant_part, floating_part
from toolkit.compilation.arrays.component_arrays import curve_pairs, gripped, joint_arrays, load_arrays, marker_arrays
from toolkit.compilation.arrays.spatial_arrays import (
    frames_part,
    pressure_part,
    spatial_floating_part,
    spatial_joint_arrays,
    spatial_marker_arrays,
)
from toolkit.compilation.numbering import Numbering, weights
from toolkit.compilation.patterns.pattern import Pattern, block, build_pattern
from toolkit.compilation.patterns.touched import touched
from toolkit.compilation.quantities import Quantities, named_loads
from toolkit.equations.equations import Plan
from toolkit.scene.scene import Scene
from toolkit.scene.space import PLANE, SPACE


def build_plan(scene: Scene, numbering: Numbering, values: Quantities, derivatives: list[Quantities], dtype: type) -> Plan:
    """All arrays of the compiled scene; `derivatives` are those of the numbers by each design variable."""
    offsets = [numbering.first[name] for name in scene.all_bodies()]
    constant_rows = [(offsets[b] + part.row, offsets[b] + part.column) for b, part in values.constant.items()]
    columns = [numbering.first[body] + values.markers[m].columns for m, (body, *_) in enumerate(numbering.markers)]
    pattern = _pattern(scene, numbering, values, constant_rows, columns)
    curve_index, curve_variable = curve_pairs(derivatives)
    *of_space, pressures = _PARTS[scene.space](scene, numbering, values, derivatives, columns, pattern, dtype)
    parts: list[Any] = [
        constant_part(numbering, values, derivatives, constant_rows, pattern, dtype, weights(scene)),
        *of_space,
        load_arrays(scene, numbering, values, derivatives, columns, pattern, dtype),
        pressures,
    ]
    driven = [curve_index, curve_variable]
    numbers = [numbering.n_q, numbering.n, len(derivatives), pattern.indptr, pattern.indices]
    touching = touched(len(derivatives), *[*parts, *driven])
    return Plan(*[*numbers, *parts, np.zeros(0, np.int64), *driven, *touching])


def _planar_parts(scene, numbering, values, derivatives, columns, pattern, dtype) -> tuple:
    """Bodies with a moving frame, markers and joints in the plane, where nothing presses on surfaces."""
    first = list(numbering.first.values())
    frames = [first[b] for b in values.floating]
    return (
        floating_part(frames, values, derivatives, pattern, dtype),
        marker_arrays(scene, numbering, values, derivatives, columns, dtype),
        joint_arrays(scene, numbering, values, derivatives, columns, pattern, dtype),
        None,
    )


def _spatial_parts(scene, numbering, values, derivatives, columns, pattern, dtype) -> tuple:
    """The same in space, and pressures."""
    frames = frames_part(scene, numbering, values, pattern)
    return (
        spatial_floating_part(scene, numbering, values, derivatives, pattern, dtype),
        spatial_marker_arrays(scene, numbering, frames, values, derivatives, columns, dtype),
        spatial_joint_arrays(scene, numbering, values, derivatives, columns, pattern, dtype),
        pressure_part(scene, numbering, values, derivatives, pattern, dtype),
    )


_PARTS = {PLANE: _planar_parts, SPACE: _spatial_parts}
"""What the plan has of bodies, markers, joints and pressures."""


def _pattern(scene: Scene, numbering: Numbering, values: Quantities, constant_rows: list, columns: list[np.ndarray]) -> Pattern:
    """Union of what all parts of the scene fill."""
    entries = list(constant_rows)
    everybody = scene.all_bodies()
    for name, part in ((list(everybody)[b], part) for b, part in values.floating.items()):
        frame, size = numbering.first[name], everybody[name].frame_size
        local = frame + np.arange(size - 1 + len(part.moment))
        entries += [block(local[:size], local)]
        inside = (part.row > 0) & (part.column > 0)
        entries += [(frame + size - 1 + part.row[inside], frame + size - 1 + part.column[inside])]
    for name, row in numbering.length.items():
        entries += [block(np.array([row]), numbering.first[name] + np.arange(3, 7))]
    for name, joint in scene.joints.items():
        both, markers = gripped(numbering, columns, f"joints.{name}", joint)
        rows = numbering.row[name] + np.arange(len(joint.row_names))
        entries += [block(rows, both)]
        entries += (
            [block(both, both)]
            if joint.curved
            else [block(columns[m][2:3], columns[m]) for m in markers if _turns(scene, numbering, m)]
        )
    for name, load in named_loads(scene).items():
        both, _ = gripped(numbering, columns, f"loads.{name}", load)
        entries += [block(both, both)]
    return build_pattern(numbering.n, entries)


def _turns(scene: Scene, numbering: Numbering, marker: int) -> bool:
    return scene.body(numbering.markers[marker][0]).has_frame
