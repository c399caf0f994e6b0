"""Bodies as flat arrays: the constant part, and the bodies with a moving frame."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from functools import partial

import numpy as np

from toolkit.components.bodies.body import ConstantNumbers, SpatialFloatingNumbers
from toolkit.components.bodies.chain_strains import Strains, no_strains
from toolkit.components.bodies.kernels.constant_kernel import Changes, ConstantTerms
from toolkit.components.bodies.kernels.planar_floating import Floating
from toolkit.foundation.itself import Itself
from toolkit.linear.linear_solver import Factored, FactoredChanges
from toolkit.system.numbering import Numbering, ints, starts
from toolkit.system.pattern import Pattern, block, square_size, stiff_entries
from toolkit.system.quantities import Quantities


def factored_bodies(values: Quantities, derivatives: list[Quantities]) -> set[int]:
    """Numbers of bodies whose stiffness has factors, and whose derivatives have them too: others keep their entries in both."""
    rows = {b: len(part.strains.weight) for b, part in values.constant.items()}
    rates = [(b, len(part.strains.weight)) for derivative in derivatives for b, part in derivative.constant.items()]
    return {b for b, count in rows.items() if count} - {b for b, count in rates if count != rows[b]}


def strain_arrays(
    numbering: Numbering, bodies: set[int], values: Quantities, derivatives: list[Quantities], dtype: type
) -> tuple[Factored, FactoredChanges]:
    """Factored stiffness of some bodies, one after the other, and its derivatives by the design."""
    first: list[int] = list(numbering.first.values())
    edges: dict[int, int] = {}
    every, count = [no_strains()], 0
    for b, part in ((b, part) for b, part in values.constant.items() if b in bodies):
        every.append(part.strains._replace(column=first[b] + part.strains.column))
        edges[b], count = count, count + len(part.strains.weight)
    column, value, weight = (np.concatenate(each) for each in zip(*every, strict=True))
    changed = [
        (x, edges[b], part.strains, np.flatnonzero(_strain_changes(part.strains)))
        for x, derivative in enumerate(derivatives)
        for b, part in derivative.constant.items()
        if b in bodies
    ]
    wide, none = value.shape[1], no_strains()
    change = FactoredChanges(
        row=ints([at + rows for _, at, _, rows in changed]),
        variable=ints([np.full(len(rows), x) for x, _, _, rows in changed]),
        start=wide * np.arange(sum(len(rows) for *_, rows in changed) + 1),
        value=np.concatenate([none.value.ravel(), *(part.value[rows].ravel() for _, _, part, rows in changed)]),
        weight=np.concatenate([none.weight, *(part.weight[rows] for _, _, part, rows in changed)]),
    )
    return _factored(column, value.astype(dtype), weight.astype(dtype)), change


def _factored(column: np.ndarray, value: np.ndarray, weight: np.ndarray) -> Factored:
    """Factored stiffness from rows of B with their columns and weights, with the columns of B too."""
    wide, columns, values = column.shape[1], column.ravel(), value.ravel()
    order = np.argsort(columns, kind="stable")
    felt, felt_start = np.unique(columns[order], return_index=True)
    return Factored(
        start=wide * np.arange(len(weight) + 1),
        column=columns.astype(np.uint32),
        value=values,
        weight=weight,
        felt=felt,
        felt_start=np.append(felt_start, len(order)),
        felt_row=(order // wide).astype(np.uint32),
        felt_value=values[order],
    )


def _strain_changes(rates: Strains) -> np.ndarray:
    """Which rows have a derivative, (n_rows,) bools."""
    found: np.ndarray = (rates.weight != 0) | np.any(rates.value != 0, axis=1)
    return found


def constant_part(
    numbering: Numbering,
    values: Quantities,
    derivatives: list[Quantities],
    rows: list,
    pattern: Pattern,
    dtype: type,
    weights: np.ndarray,
    kept: ConstantTerms | None = None,
) -> ConstantTerms:
    """Mass, damping, stiffness and weight that never change; `rows` are the entries' global rows and columns, body by body.

    `weights` (n,) make coordinates comparable, see `numbering.weights`; `kept` is what it is at other numbers.
    """
    parts = list(values.constant.values())

    def joined(name: str) -> np.ndarray:
        return np.concatenate([np.asarray(getattr(part, name)) for part in parts]).astype(dtype)

    counts = [len(part.row) for part in parts]
    body = np.repeat(np.arange(len(counts)), counts)
    places = _places(parts, rows, pattern) if kept is None else {name: getattr(kept, name) for name in PLACES}
    row, column, first_entry = places["row"], places["column"], places["segment_start"]
    mass, damping, stiffness = map(joined, ("mass", "damping", "stiffness"))
    bodies = factored_bodies(values, derivatives)
    factored = np.repeat([b in bodies for b in values.constant], counts)
    on_pattern = partial(_on_pattern, pattern, places["position"])
    change = partial(_changes_of, numbering.runs, derivatives, first_entry, row, column)
    force_row, force_variable, design_force = _changes_of_forces(numbering, derivatives)
    strains, design_strains = strain_arrays(numbering, bodies, values, derivatives, dtype)
    return ConstantTerms(
        **places,
        segment_damped=(np.bincount(body, (mass != 0) | (damping != 0), len(counts)) > 0).astype(np.int64),
        segment_loose=(np.bincount(body, ~factored | (damping != 0), len(counts)) > 0).astype(np.int64),
        mass=mass,
        damping=damping,
        stiffness=stiffness,
        M=on_pattern(mass),
        D=on_pattern(damping),
        K=on_pattern(stiffness),
        **stiff_entries(row, column, np.where(factored, 0, stiffness), weights, body, len(counts))._asdict(),
        strains=strains,
        design_strains=design_strains,
        strained=on_pattern(np.where(factored, stiffness, 0)) if np.any(factored) else np.zeros(0, dtype),
        loose=on_pattern(np.where(factored, 0, stiffness)),
        force=joined("force"),
        design_mass=change("mass"),
        design_damping=change("damping"),
        design_stiffness=change("stiffness"),
        design_loose=change("stiffness", [b for b in values.constant if b not in bodies]),
        force_row=force_row,
        force_variable=force_variable,
        design_force=design_force,
    )


PLACES = ("segment_start", "segment_size", "row", "column", "position")
"""Arrays that no number of the scene changes."""


def _places(parts: list[ConstantNumbers], rows: list, pattern: Pattern) -> dict[str, np.ndarray]:
    row, column = (np.concatenate(each).astype(np.int64) for each in zip(*rows, strict=True))
    sizes, position = [square_size(part.row, part.column) for part in parts], pattern.find(row, column)
    found = starts([len(part.row) for part in parts]), ints([sizes]), row.astype(np.uint32), column.astype(np.uint32), position
    return dict(zip(PLACES, found, strict=True))


def _on_pattern(pattern: Pattern, position: np.ndarray, entries: np.ndarray) -> np.ndarray:
    """Entries of a matrix at their places among all that are stored; empty if it has none."""
    found = np.zeros(len(pattern.indices) if len(entries) else 0, entries.dtype)
    np.add.at(found, position, entries)
    return found


def _changes_of(
    known: dict[Hashable, Changes],
    derivatives: list[Quantities],
    first_entry: np.ndarray,
    row: np.ndarray,
    column: np.ndarray,
    name: str,
    bodies: list[int] | None = None,
) -> Changes:
    """Changes of one matrix of all or some bodies, without the derivatives that are zero.

    Entries are body by body and row by row; `known` are from other numbers.
    """
    parts = [
        (x, b, getattr(part, name))
        for x, derivative in enumerate(derivatives)
        for b, part in derivative.constant.items()
        if bodies is None or b in bodies
    ]
    entry, variable, value = _not_zero([(first_entry[b], x, change) for x, b, change in parts])
    key = Itself(row), entry.tobytes(), variable.tobytes()
    if key not in known:
        known[key] = _runs(entry, variable, row, column)
    return known[key]._replace(value=value)


def _runs(entry: np.ndarray, variable: np.ndarray, row: np.ndarray, column: np.ndarray) -> Changes:
    """Changes without their values: runs of entries, each of one row by one variable."""
    rows = row[entry].astype(np.int64)
    begins = np.ones(len(entry), bool)
    begins[1:] = (rows[1:] != rows[:-1]) | (variable[1:] != variable[:-1])
    first = np.flatnonzero(begins)
    return Changes(rows[first], variable[first], np.append(first, len(entry)), column[entry], np.zeros(0))


def _changes_of_forces(numbering: Numbering, derivatives: list[Quantities]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinate, variable and derivative of the constant forces that change."""
    first = list(numbering.first.values())
    parts = [(x, b, part.force) for x, derivative in enumerate(derivatives) for b, part in derivative.constant.items()]
    return _not_zero([(first[b], x, change) for x, b, change in parts])


def _not_zero(parts: list[tuple[int, int, np.ndarray]]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Place, variable and value of what is not zero in arrays with the place of their first number and their variable."""
    found = [(first, x, change, np.flatnonzero(change)) for first, x, change in parts]
    place = ints([first + at for first, _, _, at in found])
    variable = np.repeat(ints([[x for _, x, _, _ in found]]), [len(at) for *_, at in found])
    return place, variable, np.concatenate([np.zeros(0), *(change[at] for _, _, change, at in found)])


def floating_part(first: list[int], values: Quantities, derivatives: list[Quantities], pattern: Pattern, dtype: type) -> Floating:
    """Invariants of bodies with a moving frame and of their design derivatives; `first` are the numbers of the first coordinates of all."""
    frames = [first[b] for b in values.floating]
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


def drag_alone(values: Quantities, derivatives: list[Quantities]) -> tuple[Quantities, list[Quantities]]:
    """Quantities with the drag in the place of the invariants, and without gravity; no bodies if none is damped by its mass."""
    damped = any(len(part.row) for part in values.drag.values())
    kept = values.floating if damped else {}
    drag = {b: values.drag[b] if b in values.drag else part.times(0.0) for b, part in kept.items()}
    still = 0 * values.gravity
    rates = [replace(each, floating=each.drag if damped else {}, gravity=0 * each.gravity) for each in derivatives]
    return replace(values, floating=drag, gravity=still), rates


def stiffened_entries(part: SpatialFloatingNumbers) -> np.ndarray:
    """Numbers of the entries of a body's matrices that a spin stiffens, (n,)."""
    return np.flatnonzero((part.row > 0) & (part.column > 0)) if np.ndim(part.stiffening) else np.zeros(0, np.int64)


def _changes(part) -> bool:
    every = (part.mass, part.moment, part.inertia, part.gyroscopic, part.stiffening)
    return any(np.any(np.asarray(value) != 0) for value in every)
