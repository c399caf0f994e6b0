"""Joints as flat arrays, in the plane and in space."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from toolkit.compilation.arrays.component_arrays import curve_numbers, designed, gripped, parameter_changes
from toolkit.compilation.conversions import ints, starts
from toolkit.compilation.joint_forms import felt
from toolkit.compilation.numbering import Numbering
from toolkit.compilation.patterns.pattern import Pattern, block
from toolkit.compilation.quantities import Quantities
from toolkit.joints.joint import Joint, check_rows
from toolkit.joints.kernels.laws import ANGLE, PLAIN, PROFILE, angle_law
from toolkit.joints.kernels.profile import profile_law
from toolkit.joints.kernels.records import (
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
from toolkit.joints.rows import Row, forms_of
from toolkit.scene.resolution import ResolvedScene
from toolkit.scene.space import PLANE

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
    kept: Joints | None = None,
) -> Joints:
    """Joints of the scene as forms, with the places of their local entries in the pattern; `kept` is what they are at other numbers."""
    joints: list[Joint] = list(scene.joints.values())
    for joint in joints if kept is None else ():
        check_rows(joint, scene)
    changes, forms = parameter_changes([d.joints for d in derivatives], len(joints)), numbering.forms
    given = forms.numbers(np.concatenate([np.zeros(0), *values.joints.values()]), dtype)
    ends = starts([len(found) for found in changes])
    if kept is not None:
        of = kept.of.copy()
        of[:, DESIGNED] = designed(list(kept.marker), derivatives, changes, kept.curve)
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
            designed(markers, derivatives, changes, curves),
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
            own = {None: PLAIN, angle_law: ANGLE, profile_law: PROFILE}
            found[j, i] = own[row.law] if row.law in own else known.index(row.law), len(row.forms)
    return found.reshape(len(rows), 2 * most)
