"""The parts of a spatial scene as flat arrays: frames, bodies whose frame turns, markers, pressures."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.components.bodies.body import SpatialFloatingNumbers
from toolkit.components.bodies.kernels.spatial_floating import SpatialFloating
from toolkit.components.loads.kernels.pressure_kernel import Pressures
from toolkit.components.markers.component import Component
from toolkit.components.markers.spatial import POSE_NUMBERS, SpatialMarkers
from toolkit.foundation.errors import InputError
from toolkit.foundation.kinematics.orientation import Frames
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.body_arrays import stiffened_entries
from toolkit.system.joint_arrays import marker_changes
from toolkit.system.numbering import Numbering, grips_of, ints, starts
from toolkit.system.pattern import Pattern, block
from toolkit.system.quantities import Quantities, named_loads, pressures_of, pressures_on_pieces


def turning(scene: ResolvedScene) -> list[str]:
    """Bodies whose frame turns, in the order of the frames."""
    return [name for name in scene.pieces() if scene.body(name).turns]


def frames_part(scene: ResolvedScene, numbering: Numbering, values: Quantities, pattern: Pattern) -> Frames:
    """Frames that turn; body b of the moving bodies has frame b."""
    names = turning(scene)
    first = [numbering.first[name] + scene.body(name).frame_size - scene.body(name).turns for name in names]
    rows = [numbering.length.get(name, -1) for name in names]
    position = np.zeros((len(names), 12), np.int64)
    for f, (at, row) in enumerate(zip(first, rows, strict=True)):
        if row >= 0:
            four, length = at + np.arange(4), np.full(4, row)
            position[f] = np.concatenate([pattern.find(*pair) for pair in ((length, four), (four, length), (four, four))])
    axes = np.array([np.real(part.axis) for part in values.floating.values()], float).reshape(-1, 3)
    return Frames(
        first=ints([first]),
        turns=ints([[scene.body(name).turns for name in names]]),
        axis=axes,
        row=ints([rows]),
        position=position,
    )


def spatial_floating_part(
    scene: ResolvedScene, numbering: Numbering, values: Quantities, derivatives: list[Quantities], pattern: Pattern, dtype: type
) -> SpatialFloating:
    """Invariants of bodies with a turning frame and of their design derivatives."""
    bodies = list(values.floating.values())
    names = turning(scene) if bodies else []
    number = {b: k for k, b in enumerate(values.floating)}
    blocks: list[tuple[int, int, Any]] = [(k, -1, part) for k, part in enumerate(bodies)]
    for x, derivative in enumerate(derivatives):
        blocks += [(number[b], x, part) for b, part in derivative.floating.items() if _changes(part)]
    falling = [x for x, derivative in enumerate(derivatives) if np.any(derivative.gravity != 0)]
    positions, borders, stiffened = [ints([])], [], [ints([])]
    inside = {k: stiffened_entries(part) for k, part in enumerate(bodies)}
    for name, part, within in zip(names, bodies, inside.values(), strict=True):
        frame, size = numbering.first[name], scene.body(name).frame_size
        stiffened.append(pattern.find(frame + size - 1 + part.row[within], frame + size - 1 + part.column[within]))
        if not part.full:
            positions.append(pattern.find(frame + size - 1 + part.row, frame + size - 1 + part.column))
        local = frame + np.arange(size - 1 + len(part.moment))
        borders.append(pattern.find(local, np.full(len(local), frame)))
    listed = [not bodies[b].full for b, _, _ in blocks]
    matrices = [ints([])[:0].astype(dtype) if a_list else part.whole for a_list, (_, _, part) in zip(listed, blocks, strict=True)]
    lists = [(bodies[b], part.second) for a_list, (b, _, part) in zip(listed, blocks, strict=True) if a_list]
    empty: np.ndarray = np.zeros((0, 9), dtype)
    return SpatialFloating(
        block_body=ints([[b for b, _, _ in blocks]]),
        block_variable=ints([[x for _, x, _ in blocks]]),
        frame=ints([[numbering.first[name] for name in names]]),
        moves=ints([[scene.body(name).moves for name in names]]),
        turns=ints([[scene.body(name).turns for name in names]]),
        n_f=ints([[len(part.moment) - 1 for part in bodies]]),
        mass=np.array([part.mass for _, _, part in blocks], dtype),
        moment_start=starts([len(part.moment) for _, _, part in blocks])[:-1],
        moment=np.ascontiguousarray(np.concatenate([empty[:, :3], *(part.moment for _, _, part in blocks)]).T, dtype),
        full=ints([[int(part.full) for part in bodies]]),
        matrix_start=starts([len(matrix) for matrix in matrices])[:-1],
        matrix=np.concatenate([empty.ravel(), *matrices]).astype(dtype),
        entry_start=starts([len(bodies[b].row) if a_list else 0 for a_list, (b, _, _) in zip(listed, blocks, strict=True)]),
        entry_row=ints([part.row for part, _ in lists]),
        entry_column=ints([part.column for part, _ in lists]),
        second=np.ascontiguousarray(np.concatenate([empty, *(second for _, second in lists)]), dtype),
        entry_position=ints(positions),
        stiffened_start=starts([len(inside[b]) for b, _, _ in blocks]),
        stiffened_row=ints([bodies[b].row[inside[b]] for b, _, _ in blocks]),
        stiffened_column=ints([bodies[b].column[inside[b]] for b, _, _ in blocks]),
        stiffening=np.ascontiguousarray(
            np.concatenate([empty, *(part.stiffening[inside[b]] for b, _, part in blocks if len(inside[b]))]), dtype
        ),
        stiffened_position=ints(stiffened),
        border_start=starts([len(border) for border in borders])[:-1],
        border=ints(borders),
        gravity=np.asarray(values.gravity).astype(dtype),
        gravity_variable=ints([falling]),
        design_gravity=np.array([derivatives[x].gravity for x in falling], float).reshape(-1, 3),
    )


def _changes(part: SpatialFloatingNumbers) -> bool:
    if np.any(part.axis):
        raise InputError("the axis of a turning frame cannot be a design variable: it defines the frame's coordinate.")
    return any(np.any(np.asarray(value) != 0) for value in (part.mass, part.moment, part.second, part.stiffening))


def spatial_marker_arrays(
    scene: ResolvedScene,
    numbering: Numbering,
    frames: Frames,
    values: Quantities,
    derivatives: list[Quantities],
    columns: list[np.ndarray],
    dtype: type,
) -> SpatialMarkers:
    """Markers and their design derivatives; `columns` are the coordinates that each one feels."""
    active, number = marker_changes(derivatives), {name: f for f, name in enumerate(turning(scene))}
    pieces = [scene.piece(body, point) for body, point, *_ in numbering.markers]
    bodies = [scene.body(piece) for piece in pieces]
    parts, full = list(values.markers.values()), _with_axes(scene, numbering)
    return SpatialMarkers(
        plane=None,
        frames=frames,
        pose=tuple(range(POSE_NUMBERS)),
        frame=ints([[number.get(piece, len(number)) for piece in pieces]]),
        moves=ints([[body.moves for body in bodies]]),
        turns=ints([[body.turns for body in bodies]]),
        bends=ints([[int(np.any(part.shape[:, 3:] != 0)) if m in full else 0 for m, part in enumerate(parts)]]),
        size=ints([[POSE_NUMBERS if m in full else 3 for m in range(len(parts))]]),
        point=np.array([part.point for part in parts], dtype).reshape(-1, 15),
        start=starts([len(c) for c in columns]),
        coordinate=ints(columns),
        shape=np.concatenate([np.zeros((0, 6)), *(part.shape for part in parts)]).astype(dtype),
        design_start=starts(np.bincount(ints([[m for m, _, _ in active]]), minlength=len(columns)).tolist()),
        design_variable=ints([[x for _, x, _ in active]]),
        design_point=np.array([part.point for _, _, part in active], float).reshape(-1, 15),
        design_shape_start=starts([len(part.shape) for _, _, part in active])[:-1],
        design_shape=np.concatenate([np.zeros((0, 6)), *(part.shape for _, _, part in active)]),
    )


def _with_axes(scene: ResolvedScene, numbering: Numbering) -> set[int]:
    """Numbers of the markers whose axes something asks for."""
    components: dict[str, Component] = {**{f"joints.{name}": each for name, each in scene.joints.items()}}
    components |= {f"loads.{name}": each for name, each in named_loads(scene).items()}
    used = {numbering.marker(grip) for path, each in components.items() if each.feels_axes for grip in grips_of(path, each)}
    seen = {numbering.marker(grip) for grip in numbering.seen}
    return seen | used


def pressure_part(
    scene: ResolvedScene, numbering: Numbering, values: Quantities, derivatives: list[Quantities], pattern: Pattern, dtype: type
) -> Pressures:
    """Pressures on surfaces and their design derivatives."""
    names, loads = zip(*pressures_on_pieces(scene), strict=True) if pressures_of(scene) else ((), ())
    number, place = ({name: k for k, name in enumerate(each)} for each in (turning(scene), pressures_of(scene)))
    blocks = [(k, -1, part) for k, part in values.pressures.items()]
    for x, derivative in enumerate(derivatives):
        blocks += [(k, x, part) for k, part in derivative.pressures.items() if np.any(part.force) or np.any(part.moment)]
    before = sum(each.time_curve is not None for each in [*scene.joints.values(), *named_loads(scene).values()])
    bodies: list[Any] = [scene.body(load.body) for load in loads]
    first = [numbering.first[load.body] for load in loads]
    n_f = [len(part.moment) - 1 for part in values.pressures.values()]
    positions = []
    for body, at, n in zip(bodies, first, n_f, strict=True):
        positions.append(pattern.find(*block(at + np.arange(body.frame_size), at + np.arange(body.frame_size + n))))
    return Pressures(
        block_load=ints([[k for k, _, _ in blocks]]),
        block_variable=ints([[x for _, x, _ in blocks]]),
        curve=ints([[before + place[name] for name in names]]),
        frame=ints([[number.get(load.body, len(number)) for load in loads]]),
        first=ints([first]),
        moves=ints([[body.moves for body in bodies]]),
        turns=ints([[body.turns for body in bodies]]),
        n_f=ints([n_f]),
        force=np.array([part.force for _, _, part in blocks], dtype).reshape(-1, 3),
        start=starts([len(part.moment) for _, _, part in blocks])[:-1],
        moment=np.concatenate([np.zeros((0, 9)), *(part.moment for _, _, part in blocks)]).astype(dtype),
        position_start=starts([len(places) for places in positions])[:-1],
        position=ints(positions),
    )
