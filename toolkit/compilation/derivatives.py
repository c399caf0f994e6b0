"""Derivatives of a scene's numbers by its design variables: a complex step through the construction formulas that a variable reaches.

That is exact to round-off, and it happens before time starts to run.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import is_
from typing import Any

import numpy as np

from toolkit.compilation.dependence import Affected, answers_alike
from toolkit.compilation.numbering import Numbering
from toolkit.compilation.quantities import GROUPS, OPEN, STEP, Part, Quantities, Seen, made_of, owners_of, parts_of
from toolkit.curves.curve import Curve
from toolkit.description.design import Design
from toolkit.scene.resolution import ResolvedScene


def derivatives(scene: ResolvedScene, numbering: Numbering, design: Design, seen: Seen) -> list[Quantities]:
    """Derivative of all numbers by each design variable; curves stay complex, they are differentiated where they are evaluated.

    Only what is written otherwise, or is told something else by the scene, can have a derivative: the other formulas are left out. So are
    those of bodies and markers that have not met a complex number then, which is so whatever the values of the scene's numbers are.
    """
    found = []
    for variable in design:
        moved = scene.moved(variable, 1j * STEP)
        parts = parts_of(moved, numbering, owners_of(moved, numbering, numbering.affected_by(scene, variable.paths)))
        stirred = _stirred(seen, moved)
        groups = {group: {k: part for k, part in owners.items() if stirred(group, k, part)} for group, owners in parts.items()}
        found.append(_rates(made_of(groups, moved), _is_reached))
    return found


def renewed_derivatives(
    scene: ResolvedScene, numbering: Numbering, design: Design, known: Sequence[Quantities], among: Affected
) -> list[Quantities]:
    """Derivatives by each design variable at other numbers of the scene, for the same owners as far as these affect them."""
    found, affected = [], {group: set(owners) for group, owners in owners_of(scene, numbering, among).items()}
    for variable, before in zip(design, known, strict=True):
        moved = scene.moved(variable, 1j * STEP)
        reached = {group: getattr(before, group).keys() & owners for group, owners in affected.items()}
        found.append(_rates(made_of(parts_of(moved, numbering, reached), moved)))
    return found


def _rates(moved: Quantities, wanted: Callable[[str, Any], bool] = lambda _group, _part: True) -> Quantities:
    """Derivatives from numbers with a complex step, without those that nobody wants."""
    found: dict[str, Any] = {"gravity": _imag(moved.gravity)}
    for group in GROUPS:
        given = getattr(moved, group)
        kept = {k: part for k, part in given.items() if wanted(group, part)} if given else {}
        found[group] = kept if group == "curves" else {k: _imag(part) for k, part in kept.items()}
    return Quantities(**found)


def _is_reached(group: str, part: Any) -> bool:
    """Whether any number is complex, even with a zero imaginary part, or could be at other numbers of the scene."""
    if isinstance(part, tuple):
        return any(_is_reached(group, each) for each in part)
    return group in OPEN or isinstance(part, Curve) or np.iscomplexobj(part)


def _stirred(seen: Seen, moved: ResolvedScene) -> Callable[[str, int, Part], bool]:
    """Test whether the numbers of an item can be others in a scene of which other numbers are `moved`."""
    same: dict[Any, bool] = {}

    def unchanged(question: Any) -> bool:
        if question not in same:
            same[question] = answers_alike(seen.scene, moved, question)
        return same[question]

    def stirred(group: str, owner: int, part: Part) -> bool:
        before = seen.parts[group][owner].written
        written = len(before) == len(part.written) and all(map(is_, before, part.written))
        return not (written and all(map(unchanged, seen.asked[group, owner])))

    return stirred


def _imag(value):
    if isinstance(value, tuple):
        items = map(_imag, value)
        return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
    return value if np.asarray(value).dtype.kind == "i" else np.imag(value) / STEP  # places stay what they are
