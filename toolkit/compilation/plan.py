"""From the numbers of a scene to the plan of the compiled loop: pattern first, then everything that is stored on it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from toolkit.compilation.arrays.body_arrays import constant_part, drag_alone, floating_part
from toolkit.compilation.arrays.component_arrays import curve_pairs, gripped, load_arrays, marker_arrays
from toolkit.compilation.arrays.joint_arrays import joint_arrays
from toolkit.compilation.arrays.spatial_arrays import (
    frames_part,
    pressure_part,
    spatial_floating_part,
    spatial_marker_arrays,
)
from toolkit.compilation.numbering import Numbering
from toolkit.compilation.patterns.joint_pattern import joint_entries
from toolkit.compilation.patterns.pattern import Pattern, block, build_pattern
from toolkit.compilation.patterns.touched import touched, touched_alike
from toolkit.compilation.quantities import Quantities, named_loads
from toolkit.equations.equations import Plan
from toolkit.scene.resolution import ResolvedScene
from toolkit.scene.space import PLANE, SPACE

NEEDS = {
    "constant": {"constant"},
    "floating": {"floating", "gravity"},
    "drag": {"drag"},
    "markers": {"markers", "floating"},
    "joints": {"joints", "curves"},
    "loads": {"loads", "curves"},
    "pressures": {"pressures", "curves"},
}
"""Part of the plan -> groups of `Quantities` that its arrays follow from; with design variables joints and loads also from the markers."""
THROUGH_MARKERS = ("joints", "loads", "pressures")
CURVES = ("curve_index", "curve_variable")


class Kept(NamedTuple):
    """The plan of the same scene at other numbers, and the groups of `Quantities` that differ."""

    plan: Plan
    changed: frozenset[str]


def build_plan(
    scene: ResolvedScene,
    numbering: Numbering,
    values: Quantities,
    derivatives: list[Quantities],
    dtype: type,
    sizes: np.ndarray,
    kept: Kept | None = None,
) -> Plan:
    """Plan of the compiled loop, with all arrays of the scene.

    Parameters
    ----------
    derivatives
        Those of the numbers by each design variable.
    sizes
        See `numbering.weights`, (n,).
    kept
        What is known from the same scene at other numbers: the pattern, and all parts whose numbers are the same.
    """
    offsets = [numbering.first[name] for name in scene.all_bodies()]
    constant_rows = [(offsets[b] + part.row, offsets[b] + part.column) for b, part in values.constant.items()]
    columns = [numbering.first[body] + values.markers[m].columns for m, (body, *_) in enumerate(numbering.markers)]
    pattern = (
        Pattern.of(kept.plan.indptr, kept.plan.indices) if kept else _pattern(scene, numbering, values, constant_rows, columns)
    )
    makers: dict[str, Callable[[], Any]] = {
        "constant": lambda: constant_part(
            numbering, values, derivatives, constant_rows, pattern, dtype, sizes, kept.plan.constant if kept else None
        ),
        **_PARTS[scene.space](scene, numbering, values, derivatives, columns, pattern, dtype),
        "joints": lambda: joint_arrays(
            scene, numbering, values, derivatives, columns, pattern, dtype, kept.plan.joints if kept else None
        ),
        "loads": lambda: load_arrays(
            scene, numbering, values, derivatives, columns, pattern, dtype, kept.plan.loads if kept else None
        ),
    }
    parts = {
        name: getattr(kept.plan, name) if kept and not kept.changed & _needs(name, derivatives) else make()
        for name, make in makers.items()
    }
    parts |= dict(zip(CURVES, curve_pairs(derivatives), strict=True))
    if kept and touched_alike(parts, {name: getattr(kept.plan, name) for name in parts}):
        touched_row, touched_variable = kept.plan.touched_row, kept.plan.touched_variable
    else:
        touched_row, touched_variable = touched(len(derivatives), **parts)
    return Plan(
        n_q=numbering.n_q,
        n=numbering.n,
        n_x=len(derivatives),
        indptr=pattern.indptr,
        indices=pattern.indices,
        **parts,
        dropped=np.zeros(0, np.int64),
        touched_row=touched_row,
        touched_variable=touched_variable,
    )


def _needs(part: str, derivatives: list[Quantities]) -> set[str]:
    """Groups of numbers that a part of the plan follows from."""
    return NEEDS[part] | ({"markers"} if derivatives and part in THROUGH_MARKERS else set())


def _planar_parts(scene, numbering, values, derivatives, columns, pattern, dtype) -> dict[str, Callable[[], Any]]:
    """Parts of a plan in the plane, each with a function that makes it: bodies with a moving frame, and markers."""
    first = list(numbering.first.values())
    return {
        "floating": lambda: floating_part(first, values, derivatives, pattern, dtype),
        "drag": lambda: floating_part(first, *drag_alone(values, derivatives), pattern, dtype),
        "markers": lambda: marker_arrays(scene, numbering, values, derivatives, columns, dtype),
        "pressures": lambda: None,
    }


def _spatial_parts(scene, numbering, values, derivatives, columns, pattern, dtype) -> dict[str, Callable[[], Any]]:
    """Parts of a plan in space, each with a function that makes it: bodies with a turning frame, markers and pressures."""

    def markers() -> Any:
        frames = frames_part(scene, numbering, values, pattern)
        return spatial_marker_arrays(scene, numbering, frames, values, derivatives, columns, dtype)

    return {
        "floating": lambda: spatial_floating_part(scene, numbering, values, derivatives, pattern, dtype),
        "drag": lambda: spatial_floating_part(scene, numbering, *drag_alone(values, derivatives), pattern, dtype),
        "markers": markers,
        "pressures": lambda: pressure_part(scene, numbering, values, derivatives, pattern, dtype),
    }


_PARTS = {PLANE: _planar_parts, SPACE: _spatial_parts}
"""Functions for the parts of a plan: bodies, markers and pressures."""


def _pattern(
    scene: ResolvedScene, numbering: Numbering, values: Quantities, constant_rows: list, columns: list[np.ndarray]
) -> Pattern:
    """Sparsity pattern of the scene: the union of what all its parts fill."""
    entries = list(constant_rows)
    everybody = scene.all_bodies()
    names = list(everybody)
    for name, part in ((names[b], part) for b, part in values.floating.items()):
        frame, size = numbering.first[name], everybody[name].frame_size
        local = frame + np.arange(size - 1 + len(part.moment))
        entries += [block(local[:size], local)]
        entries += [_elastic(part, local[size:])]
    for name, row in numbering.length.items():
        entries += [block(np.array([row]), numbering.first[name] + np.arange(3, 7))]
    for (name, joint), rows in zip(scene.joints.items(), numbering.forms.rows, strict=True):
        _, markers = gripped(numbering, columns, f"joints.{name}", joint)
        entries += joint_entries(scene, numbering, name, rows, markers, [columns[m] for m in markers])
    for name, load in named_loads(scene).items():
        both, _ = gripped(numbering, columns, f"loads.{name}", load)
        both = np.append(both, numbering.first[f"loads.{name}"]) if load.state is not None else both
        entries += [block(both, both)]
    return build_pattern(numbering.n, entries)


def _elastic(part: Any, coordinates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Entries of a body between its elastic coordinates: all of them, if it is worked with whole matrices."""
    if getattr(part, "full", False):
        return block(coordinates, coordinates)
    inside = (part.row > 0) & (part.column > 0)
    return coordinates[part.row[inside] - 1], coordinates[part.column[inside] - 1]
