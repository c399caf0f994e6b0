"""What the plane and space differ in where finite elements become invariants: component mass matrices, and what is made of them.

With Z = [xi, Psi], theory section 1, the mass of a body enters its invariants by

    plane   G = Z^T (M_00 + M_11) Z, symmetric,   H = Z^T (M_01 - M_10) Z, antisymmetric
    space   Q_ab = Z^T M_ab Z for a <= b, symmetric for a = b

The centrifugal forces of a body that spins with omega about its frame's origin are, with the symmetric parts of the M_ab,

    plane   omega^2 (M_00 + M_11) xi
    space   sum_ij omega_i omega_j F_ij,   F_ii = (sum_a M_aa - M_ii) xi,   F_ij = -M_ij xi
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
    """Product Z^T (sum of M_ab) Z among the invariants."""

    item: str  # name of the invariant
    place: int | None  # along its first axis; None: all of it
    pairs: tuple[Pair, ...]  # whose M_ab are summed
    part: Literal["symmetric", "antisymmetric", "whole"]  # antisymmetric: of the sum without its transpose


Spin = tuple[tuple[Pair, float], ...]
"""Product of angular velocities: the M_ab whose symmetric parts make its centrifugal forces, and their weights."""


@dataclass(frozen=True)
class Space:
    """Plane or space, with the forms of its invariants."""

    dimension: int
    pairs: tuple[Pair, ...]  # the component mass matrices, those with a = b first
    forms: tuple[Form, ...]
    spins: tuple[Spin, ...]
    invariants: type

    def by_point(self, rows: Any, components: int) -> Any:
        """Rows of the stress (n_stress * components, n_f) as the invariants have them; in the plane a point has one, sparse rows stay."""
        return rows if self.dimension == 2 or issparse(rows) else rows.reshape(-1, components, rows.shape[1])


PLANE = Space(
    2,
    ((0, 0), (1, 1), (0, 1)),
    (Form("inertia", None, ((0, 0), (1, 1)), "symmetric"), Form("gyroscopic", None, ((0, 1),), "antisymmetric")),
    ((((0, 0), 1.0), ((1, 1), 1.0)),),
    Invariants,
)
SPACE = Space(
    3,
    PAIRS,
    tuple(Form("second_moment", k, (pair,), "symmetric" if pair[0] == pair[1] else "whole") for k, pair in enumerate(PAIRS)),
    tuple(tuple(((a, a), 1.0) for a in range(3) if a != pair[0]) if pair[0] == pair[1] else ((pair, -1.0),) for pair in PAIRS),
    SpatialInvariants,
)
SPACES = {each.dimension: each for each in (PLANE, SPACE)}
