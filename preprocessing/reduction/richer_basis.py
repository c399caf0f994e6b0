"""Which basis a body of beams gets beside a frozen one, so that runs away from its design can tell what the frozen one lacks there.

A frozen basis spans the shapes of its own design. At another one the body bends otherwise, most where one part of it was made softer than
the rest, and the kept shapes are too stiff for it. All nodal coordinates can do what the body can do at any design. Where these are too
many, and of bodies that float about mean axes, which have no basis of that kind, many more modes must do.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from preprocessing.basis.basis_choice import BasisChoice

LARGEST_FULL = 900
"""Nodal coordinates up to which all are kept: with so many the check takes some 4 s, most of it to compile."""
MORE, MORE_ALONE = 60, 120
"""Modes more than twice those of the frozen basis, beside constraint modes and alone. Errors of too few modes fall with their number at
least, so that twice as many show half of an error in the worst case."""


def richer_choices(choice: BasisChoice, modes: int, n: int) -> list[BasisChoice]:
    """Bases to be tried one after the other beside one with so many modes, of a body with n nodal coordinates.

    None where nothing is frozen, or reduced.
    """
    if choice.derivative != "frozen" or choice.kind == "full":
        return []
    plain: dict[str, Any] = {"frequency": None, "static_error": None, "beside_frozen": True}
    alone = replace(choice, **plain, kind="eigenmodes", count=2 * modes + MORE_ALONE)
    if choice.boundary == "free":
        return [alone]
    if n <= LARGEST_FULL:
        return [replace(choice, **plain, kind="full", count=None)]
    return [replace(choice, **plain, kind="craig-bampton", count=2 * modes + MORE), alone]
