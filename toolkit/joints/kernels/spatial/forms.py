"""Rows that spatial joints are made of: quadratic forms of the poses of two markers, see `joint_kernel`.

Each pose has a position r and three axes e_1, e_2, e_3; in the undeformed configuration the axes of both markers are the same.
"""

from __future__ import annotations

from typing import Any, Literal, NamedTuple


class Form(NamedTuple):
    """constant + sum value * number + sum value * (vector . vector); numbers 0 ... 23 and vectors 0 ... 7 of both poses."""

    constant: Any = 0.0
    linear: tuple[tuple[int, Any], ...] = ()
    pairs: tuple[tuple[int, int, Any], ...] = ()


class Row(NamedTuple):
    """One constraint: form = 0; with `sine` the angle atan2(sine, form) = 0. A time curve is subtracted from a joint's last row.

    `quantity` says whether the row is a "length" or an "angle", in which the cosine of two axes that are normal to each other counts.
    """

    name: str
    quantity: Literal["length", "angle"]
    form: Form
    sine: Form | None = None


def together(axis: int) -> Row:
    """r_a - r_b = 0 along a coordinate axis of space (0, 1 or 2)."""
    return Row("xyz"[axis], "length", Form(linear=((axis, 1.0), (12 + axis, -1.0))))


TOGETHER = tuple(together(axis) for axis in range(3))
"""Two points coincide."""


def perpendicular(i: int, j: int, name: str) -> Row:
    """Axis e_i of marker a . axis e_j of marker b = 0 (i, j from 1 to 3): the bodies do not turn about the axis normal to both."""
    return Row(f"rotation {name}", "angle", Form(pairs=((i, 4 + j, 1.0),)))


ALIGNED = (perpendicular(2, 3, "about the first axis"), perpendicular(1, 3, "about the second axis"))
"""The third axes of both markers stay parallel: that of b is normal to two axes of a, whatever the angle between the bodies about it."""
LOCKED = (*ALIGNED, perpendicular(1, 2, "about the third axis"))
"""No relative rotation."""


def on_axis(j: int, name: str, offset: Any = 0.0) -> Row:
    """Axis e_j of marker b . (r_a - r_b) - offset = 0."""
    return Row(name, "length", Form(-offset, pairs=((0, 4 + j, 1.0), (4, 4 + j, -1.0))))


ON_LINE = (on_axis(1, "first normal"), on_axis(2, "second normal"))
"""Point a stays on the third axis of marker b."""


def apart(length: Any) -> Row:
    """(d . d / L - L) / 2 = 0 with d = r_a - r_b."""
    return Row("distance", "length", Form(-length / 2, pairs=((0, 0, 0.5 / length), (0, 4, -1 / length), (4, 4, 0.5 / length))))


TURNED = Row("rotation", "angle", Form(pairs=((1, 5, 1.0),)), Form(pairs=((1, 6, 1.0),)))
"""Rotation of marker a about the third axis, measured in marker b: atan2(e_1a . e_2b, e_1a . e_1b)."""


def forms_of(rows: tuple[Row, ...]) -> list[Form]:
    """The forms of a joint in space, in order."""
    return [form for row in rows for form in (row.form, row.sine) if form is not None]


def row_numbers(rows: tuple[Row, ...]) -> list[Any]:
    """Constant, linear values and pair values of every form, in order."""
    numbers = [[form.constant, *(n for *_, n in form.linear), *(n for *_, n in form.pairs)] for form in forms_of(rows)]
    return [number for each in numbers for number in each]
