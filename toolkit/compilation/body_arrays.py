"""Bodies as flat arrays: the constant part, and the bodies with a moving frame."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.constant_kernel import Constant
from toolkit.bodies.floating_kernel import Floating
from toolkit.compilation.arrays import ints, starts
from toolkit.compilation.numbering import Numbering
from toolkit.compilation.pattern import Pattern, block
from toolkit.compilation.quantities import Quantities


def constant_part(
    numbering: Numbering, values: Quantities, derivatives: list[Quantities], rows: list, pattern: Pattern, dtype: type
) -> Constant:
    """Mass, damping, stiffness and weight that never change; `rows` are the entries' global rows and columns, body by body."""

    def joined(source: Quantities, name: str) -> np.ndarray:
        return np.concatenate([np.asarray(getattr(part, name)) for part in source.constant])

    row = np.concatenate([r for r, _ in rows]).astype(np.int64)
    column = np.concatenate([c for _, c in rows]).astype(np.int64)
    kinds = ("mass", "damping", "stiffness")
    constants: list[np.ndarray] = [joined(values, kind).astype(dtype) for kind in kinds]
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
        constants[0],
        constants[1],
        constants[2],
        np.ascontiguousarray(joined(values, "force"), dtype),
        ints(entry),
        ints(variable),
        mass_x,
        damping_x,
        stiffness_x,
        np.ascontiguousarray(np.stack(force_x, axis=1)[:, 1:]),
    )


def floating_part(
    frames: list[int], values: Quantities, derivatives: list[Quantities], pattern: Pattern, dtype: type
) -> Floating:
    """Invariants of bodies with a moving frame and of their design derivatives; `frames` are the numbers of their r_x."""
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
        ints([[b for b, _, _ in blocks]]),
        ints([[x for _, x, _ in blocks]]),
        ints([frames]),
        ints([n_f]),
        np.array([part.mass for _, _, part in blocks], dtype),
        starts([len(part.moment) for _, _, part in blocks])[:-1],
        np.ascontiguousarray(np.concatenate([np.zeros((0, 2)), *(part.moment for _, _, part in blocks)]), dtype),
        starts([len(places[b][0]) for b, _, _ in blocks]),
        ints([places[b][0] for b, _, _ in blocks]),
        ints([places[b][1] for b, _, _ in blocks]),
        np.concatenate([np.zeros(0, dtype), *(part.inertia for _, _, part in blocks)]).astype(dtype),
        np.concatenate([np.zeros(0, dtype), *(part.gyroscopic for _, _, part in blocks)]).astype(dtype),
        ints(positions),
        starts([len(border) for border in borders])[:-1],
        ints(borders),
        np.asarray(values.gravity).astype(dtype),
        np.stack([np.zeros(2), *(derivative.gravity for derivative in derivatives)], axis=1)[:, 1:].copy(),
    )


def _changes(part) -> bool:
    return any(np.any(np.asarray(value) != 0) for value in (part.mass, part.moment, part.inertia, part.gyroscopic))
