"""What the plane and space differ in where finite elements become invariants: component mass matrices, and what is made of them.

With Z = [xi, Psi], theory section 1, the mass of a body enters its invariants by

    plane   G = Z^T (M_00 + M_11) Z, symmetric,   H = Z^T (M_01 - M_10) Z, antisymmetric
    space   Q_ab = Z^T M_ab Z for a <= b, symmetric for a = b
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from scipy.sparse import issparse

from toolkit.reduced_model.model import Invariants
from toolkit.reduced_model.spatial_model import PAIRS, SpatialInvariants

Pair = tuple[int, int]
"""Axes a and b of a component mass matrix M_ab; M_ba is its transpose."""


class Form(NamedTuple):
    """One matrix Z^T (sum of M_ab) Z among the invariants."""

    item: str  # name of the invariant
    place: int | None  # along its first axis; None: all of it
    pairs: tuple[Pair, ...]  # whose M_ab are summed
    part: Literal["symmetric", "antisymmetric", "whole"]  # antisymmetric: of the sum without its transpose


@dataclass(frozen=True)
class Space:
    """The plane, or space."""

    dimension: int
    pairs: tuple[Pair, ...]  # the component mass matrices, those with a = b first
    forms: tuple[Form, ...]
    invariants: type

    def by_point(self, rows: Any, components: int) -> Any:
        """Rows of the stress (n_stress * components, n_f) as the invariants have them; in the plane a point has one, sparse rows stay."""
        return rows if self.dimension == 2 or issparse(rows) else rows.reshape(-1, components, rows.shape[1])


PLANE = Space(
    2,
    ((0, 0), (1, 1), (0, 1)),
    (Form("inertia", None, ((0, 0), (1, 1)), "symmetric"), Form("gyroscopic", None, ((0, 1),), "antisymmetric")),
    Invariants,
)
SPACE = Space(
    3,
    PAIRS,
    tuple(Form("second_moment", k, (pair,), "symmetric" if pair[0] == pair[1] else "whole") for k, pair in enumerate(PAIRS)),
    SpatialInvariants,
)
SPACES = {each.dimension: each for each in (PLANE, SPACE)}
