"""From the numbers of a scene to the plan of the compiled loop: pattern first, then everything that is stored on it.

Which entries of the residual's partial derivatives by the design can differ from zero: few, because a variable acts on few bodies.

The loop visits these entries alone, so that hundreds of variables cost it little.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from toolkit.components.bodies.kernels.constant_kernel import ConstantTerms
from toolkit.components.bodies.kernels.planar_floating import Floating
from toolkit.components.bodies.kernels.spatial_floating import SpatialFloating
from toolkit.components.joints.kernels.records import Joints
from toolkit.components.loads.kernels.load_kernel import Loads
from toolkit.components.loads.kernels.pressure_kernel import Pressures
from toolkit.components.markers.planar import Markers
from toolkit.components.markers.spatial import SpatialMarkers
from toolkit.scene.resolution import ResolvedScene
from toolkit.scene.space import PLANE, SPACE
from toolkit.system.body_arrays import constant_part, drag_alone, floating_part
from toolkit.system.equations import Plan
from toolkit.system.joint_arrays import curve_pairs, gripped, joint_arrays, load_arrays, marker_arrays
from toolkit.system.numbering import Numbering, ints
from toolkit.system.pattern import Pattern, block, build_pattern, joint_entries
from toolkit.system.quantities import Quantities, named_loads
from toolkit.system.spatial_arrays import (
    frames_part,
    pressure_part,
    spatial_floating_part,
    spatial_marker_arrays,
)


def touched_alike(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether the parts of two plans of one scene are such that the same entries can differ from zero."""
    pairs = zip(_causes(**one), _causes(**other), strict=True)
    return all(mine is its or np.array_equal(mine, its) for mine, its in pairs)


def _causes(
    constant: ConstantTerms,
    floating: Floating | SpatialFloating,
    drag: Floating | SpatialFloating,
    markers: Markers | SpatialMarkers,
    joints: Joints,
    loads: Loads,
    pressures: Pressures | None,
    curve_index: np.ndarray,
    curve_variable: np.ndarray,
) -> Iterator[np.ndarray]:
    """Arrays that `touched` looks at and that numbers of a scene can change."""
    yield from (constant.force_row, constant.force_variable)
    for change in (constant.design_mass, constant.design_damping, constant.design_loose, constant.design_strains):
        yield from (change.row, change.variable)
    yield from (constant.strains.column, constant.strains.value != 0)
    for part in (floating, drag):
        yield from (part.block_body, part.block_variable, part.gravity_variable)
    yield from (markers.design_start, markers.design_variable)
    yield from (joints.of, joints.design, loads.design_start, loads.design_variable)
    if pressures is not None:
        yield from (pressures.block_load, pressures.block_variable)
    yield from (curve_index, curve_variable)


def touched(
    n_x: int,
    constant: ConstantTerms,
    floating: Floating | SpatialFloating,
    drag: Floating | SpatialFloating,
    markers: Markers | SpatialMarkers,
    joints: Joints,
    loads: Loads,
    pressures: Pressures | None,
    curve_index: np.ndarray,
    curve_variable: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Row and variable of every such entry, ordered by row."""
    if not n_x:
        return ints([]), ints([])
    matrices = (constant.design_mass, constant.design_damping, constant.design_loose)
    pairs = [(constant.force_row, constant.force_variable), *((each.row, each.variable) for each in matrices)]
    pairs += [_by_strains(constant)]
    pairs += _by_floating(floating) + _by_floating(drag)
    pairs += [] if pressures is None else _by_pressures(pressures, curve_index, curve_variable)
    for part in (joints, loads):
        for k in np.flatnonzero(part.designed).tolist():
            variables = _variables(part, k, markers, curve_index, curve_variable)
            if not len(variables):
                continue
            own = joints.row[k] + np.arange(joints.n_rows[k]) if part is joints else _state(loads, k)
            rows = np.concatenate([own, *(markers.coordinate[markers.start[m] : markers.start[m + 1]] for m in part.marker[k])])
            pairs.append((np.repeat(rows, len(variables)), np.tile(variables, len(rows))))
    keys = np.unique(np.concatenate([rows * n_x + variables for rows, variables in pairs]))
    return keys // n_x, keys % n_x


def _by_strains(constant: ConstantTerms) -> tuple[np.ndarray, np.ndarray]:
    """Unknowns that the changing rows of strains act on, and their variables; all rows have as many entries."""
    strains, changes = constant.strains, constant.design_strains
    shape = len(strains.weight), int(strains.start[-1]) // max(len(strains.weight), 1)
    column, value = (each.reshape(shape)[changes.row] for each in (strains.column, strains.value))
    felt = value != 0
    return ints([column[felt]]), np.repeat(changes.variable, felt.sum(axis=1))


def _state(loads: Loads, k: int) -> np.ndarray:
    """Number of the state of a load, empty if it has none."""
    own: np.ndarray = loads.state[k : k + 1]
    return own[own >= 0]


def _by_floating(floating: Floating | SpatialFloating) -> list[tuple[np.ndarray, np.ndarray]]:
    """Rows and variables of whole bodies: of those whose invariants change, and of all if gravity does."""
    pairs = list(zip(floating.block_body, floating.block_variable, strict=True))[len(floating.frame) :]
    pairs += [(b, x) for b in range(len(floating.frame)) for x in floating.gravity_variable]
    sizes = 3 + floating.n_f if isinstance(floating, Floating) else floating.moves + floating.turns + floating.n_f
    found = [floating.frame[b] + np.arange(sizes[b]) for b, _ in pairs]
    return [(rows, np.full(len(rows), x)) for rows, (_, x) in zip(found, pairs, strict=True)]


def _by_pressures(
    pressures: Pressures, curve_index: np.ndarray, curve_variable: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Rows and variables of whole bodies under pressures that change."""
    found = list(zip(pressures.block_load, pressures.block_variable, strict=True))[len(pressures.curve) :]
    found += [(k, x) for k, c in enumerate(pressures.curve) for x in curve_variable[curve_index == c]]
    sizes = pressures.moves + pressures.turns + pressures.n_f
    return [(pressures.first[k] + np.arange(sizes[k]), np.full(sizes[k], x)) for k, x in found]


def _variables(
    part: Any, k: int, markers: Markers | SpatialMarkers, curve_index: np.ndarray, curve_variable: np.ndarray
) -> np.ndarray:
    """Variables that act on a component through its markers, its parameters or its time curve."""
    by_markers = [markers.design_variable[markers.design_start[m] : markers.design_start[m + 1]] for m in part.marker[k]]
    by_curve = curve_variable[curve_index == part.curve[k]]
    by_parameters = (
        part.changing(k) if isinstance(part, Joints) else part.design_variable[part.design_start[k] : part.design_start[k + 1]]
    )
    return ints([sorted({*chain(*(each.tolist() for each in (*by_markers, by_parameters))), *by_curve.tolist()})])


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
    by_curves = curve_pairs(derivatives)
    driven = set(by_curves[0].tolist())
    makers: dict[str, Callable[[], Any]] = {
        "constant": lambda: constant_part(
            numbering, values, derivatives, constant_rows, pattern, dtype, sizes, kept.plan.constant if kept else None
        ),
        **_PARTS[scene.space](scene, numbering, values, derivatives, columns, pattern, dtype),
        "joints": lambda: joint_arrays(
            scene, numbering, values, derivatives, columns, pattern, dtype, driven, kept.plan.joints if kept else None
        ),
        "loads": lambda: load_arrays(
            scene, numbering, values, derivatives, columns, pattern, dtype, driven, kept.plan.loads if kept else None
        ),
    }
    parts = {
        name: getattr(kept.plan, name) if kept and not kept.changed & _needs(name, derivatives) else make()
        for name, make in makers.items()
    }
    parts |= dict(zip(CURVES, by_curves, strict=True))
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
