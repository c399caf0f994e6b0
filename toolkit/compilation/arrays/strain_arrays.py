"""Stiffness in its factors as flat arrays, with their derivatives by the design."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.chain_strains import Strains, no_strains
from toolkit.compilation.conversions import ints
from toolkit.compilation.numbering import Numbering
from toolkit.compilation.quantities import Quantities
from toolkit.linear.linear_solver import Factored, FactoredChanges


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
        (x, edges[b], part.strains, np.flatnonzero(_changes(part.strains)))
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


def _changes(rates: Strains) -> np.ndarray:
    """Which rows have a derivative, (n_rows,) bools."""
    found: np.ndarray = (rates.weight != 0) | np.any(rates.value != 0, axis=1)
    return found
