"""Forms of joints as the compiled loop has them: terms of the plane or of space, and where each number of a form stands in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from toolkit.compilation.conversions import ints, starts
from toolkit.joints.kernels.records import CONSTANT, LINEAR, PAIR
from toolkit.joints.rows import BETWEEN, Form, Row, forms_of


@dataclass(frozen=True)
class Terms:
    """Structure of a form: places of its linear terms, its pairs, and of each of its numbers (kind, which one, which value, sign)."""

    linear: list[int]
    pairs: list[tuple[int, int]]
    slots: list[tuple[int, int, int, float]]


def spatial_terms(form: Form) -> Terms:
    """Pairs of vectors as they are."""
    pairs = [(i, k) for i, k, _ in form.pairs]
    return Terms(_places(form), pairs, [*_slots(form), *((PAIR, e, 0, 1.0) for e in range(len(pairs)))])


def planar_terms(form: Form) -> Terms:
    """Products with both axes of a marker are one pair with two values, see `joints.kernels.planar.joint_kernel`."""
    found = [_planar_pair(*sorted((i, k))) for i, k, _ in form.pairs]
    pairs = list(dict.fromkeys(pair for pair, _, _ in found))
    return Terms(_places(form), pairs, [*_slots(form), *((PAIR, pairs.index(pair), v, sign) for pair, v, sign in found)])


def _places(form: Form) -> list[int]:
    return [place for place, _ in form.linear]


def _slots(form: Form) -> list[tuple[int, int, int, float]]:
    """Of the constant and of the linear terms."""
    return [(CONSTANT, 0, 0, 1.0), *((LINEAR, e, 0, 1.0) for e in range(len(form.linear)))]


def _planar_pair(i: int, k: int) -> tuple[tuple[int, int], int, float]:
    """Pair, which of its two values, and sign of the product of vectors i <= k (r, e_1, e_2 of a and of b)."""
    (side, first), (other, second) = divmod(i, 3), divmod(k, 3)
    if first == 0 and second == 0:
        return (i, k), 0, 1.0
    if k == BETWEEN:
        return ((k, k), 0, 1.0) if i == BETWEEN else ((k, 3 * side + 2), first - 1, 1.0)
    if first == 0 or second == 0:
        at, of, axis = (i, other, second) if first == 0 else (k, side, first)
        return (at, 3 * of + 2), axis - 1, 1.0
    pair = (3 * side + 2, 3 * other + 2)
    return (pair, 0, 1.0) if first == second else (pair, 1, 1.0 if first == 1 else -1.0)


def form_numbers(terms: list[Terms], numbers: np.ndarray, dtype: type) -> dict[str, np.ndarray]:
    """Places and values of all forms, these from the numbers of all joints."""
    start = form_starts(terms)
    place: list[int] = []
    for each in terms:
        place += [0, *each.linear, *(vector for pair in each.pairs for vector in pair)]
    value: np.ndarray = np.zeros(len(place), dtype)
    slots = [(first, pairs, slot) for (first, pairs), each in zip(start, terms, strict=False) for slot in each.slots]
    for number, (first, pairs, slot) in zip(numbers, slots, strict=True):
        at, v, sign = _place(first, pairs, slot)
        value[at + v] += sign * number
    return {"start": start, "place": ints([place]), "value": value}


def form_starts(terms: list[Terms]) -> np.ndarray:
    """Place of the constant and of the first pair of every form, (n_forms + 1, 2)."""
    first = starts([1 + len(each.linear) + 2 * len(each.pairs) for each in terms])
    return np.column_stack([first, first + np.array([1 + len(each.linear) for each in terms] + [0])])


def _place(first: int, pairs: int, slot: tuple[int, int, int, float]) -> tuple[int, int, float]:
    """Where a number's term begins, which value of it, and the sign."""
    kind, e, v, sign = slot
    return {CONSTANT: first, LINEAR: first + 1 + e, PAIR: pairs + 2 * e}[kind], v, sign


def felt(rows: list[tuple[Row, ...]], most: int) -> dict[str, Any]:
    """Vectors in space that every row feels, `most` lists for every joint; nothing in the plane."""
    if not most:
        return {"felt_start": None, "felt": None}
    found: list[list[int]] = []
    for each in rows:
        for i in range(most):
            forms = forms_of(each[i : i + 1])
            vectors = {place // 3 for form in forms for place, _ in form.linear}
            found.append(sorted(vectors | {vector for form in forms for pair in form.pairs for vector in pair[:2]}))
    return {"felt_start": starts([len(vectors) for vectors in found]), "felt": ints(found)}


def number_changes(rows: list[tuple[Row, ...]], terms: list[Terms], changes: list) -> dict[str, np.ndarray]:
    """Start, places and derivative of every number of a form that a variable changes, see `Joints`."""
    table: list[tuple[int, ...]] = []
    values, start, before = [], form_starts(terms), 0
    for each, found in zip(rows, changes, strict=True):
        owners = [(i, f) for i, row in enumerate(each) for f in range(len(row.forms))]
        slots = [(at, before + n, slot) for n, at in enumerate(owners) for slot in terms[before + n].slots]
        for x, number, value in found:
            owner, form, slot = slots[number]
            at, v, sign = _place(start[form, 0], start[form, 1], slot)
            table.append((x, *owner, slot[0], at))
            values.append(sign * value * np.eye(2)[v])
        before += len(owners)
    return {
        "design": np.array(table, np.int64).reshape(-1, 5),
        "design_value": np.array(values, float).reshape(-1, 2),
    }
