"""Numbering of a scene: which unknown is whose. It depends on the scene's structure alone, never on its numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from toolkit.components.bodies.body import QUATERNION
from toolkit.components.joints.joint import Joint
from toolkit.components.joints.kernels.records import CONSTANT, LINEAR, PAIR
from toolkit.components.joints.rows import BETWEEN, ROW_QUANTITIES, Form, Row, forms_of
from toolkit.components.loads.load import Load
from toolkit.components.markers.component import Component
from toolkit.foundation.errors import InputError
from toolkit.scene.resolution import ResolvedScene
from toolkit.scene.scene import Scene
from toolkit.system.dependence import Affected, Item, affected_by, users_by_name


def ints(parts: list) -> np.ndarray:
    """Lists of whole numbers, one after the other."""
    return np.concatenate([np.zeros(0, np.int64), *(np.asarray(part, np.int64) for part in parts)])


def starts(lengths: list[int]) -> np.ndarray:
    """Start of each block, and the end of the last, from the lengths of the blocks."""
    return np.concatenate([[0], np.cumsum(np.asarray(lengths, np.int64))]).astype(np.int64)


@dataclass(frozen=True)
class FormTerms:
    """Structure of a form: places of its linear terms, its pairs, and of each of its numbers (kind, which one, which value, sign)."""

    linear: list[int]
    pairs: list[tuple[int, int]]
    slots: list[tuple[int, int, int, float]]


def spatial_terms(form: Form) -> FormTerms:
    """Structure of a form in space, whose pairs of vectors stay as they are."""
    pairs = [(i, k) for i, k, _ in form.pairs]
    return FormTerms(_places(form), pairs, [*_slots(form), *((PAIR, e, 0, 1.0) for e in range(len(pairs)))])


def planar_terms(form: Form) -> FormTerms:
    """Structure of a form in the plane.

    Products with both axes of a marker are one pair with two values, see `joints.kernels.planar_joint`.
    """
    found = [_planar_pair(*sorted((i, k))) for i, k, _ in form.pairs]
    pairs = list(dict.fromkeys(pair for pair, _, _ in found))
    return FormTerms(_places(form), pairs, [*_slots(form), *((PAIR, pairs.index(pair), v, sign) for pair, v, sign in found)])


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


def form_starts(terms: list[FormTerms]) -> np.ndarray:
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


@dataclass(frozen=True)
class Numbering:
    """Places of bodies among the coordinates, of joints among the multipliers, and the list of markers.

    Attributes
    ----------
    first
        Body -> number of its first coordinate; then path of a load with a state of its own -> number of that.
    row
        Joint -> number of its first multiplier among all unknowns.
    length
        Body -> number of the multiplier of its quaternion's length.
    markers
        (body, point) in the order of the marker arrays; a third entry is the path of the component whose axes it has.
    names
        What each unknown is, for messages.
    seen
        Markers that a response looks at.
    users
        Name -> items that name it, see `users_by_name`.
    joints
        The joints at any numbers, in the order of their rows.
    """

    first: dict[str, int]
    row: dict[str, int]
    length: dict[str, int]
    markers: tuple[tuple[str, ...], ...]
    names: tuple[str, ...]
    n_q: int
    seen: tuple[tuple[str, str], ...] = ()
    users: dict[str, list[Item]] = field(default_factory=dict)
    joints: tuple[Joint, ...] = ()

    @cached_property
    def forms(self) -> JointForms:
        """Forms of all joints of the scene."""
        return joint_forms(self.joints)

    def affected_by(self, scene: ResolvedScene, paths: Sequence[str]) -> Affected:
        """Items and markers that the numbers at some paths may change, in this scene at any numbers."""
        if (key := tuple(paths)) not in self._affected:
            self._affected[key] = affected_by(scene, self.markers, list(paths), self.users)
        return self._affected[key]

    @cached_property
    def _affected(self) -> dict[tuple[str, ...], Affected]:
        return {}

    @cached_property
    def row_lengths(self) -> np.ndarray:
        """Lengths that rows of joints, and the lengths of quaternions, are compared with: 1 for a length, nan for an angle."""
        rows = [np.nan if row.quantity == "angle" else 1.0 for each in self.forms.rows for row in each]
        return np.array([*rows, *(np.nan for _ in self.length)])

    @cached_property
    def runs(self) -> dict[Any, Any]:
        """Store of what `body_arrays` has found out about entries that are not zero in derivatives of the bodies' matrices."""
        return {}

    @cached_property
    def owners(self) -> dict[Affected | None, Any]:
        """Store of what `quantities.owners_of` has found."""
        return {}

    @property
    def n(self) -> int:
        """Number of unknowns, coordinates and multipliers."""
        return len(self.names)

    def marker(self, grip: tuple[str, ...]) -> int:
        """Number of the marker of a body at a point."""
        return self._numbers[grip]

    @cached_property
    def _numbers(self) -> dict[tuple[str, ...], int]:
        return {grip: m for m, grip in enumerate(self.markers)}

    @cached_property
    def states(self) -> np.ndarray:
        """Numbers of the coordinates that are states of loads."""
        return np.array([first for owner, first in self.first.items() if "." in owner], np.int64)

    def bodies_of(self, unknowns: np.ndarray) -> list[str]:
        """Bodies that have some of the unknowns as coordinates."""
        return [owner for owner in _owners(self.first, self.n_q, unknowns) if "." not in owner]

    def joints_of(self, unknowns: np.ndarray) -> list[str]:
        """Joints that have some of the unknowns as forces."""
        return _owners(self.row, min(self.length.values(), default=self.n), unknowns)


def _owners(first: dict[str, int], end: int, unknowns: np.ndarray) -> list[str]:
    """Names of the owners of some of the given unknowns; an owner's unknowns go from its first to the next one's."""
    edges = [*first.values(), end]
    return [
        name for name, low, high in zip(first, edges, edges[1:], strict=False) if np.any((low <= unknowns) & (unknowns < high))
    ]


def grips_of(path: str, component: Component) -> list[tuple[str, ...]]:
    """Markers of a component: (body, point), and its path if they have axes of its own."""
    own = () if component.axes is None else (path,)
    return [(*grip, *own) for grip in component.grips]


def number(scene: ResolvedScene, extra_markers: tuple[tuple[str, str], ...] = ()) -> Numbering:
    """Number the unknowns: bodies as in the scene, rows of joints, lengths of quaternions; `extra_markers` carry no component.

    Raises
    ------
    InputError
        A joint has more rows than a joint can have, or a row measures neither a length nor an angle.
    """
    names: list[str] = []
    first, row, length = {}, {}, {}
    for name, body in scene.all_bodies().items():
        first[name] = len(names)
        names += [f"{coordinate} of body {name!r}" for coordinate in body.coordinate_names(scene)]
    for path in _with_state(scene):
        first[path] = len(names)
        names.append(f"state of load {path.partition('.')[2]!r}")
    n_q = len(names)
    for name, joint in scene.joints.items():
        row[name] = len(names)
        if len(joint.rows) > scene.space.joint_rows:
            raise InputError(
                f"joint {name!r} has {len(joint.rows)} rows, a joint has at most {scene.space.joint_rows}. Split it into two."
            )
        for direction, quantity in joint.rows:
            if quantity not in ROW_QUANTITIES:
                raise InputError(
                    f"row {direction!r} of joint {name!r} measures {quantity!r}; a row is one of: {', '.join(ROW_QUANTITIES)}. Say which "
                    f"beside its name, in the class {type(joint).__name__}."
                )
        names += [f"{direction} of joint {name!r}" for direction in joint.row_names]
    for name in scene.pieces():
        if scene.body(name).turns == QUATERNION:
            length[name] = len(names)
            names.append(f"length of the quaternion of body {name!r}")
    loads = {f"loads.{name}": load for name, load in scene.loads.items() if isinstance(load, Load)}
    components: dict[str, Component] = {**{f"joints.{name}": joint for name, joint in scene.joints.items()}, **loads}
    grips = [grip for path, component in components.items() for grip in grips_of(path, component)]
    markers = tuple(dict.fromkeys([*grips, *extra_markers]))
    return Numbering(
        first, row, length, markers, tuple(names), n_q, tuple(extra_markers), users_by_name(scene), tuple(scene.joints.values())
    )


def _with_state(scene: Scene) -> dict[str, Load]:
    """Loads that have a state of their own, by their paths."""
    return {f"loads.{name}": load for name, load in scene.loads.items() if isinstance(load, Load) and load.state is not None}


def weights(scene: ResolvedScene, numbering: Numbering) -> np.ndarray:
    """Weights that make the unknowns comparable, (n,): displacement over the model size, or angle; free of units.

    For a coordinate it scales its change, for a multiplier the violation of its constraint row; states of loads are integrals over time,
    which all systems of units count in seconds.
    """
    states = [np.nan if load.state == "angle" else 1.0 for load in _with_state(scene).values()]
    bodies = [np.real(body.coordinate_lengths(scene)) for body in scene.all_bodies().values()]
    lengths = np.concatenate([*bodies, states, numbering.row_lengths])
    return np.where(np.isnan(lengths), 1.0, lengths / scene.size)
