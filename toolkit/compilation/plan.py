"""From the numbers of a scene to the plan of the compiled loop: pattern first, then everything that is stored on it."""

from __future__ import annotations

import numpy as np

from toolkit.compilation.body_arrays import constant_part, floating_part
from toolkit.compilation.component_arrays import curve_pairs, gripped, joint_arrays, load_arrays, marker_arrays
from toolkit.compilation.numbering import Numbering, weights
from toolkit.compilation.pattern import Pattern, block, build_pattern
from toolkit.compilation.quantities import Quantities, loads_of
from toolkit.compilation.touched import touched
from toolkit.equations import Plan
from toolkit.scene import Scene


def build_plan(scene: Scene, numbering: Numbering, values: Quantities, derivatives: list[Quantities], dtype: type) -> Plan:
    """All arrays of the compiled scene; `derivatives` are those of the numbers by each design variable."""
    offsets = [numbering.first[name] for name in scene.all_bodies()]
    frames = [offsets[b] for b in values.floating]
    constant_rows = [(offsets[b] + part.row, offsets[b] + part.column) for b, part in values.constant.items()]
    columns = [numbering.first[body] + values.markers[m].columns for m, (body, _) in enumerate(numbering.markers)]
    pattern = _pattern(scene, numbering, values, constant_rows, frames, columns)
    curve_index, curve_variable = curve_pairs(derivatives)
    parts = (
        constant_part(numbering, values, derivatives, constant_rows, pattern, dtype, weights(scene)),
        floating_part(frames, values, derivatives, pattern, dtype),
        marker_arrays(scene, numbering, values, derivatives, columns, dtype),
        joint_arrays(scene, numbering, values, derivatives, columns, pattern, dtype),
        load_arrays(scene, numbering, values, derivatives, columns, pattern, dtype),
    )
    return Plan(
        numbering.n_q,
        numbering.n,
        len(derivatives),
        pattern.indptr,
        pattern.indices,
        *parts,
        curve_index,
        curve_variable,
        *touched(len(derivatives), *parts, curve_index, curve_variable),
    )


def _pattern(
    scene: Scene, numbering: Numbering, values: Quantities, constant_rows: list, frames: list[int], columns: list[np.ndarray]
) -> Pattern:
    """Union of what all parts of the scene fill."""
    entries = list(constant_rows)
    for frame, part in zip(frames, values.floating.values(), strict=True):
        local = frame + np.arange(2 + len(part.moment))
        entries += [block(local[:3], local)]
        inside = (part.row > 0) & (part.column > 0)
        entries += [(frame + 2 + part.row[inside], frame + 2 + part.column[inside])]
    for name, joint in scene.joints.items():
        both, markers = gripped(numbering, columns, joint)
        rows = numbering.row[name] + np.arange(len(joint.row_names))
        entries += [block(rows, both)]
        entries += (
            [block(both, both)]
            if joint.curved
            else [block(columns[m][2:3], columns[m]) for m in markers if _turns(scene, numbering, m)]
        )
    for load in loads_of(scene):
        both, _ = gripped(numbering, columns, load)
        entries += [block(both, both)]
    return build_pattern(numbering.n, entries)


def _turns(scene: Scene, numbering: Numbering, marker: int) -> bool:
    return scene.body(numbering.markers[marker][0]).has_frame
