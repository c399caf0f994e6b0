"""Markers and loads as flat arrays."""

from __future__ import annotations

from operator import itemgetter
from typing import Any

import numpy as np

from toolkit.compilation.conversions import ints, starts
from toolkit.compilation.numbering import Numbering, grips_of
from toolkit.compilation.patterns.pattern import Pattern, block
from toolkit.compilation.quantities import Quantities, named_loads
from toolkit.loads.kernels.load_kernel import Loads
from toolkit.loads.load import Load
from toolkit.markers.component import Component
from toolkit.markers.planar import Markers
from toolkit.scene.resolution import ResolvedScene


def families(loads: list[Load]) -> list:
    """Formulas of the loads, each once, in order of appearance."""
    return list(dict.fromkeys(load.law() for load in loads))


def gripped(numbering: Numbering, columns: list[np.ndarray], path: str, component: Component) -> tuple[np.ndarray, list[int]]:
    """Coordinates of a component's two markers, and the markers; `path` is where the scene has it."""
    markers = [numbering.marker(grip) for grip in grips_of(path, component)]
    return np.concatenate([columns[m] for m in markers]), markers


def marker_arrays(
    scene: ResolvedScene,
    numbering: Numbering,
    values: Quantities,
    derivatives: list[Quantities],
    columns: list[np.ndarray],
    dtype: type,
) -> Markers:
    """Markers and their design derivatives; `columns` are the coordinates that each one feels."""
    active = marker_changes(derivatives)
    frames = [own[0] if scene.body(body).has_frame else -1 for own, (body, *_) in zip(columns, numbering.markers, strict=True)]
    shapes = [part.shape for part in values.markers.values()]
    return Markers(
        plane=(0, 1, 2),
        frames=None,
        pose=(0, 1, 2),
        frame=ints([frames]),
        twin=ints([[frames.index(frame) for frame in frames]]),
        point=np.array([part.point for part in values.markers.values()], dtype).reshape(-1, 3),
        start=starts([len(c) for c in columns]),
        coordinate=ints(columns),
        shape=np.concatenate([np.zeros((0, 3)), *shapes]).astype(dtype),
        design_start=starts(np.bincount(ints([[m for m, _, _ in active]]), minlength=len(columns)).tolist()),
        design_variable=ints([[x for _, x, _ in active]]),
        design_point=np.array([part.point for _, _, part in active], float).reshape(-1, 3),
        design_shape_start=starts([len(part.shape) for _, _, part in active])[:-1],
        design_shape=np.concatenate([np.zeros((0, 3)), *(part.shape for _, _, part in active)]),
    )


def marker_changes(derivatives: list[Quantities]) -> list[tuple[int, int, Any]]:
    """(marker, variable, derivative) of all markers that a variable moves, marker by marker."""
    found = [(m, x, part) for x, derivative in enumerate(derivatives) for m, part in derivative.markers.items()]
    return sorted((each for each in found if each[2].point.any() or each[2].shape.any()), key=itemgetter(0, 1))


def load_arrays(
    scene: ResolvedScene,
    numbering: Numbering,
    values: Quantities,
    derivatives: list[Quantities],
    columns: list[np.ndarray],
    pattern: Pattern,
    dtype: type,
    kept: Loads | None = None,
) -> Loads:
    """Loads of the scene, with the places of their local entries in the pattern; `kept` is what they are at other numbers."""
    changes = parameter_changes([d.loads for d in derivatives], len(values.loads))
    places = _places(scene, numbering, columns, pattern) if kept is None else {name: getattr(kept, name) for name in PLACES}
    flat = [change for pairs in changes for change in pairs]
    return Loads(
        **places,
        parameter=np.array(list(values.loads.values()), dtype).reshape(-1, scene.space.load_parameters),
        designed=designed(places["marker"].tolist(), derivatives, changes, places["curve"]),
        design_start=starts([len(pairs) for pairs in changes]),
        design_variable=ints([[x for x, _, _ in flat]]),
        design_parameter=ints([[p for _, p, _ in flat]]),
        design_value=np.array([value for _, _, value in flat], float),
    )


PLACES = ("family", "marker", "curve", "scaled", "state", "position_start", "position")
"""Arrays that no number of the scene changes."""


def _places(scene: ResolvedScene, numbering: Numbering, columns: list[np.ndarray], pattern: Pattern) -> dict[str, np.ndarray]:
    loads = named_loads(scene)
    known = families(list(loads.values()))
    both = [gripped(numbering, columns, f"loads.{name}", load) for name, load in loads.items()]
    states = [numbering.first.get(f"loads.{name}", -1) for name in loads]
    locals_of = [local if state < 0 else np.append(local, state) for (local, _), state in zip(both, states, strict=True)]
    positions = [pattern.find(*block(local, local)) for local in locals_of]
    before = sum(joint.time_curve is not None for joint in scene.joints.values())
    return {
        "family": ints([[known.index(load.law()) for load in loads.values()]]),
        "marker": np.array([pair for _, pair in both], np.int64).reshape(-1, 2),
        "curve": curve_numbers(list(loads.values()), before),
        "scaled": ints([[int(not load.leads) for load in loads.values()]]),
        "state": ints([states]),
        "position_start": starts([len(places) for places in positions])[:-1],
        "position": ints(positions),
    }


def designed(markers: list, derivatives: list[Quantities], changes: list, curves: np.ndarray) -> np.ndarray:
    """Whether any design variable matters to each component: through a marker, a parameter or its curve."""
    active = {m for m, _, _ in marker_changes(derivatives)}
    driven = set(curve_pairs(derivatives)[0])
    components = zip(markers, changes, curves, strict=True)
    return ints([[int(bool(active & set(pair) or change or curve in driven)) for pair, change, curve in components]])


def parameter_changes(tables: list[dict[int, np.ndarray]], count: int) -> list[list[tuple[int, int, float]]]:
    """(variable, parameter, derivative) of each of `count` components."""
    found: list[list[tuple[int, int, float]]] = [[] for _ in range(count)]
    for x, table in enumerate(tables):
        for k, change in table.items():
            found[k] += [(x, int(p), change[p]) for p in np.flatnonzero(change)]
    return found


def curve_numbers(components: list, before: int) -> np.ndarray:
    """Number of each component's time curve, counted from `before`; -1 without."""
    numbers = []
    for component in components:
        numbers.append(-1 if component.time_curve is None else before)
        before += component.time_curve is not None
    return ints([numbers])


def curve_pairs(derivatives: list[Quantities]) -> tuple[np.ndarray, np.ndarray]:
    """Which time curves depend on which design variables."""
    pairs = [
        (c, x)
        for x, derivative in enumerate(derivatives)
        for c, curve in derivative.curves.items()
        if any(np.imag(value) != 0 for _, value in curve.numbers())
    ]
    return ints([[c for c, _ in pairs]]), ints([[x for _, x in pairs]])
