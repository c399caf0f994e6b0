"""Rows of a joint in space that cannot be meant, refused by name before anything runs with them."""

from __future__ import annotations

from toolkit.foundation.errors import InputError
from toolkit.joints.kernels.spatial.forms import Form, Row, forms_of
from toolkit.joints.spatial.joint import SpatialJoint
from toolkit.markers.component import Skeleton

NUMBERS, VECTORS = 24, 8
"""Of the poses of both markers."""


def check_rows(joint: SpatialJoint, scene: Skeleton) -> None:
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
    if not joint.curved:
        raise InputError(
            f"a {joint.kind!r} joint says `curved = False`: the rows of a joint in space are quadratic. Leave it out."
        )
    for row in rows:
        for form in (row.form, row.sine or Form()):
            places = [(place, NUMBERS, "number") for place, _ in form.linear]
            places += [(vector, VECTORS, "vector") for *pair, _ in form.pairs for vector in pair]
            for place, end, what in places:
                if not 0 <= place < end:
                    raise InputError(
                        f"row {row.name!r} of a {joint.kind!r} joint names {what} {place}; the poses of both markers have 0 to {end - 1}."
                    )


def _structure(row: Row) -> tuple:
    """Everything but the values."""
    forms = forms_of((row,))
    return (row.name, row.quantity, *(([place for place, _ in form.linear], [pair[:2] for pair in form.pairs]) for form in forms))
