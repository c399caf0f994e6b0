"""Invalid rows of a joint, refused by name before anything runs with them."""

from __future__ import annotations

from collections.abc import Sequence

from toolkit.foundation.errors import InputError
from toolkit.joints.joint import Joint
from toolkit.joints.kernels.laws import FORMS
from toolkit.joints.rows import BETWEEN, Row
from toolkit.markers.component import Skeleton

NUMBERS, VECTORS = {2: 6, 3: 24}, {2: BETWEEN + 1, 3: 8}
"""Dimension -> those of the poses of both markers."""


def keeps_rows(joint: Joint, scene: Skeleton, known: Sequence[Row]) -> bool:
    """Whether the rows in this scene have the structure of the `known` ones.

    Other numbers may cut a profile into other pieces.
    """
    return [_structure(row) for row in joint.constraint(scene)] == [_structure(row) for row in known]


def check_rows(joint: Joint, scene: Skeleton) -> None:
    """Refuse rows that name what no pose has, or whose structure depends on the scene.

    Raises
    ------
    InputError
        Names the kind of the joint and the row.
    """
    rows = joint.constraint(scene)
    if [_structure(row) for row in rows] != [_structure(row) for row in joint.constraint(None)]:
        raise InputError(
            f"a {joint.kind!r} joint has other rows with a scene than without: `constraint(None)` gives the same names and terms as "
            "`constraint(scene)`, with any values."
        )
    for row in rows:
        _check_size(joint, row)
        for form in row.forms:
            places = [(place, NUMBERS[joint.dimension], "number") for place, _ in form.linear]
            places += [(vector, VECTORS[joint.dimension], "vector") for *pair, _ in form.pairs for vector in pair]
            for place, end, what in places:
                if not 0 <= place < end:
                    raise InputError(
                        f"row {row.name!r} of a {joint.kind!r} joint names {what} {place}; the poses of both markers have 0 to {end - 1}."
                    )


def _check_size(joint: Joint, row: Row) -> None:
    """Check the number of forms: one for a row without law, a few for a law."""
    count = len(row.forms)
    if row.law is None and count != 1:
        raise InputError(
            f"row {row.name!r} of a {joint.kind!r} joint has {count} forms and no law: a row is one form, or a law of forms."
        )
    if not 1 <= count <= FORMS:
        raise InputError(f"row {row.name!r} of a {joint.kind!r} joint has {count} forms, a law takes 1 to {FORMS}.")


def _structure(row: Row) -> tuple:
    """Everything of a row but its values."""
    terms = (([place for place, _ in form.linear], [pair[:2] for pair in form.pairs]) for form in row.forms)
    return (row.name, row.quantity, row.law, *terms)
