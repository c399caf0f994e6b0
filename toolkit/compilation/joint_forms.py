"""Forms of joints as the compiled loop has them: terms of the plane or of space, and where each number of a form stands in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from toolkit.compilation.conversions import ints, starts
from toolkit.joints.joint import Joint
from toolkit.joints.kernels.records import CONSTANT, LINEAR, PAIR
from toolkit.joints.rows import BETWEEN, Form, Row, forms_of


@dataclass(frozen=True)
class Terms:
    """Structure of a form: places of its linear terms, its pairs, and of each of its numbers (kind, which one, which value, sign)."""

    linear: list[int]
    pairs: list[tuple[int, int]]
    slots: list[tuple[int, int, int, float]]


def spatial_terms(form: Form) -> Terms:
    """Structure of a form in space, whose pairs of vectors stay as they are."""
    pairs = [(i, k) for i, k, _ in form.pairs]
    return Terms(_places(form), pairs, [*_slots(form), *((PAIR, e, 0, 1.0) for e in range(len(pairs)))])


def planar_terms(form: Form) -> Terms:
    """Structure of a form in the plane.

    Products with both axes of a marker are one pair with two values, see `joints.kernels.planar_joint`.
    """
    found = [_planar_pair(*sorted((i, k))) for i, k, _ in form.pairs]
    pairs = list(dict.fromkeys(pair for pair, _, _ in found))
    return Terms(_places(form), pairs, [*_slots(form), *((PAIR, pairs.index(pair), v, sign) for pair, v, sign in found)])


def _places(form: Form) -> list[int]:
    return [place for place, _ in form.linear]


def _slots(form: Form) -> list[tuple[int, int, int, float]]:
    """Places of a form's constant and linear terms: (kind, which one, which value, sign) of each."""
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


@dataclass(frozen=True)
class JointForms:
    """Forms of all joints of a scene, and where each of their numbers stands; the same at all numbers of the scene.

    Attributes
    ----------
    rows
        Of every joint, with any values.
    start, place
        See `Joints`.
    at, sign
        Place of each number in `Joints.value`, and what it is multiplied by there.
    owner
        Row of the joint, form of the row, kind, place of the term and which of its values each number is.
    first
        Of each joint's numbers, and how many there are.
    """

    rows: list[tuple[Row, ...]]
    start: np.ndarray
    place: np.ndarray
    at: np.ndarray
    sign: np.ndarray
    owner: list[tuple[int, int, int, int, int]]
    first: np.ndarray

    def numbers(self, given: np.ndarray, dtype: type) -> dict[str, np.ndarray]:
        """Arrays of the places and values of all forms, the values from the numbers of all joints."""
        value: np.ndarray = np.zeros(len(self.place), dtype)
        np.add.at(value, self.at, self.sign * given)
        return {"start": self.start, "place": self.place, "value": value}

    def changes(self, changes: list[list[tuple[int, int, float]]]) -> dict[str, np.ndarray]:
        """Arrays of the place and derivative of every number of a form that a variable changes, see `Joints`.

        `changes` are (variable, number, derivative) by joint.
        """
        found = [(x, self.first[j] + number, value) for j, each in enumerate(changes) for x, number, value in each]
        table = [(x, *self.owner[n][:4]) for x, n, _ in found]
        values = [self.sign[n] * value * UNITS[self.owner[n][4]] for _, n, value in found]
        return {
            "design": np.array(table, np.int64).reshape(-1, 5),
            "design_value": np.array(values, float).reshape(-1, 2),
        }


PLANE, UNITS = 2, np.eye(2)


def joint_forms(joints: Sequence[Joint]) -> JointForms:
    """Forms of joints, in the plane or in space, with the places of their numbers."""
    planar = all(joint.dimension == PLANE for joint in joints)
    rows = [tuple(joint.constraint(None)) for joint in joints]
    terms = [planar_terms(form) if planar else spatial_terms(form) for each in rows for form in forms_of(each)]
    start, place, owner, signs = form_starts(terms), list[int](), list[tuple[int, int, int, int, int]](), list[float]()
    for each in terms:
        place += [0, *each.linear, *(vector for pair in each.pairs for vector in pair)]
    forms = [(i, f) for each in rows for i, row in enumerate(each) for f in range(len(row.forms))]
    for (i, f), (first, pairs), own in zip(forms, start, terms, strict=False):
        for slot in own.slots:
            term, v, sign = _place(first, pairs, slot)
            owner.append((i, f, slot[0], int(term), v))
            signs.append(sign)
    counts = [sum(len(form.numbers) for form in forms_of(each)) for each in rows]
    at = ints([[term + v for *_, term, v in owner]])
    return JointForms(rows, start, ints([place]), at, np.array(signs, float), owner, starts(counts))


def form_starts(terms: list[Terms]) -> np.ndarray:
    """Place of the constant and of the first pair of every form, (n_forms + 1, 2)."""
    first = starts([1 + len(each.linear) + 2 * len(each.pairs) for each in terms])
    return np.column_stack([first, first + np.array([1 + len(each.linear) for each in terms] + [0])])


def _place(first: int, pairs: int, slot: tuple[int, int, int, float]) -> tuple[int, int, float]:
    """Place where a number's term begins, which of its values the number is, and its sign."""
    kind, e, v, sign = slot
    return {CONSTANT: first, LINEAR: first + 1 + e, PAIR: pairs + 2 * e}[kind], v, sign


def felt(rows: list[tuple[Row, ...]], most: int) -> dict[str, Any]:
    """Arrays of the vectors in space that every row feels, `most` lists for every joint; None in the plane."""
    if not most:
        return {"felt_start": None, "felt": None}
    found: list[list[int]] = []
    for each in rows:
        for i in range(most):
            forms = forms_of(each[i : i + 1])
            vectors = {place // 3 for form in forms for place, _ in form.linear}
            found.append(sorted(vectors | {vector for form in forms for pair in form.pairs for vector in pair[:2]}))
    return {"felt_start": starts([len(vectors) for vectors in found]), "felt": ints(found)}
