"""Markers, loads and joints as flat arrays, in the plane and in space."""

from __future__ import annotations

from collections.abc import Callable, Collection
from operator import itemgetter

import numpy as np

from toolkit.components.bodies.body import MarkerNumbers, SpatialMarkerNumbers
from toolkit.components.joints.joint import Joint, check_rows
from toolkit.components.joints.kernels.laws import ANGLE_LAW, PLAIN_LAW, PROFILE_LAW, angle_law
from toolkit.components.joints.kernels.profile import profile_law
from toolkit.components.joints.kernels.records import (
    CURVE,
    CURVED,
    DESIGN,
    DESIGNED,
    FORM,
    N_ROWS,
    NUMBERS,
    PINNED,
    ROWS,
    SPATIAL_NUMBERS,
    SPATIAL_ROWS,
    Joints,
)
from toolkit.components.joints.rows import Row, forms_of
from toolkit.components.loads.kernels.load_kernel import Loads
from toolkit.components.loads.load import Load
from toolkit.components.markers.component import Component
from toolkit.components.markers.planar import Markers
from toolkit.scene.resolution import ResolvedScene
from toolkit.scene.space import PLANE
from toolkit.system.numbering import Numbering, felt, grips_of, ints, starts
from toolkit.system.pattern import Pattern, block
from toolkit.system.quantities import Quantities, named_loads


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


def marker_changes(derivatives: list[Quantities]) -> list[tuple[int, int, MarkerNumbers | SpatialMarkerNumbers]]:
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
    driven: Collection[int],
    kept: Loads | None = None,
) -> Loads:
    """Loads of the scene, with the places of their local entries in the pattern; `driven` are the time curves that a design variable
    changes, `kept` is what the loads are at other numbers."""
    changes = parameter_changes([d.loads for d in derivatives], len(values.loads))
    places = _places(scene, numbering, columns, pattern) if kept is None else {name: getattr(kept, name) for name in PLACES}
    flat = [change for pairs in changes for change in pairs]
    return Loads(
        **places,
        parameter=np.array(list(values.loads.values()), dtype).reshape(-1, scene.space.load_parameters),
        designed=designed(places["marker"].tolist(), derivatives, changes, places["curve"], driven),
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


def designed(
    markers: list, derivatives: list[Quantities], changes: list, curves: np.ndarray, driven: Collection[int]
) -> np.ndarray:
    """Whether any design variable matters to each component: through a marker, a parameter or its curve, if that is one of the `driven`."""
    active = {m for m, _, _ in marker_changes(derivatives)}
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
        if any(value.imag != 0 for _, value in curve.numbers())
    ]
    return ints([[c for c, _ in pairs]]), ints([[x for _, x in pairs]])


PIN_PLACES, PIN_VALUES = (0, 0, 3, 0, 1, 4), (0, 1, -1, 0, 1, -1)
"""Numbers of the poses in both forms of a pin, behind the place of the constant, and what they are multiplied by."""


def laws_of(joints: list[Joint]) -> list[Callable]:
    """Open formulas of the joints, each once, in order of appearance; angles and profiles have a place of their own."""
    return [law for law in dict.fromkeys(law for joint in joints for law in joint.laws) if law not in (angle_law, profile_law)]


def joint_arrays(
    scene: ResolvedScene,
    numbering: Numbering,
    values: Quantities,
    derivatives: list[Quantities],
    columns: list[np.ndarray],
    pattern: Pattern,
    dtype: type,
    driven: Collection[int],
    kept: Joints | None = None,
) -> Joints:
    """Joints of the scene as forms, with the places of their local entries in the pattern; `driven` are the time curves that a design
    variable changes, `kept` is what the joints are at other numbers."""
    joints: list[Joint] = list(scene.joints.values())
    for joint in joints if kept is None else ():
        check_rows(joint, scene)
    changes, forms = parameter_changes([d.joints for d in derivatives], len(joints)), numbering.forms
    given = forms.numbers(np.concatenate([np.zeros(0), *values.joints.values()]), dtype)
    ends = starts([len(found) for found in changes])
    if kept is not None:
        of = kept.of.copy()
        of[:, DESIGNED] = designed(list(kept.marker), derivatives, changes, kept.curve, driven)
        of[:, DESIGN], of[:, DESIGN + 1] = ends[:-1], ends[1:]
        if not np.array_equal(kept.value, given["value"]):
            of[:, PINNED] = _pinned(of, given) if scene.space is PLANE else 0
        found = forms.changes(changes)
        return kept._replace(of=of, value=given["value"], design=found["design"], design_value=found["design_value"])
    rows = forms.rows
    gripping = [gripped(numbering, columns, f"joints.{name}", joint) for name, joint in scene.joints.items()]
    positions = []
    for name, (both, _) in zip(scene.joints, gripping, strict=True):
        own = numbering.row[name] + np.arange(len(scene.joints[name].row_names))
        positions.append(np.concatenate([pattern.find(*block(r, c)) for r, c in ((both, both), (own, both), (both, own))]))
    markers, planar = [pair for _, pair in gripping], scene.space is PLANE
    curves = curve_numbers(joints, 0)
    of = np.column_stack(
        [
            np.array(markers, np.int64).reshape(-1, 2),
            [numbering.row[name] for name in scene.joints],
            [len(each) for each in rows],
            curves,
            designed(markers, derivatives, changes, curves, driven),
            [int(joint.curved) for joint in joints],
            starts([len(forms_of(each)) for each in rows])[:-1],
            _turned(rows),
            starts([len(places) for places in positions])[:-1],
            *(ends[at : len(joints) + at] for at in (0, 1)),
            np.zeros(len(joints)),
            _laws(joints, rows, ROWS if planar else SPATIAL_ROWS),
        ]
    ).astype(np.int64)
    if planar:
        of[:, PINNED] = _pinned(of, given)
    return Joints(
        numbers=NUMBERS if planar else SPATIAL_NUMBERS,
        of=of,
        **given,
        **forms.changes(changes),
        position=ints(positions),
        **felt(rows, 0 if planar else SPATIAL_ROWS),
    )


def _turned(rows: list[tuple[Row, ...]]) -> np.ndarray:
    """Whether products with the axes of marker a, and of marker b, are among the rows in the plane, (n_joints, 2)."""
    axes = [{vector for form in forms_of(each) for *pair, _ in form.pairs for vector in pair if vector % 3} for each in rows]
    return np.array([[int(any(v // 3 == side for v in found)) for side in range(2)] for found in axes], np.int64).reshape(-1, 2)


def _pinned(of: np.ndarray, forms: dict[str, np.ndarray]) -> np.ndarray:
    """Which joints are nothing but x_a = x_b and y_a = y_b, (n_joints,)."""
    start, place, value = forms["start"], forms["place"], forms["value"]
    found = np.zeros(len(of), np.int64)
    short = (of[:, N_ROWS] == 2) & (of[:, CURVED] == 0) & (of[:, CURVE] < 0)
    for j in np.flatnonzero(short):
        own = slice(start[of[j, FORM], 0], start[of[j, FORM] + 2, 0])
        found[j] = np.array_equal(place[own], PIN_PLACES) and np.array_equal(value[own], PIN_VALUES)
    return found


def _laws(joints: list[Joint], rows: list[tuple[Row, ...]], most: int) -> np.ndarray:
    """Number of the law of every row, and how many forms it has, (n_joints, 2 most)."""
    known: list = laws_of(joints)
    found: np.ndarray = np.zeros((len(rows), most, 2), np.int64)
    for j, each in enumerate(rows):
        for i, row in enumerate(each):
            own = {None: PLAIN_LAW, angle_law: ANGLE_LAW, profile_law: PROFILE_LAW}
            found[j, i] = own[row.law] if row.law in own else known.index(row.law), len(row.forms)
    return found.reshape(len(rows), 2 * most)
