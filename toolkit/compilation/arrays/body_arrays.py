"""Bodies as flat arrays: the constant part, and the bodies with a moving frame."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.bodies.kernels.constant_kernel import Constant
from toolkit.bodies.kernels.planar.floating_kernel import Floating
from toolkit.compilation.conversions import ints, starts
from toolkit.compilation.numbering import Numbering
from toolkit.compilation.patterns.common_pattern import square_size
from toolkit.compilation.patterns.pattern import Pattern, block
from toolkit.compilation.patterns.stiff_entries import stiff_entries
from toolkit.compilation.quantities import Quantities


def constant_part(
    numbering: Numbering,
    values: Quantities,
    derivatives: list[Quantities],
    rows: list,
    pattern: Pattern,
    dtype: type,
    weights: np.ndarray,
) -> Constant:
    """Mass, damping, stiffness and weight that never change; `rows` are the entries' global rows and columns, body by body.

    `weights` (n,) make coordinates comparable, see `numbering.weights`.
    """

    def joined(name: str) -> np.ndarray:
        return np.concatenate([np.asarray(getattr(part, name)) for part in values.constant.values()])

    row = np.concatenate([r for r, _ in rows]).astype(np.int64)
    column = np.concatenate([c for _, c in rows]).astype(np.int64)
    counts = [len(r) for r, _ in rows]
    entries, forces = _constant_changes(numbering, derivatives, starts(counts))
    stiffness: np.ndarray = joined("stiffness").astype(dtype)
    soft, stiff_row, stiff_start, stiff_column, stiff_high, stiff_low = stiff_entries(row, column, stiffness, weights, counts)
    sizes = [square_size(part.row, part.column) for part in values.constant.values()]
    damped = [np.any(np.asarray(part.mass) != 0) or np.any(np.asarray(part.damping) != 0) for part in values.constant.values()]
    return Constant(
        segment_start=starts(counts),
        segment_size=ints([sizes]),
        segment_damped=ints([damped]),
        row=row,
        column=column,
        position=pattern.find(row, column),
        mass=joined("mass").astype(dtype),
        damping=joined("damping").astype(dtype),
        stiffness=stiffness,
        soft=soft,
        stiff_row=stiff_row,
        stiff_start=stiff_start,
        stiff_column=stiff_column,
        stiff_high=stiff_high,
        stiff_low=stiff_low,
        force=np.ascontiguousarray(joined("force"), dtype),
        design_entry=entries[0].astype(np.int64),
        design_variable=entries[1].astype(np.int64),
        design_mass=entries[2].copy(),
        design_damping=entries[3].copy(),
        design_stiffness=entries[4].copy(),
        force_row=forces[0].astype(np.int64),
        force_variable=forces[1].astype(np.int64),
        design_force=forces[2].copy(),
    )


def _constant_changes(
    numbering: Numbering, derivatives: list[Quantities], first_entry: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What is not zero: rows (entry, variable, dM, dD, dK) and (coordinate, variable, df)."""
    first = list(numbering.first.values())
    entries, forces = [np.zeros((5, 0))], [np.zeros((3, 0))]
    for x, derivative in enumerate(derivatives):
        for b, part in derivative.constant.items():
            change = np.stack([part.mass, part.damping, part.stiffness])
            changed, moved = np.flatnonzero(np.any(change != 0, axis=0)), np.flatnonzero(part.force)
            entries.append(np.vstack([first_entry[b] + changed, np.full(len(changed), x), change[:, changed]]))
            forces.append(np.vstack([first[b] + moved, np.full(len(moved), x), part.force[moved]]))
    return np.concatenate(entries, axis=1), np.concatenate(forces, axis=1)


def floating_part(
    frames: list[int], values: Quantities, derivatives: list[Quantities], pattern: Pattern, dtype: type
) -> Floating:
    """Invariants of bodies with a moving frame and of their design derivatives; `frames` are the numbers of their r_x."""
    bodies, number = list(values.floating.values()), {b: k for k, b in enumerate(values.floating)}
    blocks = [(k, -1, part) for k, part in enumerate(bodies)]
    places = {k: (part.row, part.column) for k, part in enumerate(bodies)}
    for x, derivative in enumerate(derivatives):
        blocks += [(number[b], x, part) for b, part in derivative.floating.items() if _changes(part)]
    falling = [x for x, derivative in enumerate(derivatives) if np.any(derivative.gravity != 0)]
    n_f = [len(part.moment) - 1 for part in bodies]
    inside = {k: stiffened_entries(part) for k, part in enumerate(bodies)}
    stiffened = [
        pattern.find(frame + 2 + part.row[e], frame + 2 + part.column[e])
        for frame, part, e in zip(frames, bodies, inside.values(), strict=True)
    ]
    positions, borders = [], []
    for frame, part, n in zip(frames, bodies, n_f, strict=True):
        positions.append(pattern.find(frame + 2 + part.row, frame + 2 + part.column))
        local = frame + np.arange(3 + n)
        borders.append(np.concatenate([pattern.find(*block(local[:3], local)), pattern.find(*block(local[3:], local[:3]))]))
    return Floating(
        block_body=ints([[b for b, _, _ in blocks]]),
        block_variable=ints([[x for _, x, _ in blocks]]),
        frame=ints([frames]),
        n_f=ints([n_f]),
        mass=np.array([part.mass for _, _, part in blocks], dtype),
        moment_start=starts([len(part.moment) for _, _, part in blocks])[:-1],
        moment=np.ascontiguousarray(np.concatenate([np.zeros((0, 2)), *(part.moment for _, _, part in blocks)]), dtype),
        entry_start=starts([len(places[b][0]) for b, _, _ in blocks]),
        entry_row=ints([places[b][0] for b, _, _ in blocks]),
        entry_column=ints([places[b][1] for b, _, _ in blocks]),
        inertia=np.concatenate([np.zeros(0, dtype), *(part.inertia for _, _, part in blocks)]).astype(dtype),
        gyroscopic=np.concatenate([np.zeros(0, dtype), *(part.gyroscopic for _, _, part in blocks)]).astype(dtype),
        entry_position=ints(positions),
        stiffened_start=starts([len(inside[b]) for b, _, _ in blocks]),
        stiffened_row=ints([bodies[b].row[inside[b]] for b, _, _ in blocks]),
        stiffened_column=ints([bodies[b].column[inside[b]] for b, _, _ in blocks]),
        stiffening=np.concatenate(
            [np.zeros(0, dtype), *(part.stiffening[inside[b]] for b, _, part in blocks if len(inside[b]))]
        ).astype(dtype),
        stiffened_position=ints(stiffened),
        border_start=starts([len(border) for border in borders])[:-1],
        border=ints(borders),
        gravity=np.asarray(values.gravity).astype(dtype),
        gravity_variable=ints([falling]),
        design_gravity=np.array([derivatives[x].gravity for x in falling], float).reshape(-1, 2),
    )


def stiffened_entries(part: Any) -> np.ndarray:
    """Those among the entries of a body's matrices that a spin stiffens, (n,) numbers."""
    return np.flatnonzero((part.row > 0) & (part.column > 0)) if np.ndim(part.stiffening) else np.zeros(0, np.int64)


def _changes(part) -> bool:
    every = (part.mass, part.moment, part.inertia, part.gyroscopic, part.stiffening)
    return any(np.any(np.asarray(value) != 0) for value in every)
