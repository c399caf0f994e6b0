"""Which entries of the residual's partial derivatives by the design can differ from zero: few, because a variable acts on few bodies.

The loop visits these entries alone, so that hundreds of variables cost it little.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import chain
from typing import Any

import numpy as np

from toolkit.bodies.kernels.constant_kernel import Constant
from toolkit.bodies.kernels.planar_floating import Floating
from toolkit.bodies.kernels.spatial_floating import SpatialFloating
from toolkit.compilation.conversions import ints
from toolkit.joints.kernels.records import Joints
from toolkit.loads.kernels.load_kernel import Loads
from toolkit.loads.kernels.pressure_kernel import Pressures
from toolkit.markers.planar import Markers
from toolkit.markers.spatial import SpatialMarkers


def touched_alike(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether the parts of two plans of one scene are such that the same entries can differ from zero."""
    pairs = zip(_causes(**one), _causes(**other), strict=True)
    return all(mine is its or np.array_equal(mine, its) for mine, its in pairs)


def _causes(
    constant: Constant,
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
    constant: Constant,
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


def _by_strains(constant: Constant) -> tuple[np.ndarray, np.ndarray]:
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
