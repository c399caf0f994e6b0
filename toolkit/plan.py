"""From the numbers of a scene to the flat arrays of the compiled loop."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.constant_kernel import Constant
from toolkit.bodies.floating_kernel import Floating
from toolkit.bodies.marker_kernel import Markers
from toolkit.equations import Plan
from toolkit.joints.joint_kernel import Joints
from toolkit.loads.load_kernel import Loads
from toolkit.numbering import Numbering
from toolkit.pattern import Pattern, block, build_pattern
from toolkit.quantities import Quantities, loads_of
from toolkit.scene import Scene

Family = list[type]


def build_plan(scene: Scene, numbering: Numbering, values: Quantities, derivatives: list[Quantities], dtype: type) -> Plan:
    """All arrays of the compiled scene; `derivatives` are those of the numbers by each design variable."""
    bodies = list(scene.all_bodies())
    offsets = [numbering.first[name] for name in bodies]
    frames = [numbering.first[name] for name, body in scene.all_bodies().items() if body.floating(scene) is not None]
    constant_rows = [(offset + part.row, offset + part.column) for offset, part in zip(offsets, values.constant, strict=True)]
    columns = [numbering.first[body] + part.columns for (body, _), part in zip(numbering.markers, values.markers, strict=True)]
    pattern = _pattern(scene, numbering, values, constant_rows, frames, columns)
    curve_index, curve_variable = _curve_pairs(derivatives)
    return Plan(
        numbering.n_q,
        numbering.n,
        len(derivatives),
        pattern.indptr,
        pattern.indices,
        _constant(numbering, offsets, values, derivatives, constant_rows, pattern, dtype),
        _floating(frames, values, derivatives, pattern, dtype),
        _markers(scene, numbering, values, derivatives, columns, dtype),
        _joints(scene, numbering, values, derivatives, columns, pattern, dtype),
        _loads(scene, numbering, values, derivatives, columns, pattern, dtype),
        curve_index,
        curve_variable,
    )


def families(components: list) -> list:
    """The different formulas of the components, in order of appearance."""
    return list(dict.fromkeys(component.law() for component in components))


def _both(scene: Scene, numbering: Numbering, columns: list[np.ndarray], component) -> tuple[np.ndarray, list[int]]:
    """Coordinates of a component's two markers, and the markers."""
    markers = [numbering.marker(grip) for grip in component.grips]
    return np.concatenate([columns[m] for m in markers]), markers


def _pattern(scene, numbering, values, constant_rows, frames, columns) -> Pattern:
    entries = list(constant_rows)
    for frame, part in zip(frames, values.floating, strict=True):
        local = frame + np.arange(2 + len(part.moment))
        entries += [block(local[:3], local)]
        inside = (part.row > 0) & (part.column > 0)
        entries += [(frame + 2 + part.row[inside], frame + 2 + part.column[inside])]
    for name, joint in scene.joints.items():
        both, markers = _both(scene, numbering, columns, joint)
        rows = numbering.row[name] + np.arange(len(joint.row_names))
        entries += [block(rows, both)]
        entries += (
            [block(both, both)]
            if joint.curved
            else [block(columns[m][2:3], columns[m]) for m in markers if _turns(scene, numbering, m)]
        )
    for load in loads_of(scene):
        both, _ = _both(scene, numbering, columns, load)
        entries += [block(both, both)]
    return build_pattern(numbering.n, entries)


def _turns(scene: Scene, numbering: Numbering, marker: int) -> bool:
    return scene.body(numbering.markers[marker][0]).has_frame


def _constant(numbering, offsets, values, derivatives, rows, pattern, dtype) -> Constant:
    def joined(source: Quantities, name: str) -> np.ndarray:
        return np.concatenate([np.asarray(getattr(part, name)) for part in source.constant])

    row = np.concatenate([r for r, _ in rows]).astype(np.int64)
    column = np.concatenate([c for _, c in rows]).astype(np.int64)
    kinds = ("mass", "damping", "stiffness")
    mass, damping, stiffness = (np.ascontiguousarray(joined(values, kind), dtype) for kind in kinds)
    entry, variable, changes = [], [], []
    for x, derivative in enumerate(derivatives):
        change = np.stack([joined(derivative, kind) for kind in kinds])
        changed = np.flatnonzero(np.any(change != 0, axis=0))
        entry.append(changed)
        variable.append(np.full(len(changed), x))
        changes.append(change[:, changed])
    mass_x, damping_x, stiffness_x = np.ascontiguousarray(np.concatenate([np.zeros((3, 0)), *changes], axis=1))
    force_x = [np.zeros(numbering.n_q), *(joined(derivative, "force") for derivative in derivatives)]
    return Constant(
        row,
        column,
        pattern.find(row, column),
        mass,
        damping,
        stiffness,
        np.ascontiguousarray(joined(values, "force"), dtype),
        _ints(entry),
        _ints(variable),
        mass_x,
        damping_x,
        stiffness_x,
        np.ascontiguousarray(np.stack(force_x, axis=1)[:, 1:]),
    )


def _floating(frames, values, derivatives, pattern, dtype) -> Floating:
    blocks = [(b, -1, part) for b, part in enumerate(values.floating)]
    places = {b: (part.row, part.column) for b, part in enumerate(values.floating)}
    for x, derivative in enumerate(derivatives):
        blocks += [(b, x, part) for b, part in enumerate(derivative.floating) if _changes(part)]
    n_f = [len(part.moment) - 1 for part in values.floating]
    positions, borders = [], []
    for frame, part, n in zip(frames, values.floating, n_f, strict=True):
        positions.append(pattern.find(frame + 2 + part.row, frame + 2 + part.column))
        local = frame + np.arange(3 + n)
        borders.append(np.concatenate([pattern.find(*block(local[:3], local)), pattern.find(*block(local[3:], local[:3]))]))
    return Floating(
        _ints([[b for b, _, _ in blocks]]),
        _ints([[x for _, x, _ in blocks]]),
        _ints([frames]),
        _ints([n_f]),
        np.array([part.mass for _, _, part in blocks], dtype),
        _starts([len(part.moment) for _, _, part in blocks])[:-1],
        np.ascontiguousarray(np.concatenate([np.zeros((0, 2)), *(part.moment for _, _, part in blocks)]), dtype),
        _starts([len(places[b][0]) for b, _, _ in blocks]),
        _ints([places[b][0] for b, _, _ in blocks]),
        _ints([places[b][1] for b, _, _ in blocks]),
        np.concatenate([np.zeros(0, dtype), *(part.inertia for _, _, part in blocks)]).astype(dtype),
        np.concatenate([np.zeros(0, dtype), *(part.gyroscopic for _, _, part in blocks)]).astype(dtype),
        _ints(positions),
        _starts([len(border) for border in borders])[:-1],
        _ints(borders),
        np.asarray(values.gravity).astype(dtype),
        np.stack([np.zeros(2), *(derivative.gravity for derivative in derivatives)], axis=1)[:, 1:].copy(),
    )


def _changes(part) -> bool:
    return any(np.any(np.asarray(value) != 0) for value in (part.mass, part.moment, part.inertia, part.gyroscopic))


def _markers(scene, numbering, values, derivatives, columns, dtype) -> Markers:
    active = [
        (m, x, derivative.markers[m])
        for m in range(len(columns))
        for x, derivative in enumerate(derivatives)
        if _marker_changes(derivative, m)
    ]
    frames = [numbering.first[body] if scene.body(body).has_frame else -1 for body, _ in numbering.markers]
    shapes = [part.shape for part in values.markers]
    return Markers(
        _ints([frames]),
        np.array([part.point for part in values.markers], dtype).reshape(-1, 3),
        _starts([len(c) for c in columns]),
        _ints(columns),
        np.concatenate([np.zeros((0, 3)), *shapes]).astype(dtype),
        _starts([sum(m == k for m, _, _ in active) for k in range(len(columns))]),
        _ints([[x for _, x, _ in active]]),
        np.array([part.point for _, _, part in active], float).reshape(-1, 3),
        _starts([len(part.shape) for _, _, part in active])[:-1],
        np.concatenate([np.zeros((0, 3)), *(part.shape for _, _, part in active)]),
    )


def _parameter_pairs(table: list[np.ndarray], k: int) -> list[tuple[int, int, float]]:
    return [(x, int(p), change[k, p]) for x, change in enumerate(table) for p in np.flatnonzero(change[k])]


def _joints(scene, numbering, values, derivatives, columns, pattern, dtype) -> Joints:
    joints = list(scene.joints.values())
    known = families(joints)
    changes = [_parameter_pairs([d.joints for d in derivatives], k) for k in range(len(joints))]
    positions, markers = [], []
    for name, joint in scene.joints.items():
        both, pair = _both(scene, numbering, columns, joint)
        rows = numbering.row[name] + np.arange(len(joint.row_names))
        markers.append(pair)
        places = [pattern.find(*block(r, c)) for r, c in ((both, both), (rows, both), (both, rows))]
        positions.append(np.concatenate(places))
    flat = [change for pairs in changes for change in pairs]
    return Joints(
        _ints([[known.index(joint.law()) for joint in joints]]),
        _ints([[int(joint.curved) for joint in joints]]),
        np.array(markers, np.int64).reshape(-1, 2),
        _ints([[numbering.row[name] for name in scene.joints]]),
        _ints([[len(joint.row_names) for joint in joints]]),
        values.joints.astype(dtype),
        _curve_numbers(joints, 0),
        _designed(markers, values, derivatives, changes, _curve_numbers(joints, 0)),
        _starts([len(pairs) for pairs in changes]),
        _ints([[x for x, _, _ in flat]]),
        _ints([[p for _, p, _ in flat]]),
        np.array([value for _, _, value in flat], float),
        _starts([len(places) for places in positions])[:-1],
        _ints(positions),
    )


def _loads(scene, numbering, values, derivatives, columns, pattern, dtype) -> Loads:
    loads = loads_of(scene)
    known = families(loads)
    changes = [_parameter_pairs([d.loads for d in derivatives], k) for k in range(len(loads))]
    flat = [change for pairs in changes for change in pairs]
    both = [_both(scene, numbering, columns, load) for load in loads]
    positions = [pattern.find(*block(local, local)) for local, _ in both]
    before = sum(joint.time_curve is not None for joint in scene.joints.values())
    return Loads(
        _ints([[known.index(load.law()) for load in loads]]),
        np.array([pair for _, pair in both], np.int64).reshape(-1, 2),
        values.loads.astype(dtype),
        _curve_numbers(loads, before),
        _designed([pair for _, pair in both], values, derivatives, changes, _curve_numbers(loads, before)),
        _starts([len(pairs) for pairs in changes]),
        _ints([[x for x, _, _ in flat]]),
        _ints([[p for _, p, _ in flat]]),
        np.array([value for _, _, value in flat], float),
        _starts([len(places) for places in positions])[:-1],
        _ints(positions),
    )


def _designed(markers: list, values: Quantities, derivatives: list[Quantities], changes: list, curves: np.ndarray) -> np.ndarray:
    """Whether any design variable matters to each component: through a marker, a parameter or its curve."""
    active = {m for change in derivatives for m in range(len(values.markers)) if _marker_changes(change, m)}
    driven = set(_curve_pairs(derivatives)[0])
    components = zip(markers, changes, curves, strict=True)
    return _ints([[int(bool(active & set(pair) or change or curve in driven)) for pair, change, curve in components]])


def _marker_changes(derivative: Quantities, m: int) -> bool:
    return bool(np.any(derivative.markers[m].point != 0) or np.any(derivative.markers[m].shape != 0))


def _curve_numbers(components: list, before: int) -> np.ndarray:
    numbers = []
    for component in components:
        numbers.append(-1 if component.time_curve is None else before)
        before += component.time_curve is not None
    return _ints([numbers])


def _curve_pairs(derivatives: list[Quantities]) -> tuple[np.ndarray, np.ndarray]:
    pairs = [
        (c, x)
        for x, derivative in enumerate(derivatives)
        for c, curve in enumerate(derivative.curves)
        if any(np.imag(value) != 0 for _, value in curve.numbers())
    ]
    return _ints([[c for c, _ in pairs]]), _ints([[x for _, x in pairs]])


def _ints(parts: list) -> np.ndarray:
    return np.concatenate([np.zeros(0, np.int64), *(np.asarray(part, np.int64) for part in parts)])


def _starts(lengths: list[int]) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(np.asarray(lengths, np.int64))]).astype(np.int64)
