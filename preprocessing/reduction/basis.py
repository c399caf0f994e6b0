"""The basis Z = [xi, Psi] of a reduced body: what a person chooses of it, its columns, and their derivatives by the design.

The basis Z = [xi, Psi] of a reduced body and its derivatives by the design.

A material point is u_P = S(x_P) Z [1; q_f] in the body frame: xi holds the nodal coordinates that reproduce the undeformed shape,
`S(x) xi = x`, Psi the displacements that belong to the elastic coordinates q_f.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Protocol

import numpy as np

from preprocessing.reduction.boundary import Boundary
from preprocessing.reduction.constrained_pencil import ConstrainedPencil, ConstraintModes
from preprocessing.reduction.normal_modes import NormalModes, subspace_rates
from toolkit.foundation.errors import InputError
from toolkit.foundation.value_types import Matrix


class ElasticShapes(Protocol):
    """Part of the columns of Psi, with its derivatives."""

    @property
    def follows_matrices(self) -> bool:
        """Whether the shapes change with stiffness and mass, or with the places of nodes and points alone."""

    @property
    def columns(self) -> np.ndarray:
        """Shapes on the nodal coordinates, (n, k)."""

    def rates(self, d_pencils: Sequence[ConstrainedPencil]) -> np.ndarray:
        """Derivatives (n, k, n_x) of the shapes by the design variables whose dK, dM and dR are given."""


@dataclass(frozen=True, eq=False)
class InterfaceShapes:
    """Constraint modes of the interface points; those that hold the body, the first `n_clamp`, are zero."""

    modes: ConstraintModes
    n_clamp: int
    follows_matrices: ClassVar[bool] = True

    @property
    def columns(self) -> np.ndarray:
        """Shapes on the nodal coordinates, (n, n_r - n_clamp)."""
        return self.modes.shapes[:, self.n_clamp :]

    def rates(self, d_pencils: Sequence[ConstrainedPencil]) -> np.ndarray:
        """Derivatives of the shapes by the design variables, (n, n_r - n_clamp, n_x)."""
        return self.modes.rates(d_pencils)[:, self.n_clamp :]


@dataclass(frozen=True, eq=False)
class ModeShapes:
    """Eigenmodes, which change within the derivative of their span."""

    modes: NormalModes
    follows_matrices: ClassVar[bool] = True

    @property
    def columns(self) -> np.ndarray:
        """Shapes on the nodal coordinates, (n, m)."""
        return self.modes.columns

    def rates(self, d_pencils: Sequence[ConstrainedPencil]) -> np.ndarray:
        """Derivatives of the shapes by the design variables, (n, m, n_x)."""
        return self.modes.turned(subspace_rates(self.modes, d_pencils))


@dataclass(frozen=True, eq=False)
class DesignRates:
    """Derivatives by one design variable of everything that a basis is made of."""

    stiffness: Matrix  # (n, n)
    mass: Matrix  # (n, n), of M_11 + M_22
    xi: np.ndarray  # (n,), of the undeformed nodal coordinates
    interface_rows: Mapping[str, np.ndarray] = field(
        default_factory=dict
    )  # (3 or 6, n); points that do not change may be left out


@dataclass(frozen=True, eq=False)
class ReductionBasis:
    """Matrix Z with the words of the reduced-model file about it; `parts` are the columns of Psi that change with the design."""

    z: np.ndarray  # (n, 1 + n_f)
    reference_condition: str
    description: str  # begins with "frozen:" or "differentiated:"
    frequencies: np.ndarray = field(default_factory=lambda: np.zeros(0))  # of the eigenmodes among the shapes, in Hz
    left_out: Mapping[str, float] = field(default_factory=dict)  # of few shapes, as `ReducedModel.left_out`
    boundary: Boundary | None = None
    beyond: NormalModes | None = None  # modes that are left out
    parts: tuple[ElasticShapes, ...] = ()

    @property
    def constant(self) -> bool:
        """Whether Psi keeps its values at every design that leaves nodes and interface points where they are."""
        return not any(part.follows_matrices for part in self.parts)

    def rate(
        self, d_stiffness: Matrix, d_mass: Matrix, d_xi: np.ndarray, d_interface_rows: Mapping[str, np.ndarray] | None = None
    ) -> np.ndarray:
        """Derivative dZ = [dxi, dPsi] (n, 1 + n_f) by one design variable; `rates` is much cheaper for many."""
        return self.rates([DesignRates(d_stiffness, d_mass, d_xi, d_interface_rows or {})])[:, :, 0]

    def rates(self, changes: Sequence[DesignRates]) -> np.ndarray:
        """Derivatives dZ (n, 1 + n_f, n_x) by all design variables, each matrix factored once; dPsi is zero for a frozen basis.

        Some arrays of the result's size are needed on the way: give thousands of variables in portions.

        Raises
        ------
        InputError
            An interface point leaves the clamped node.
        """
        rates = np.zeros((*self.z.shape, len(changes)))
        if not changes:
            return rates
        rates[:, 0] = np.column_stack([change.xi for change in changes])
        if self.parts and self.boundary is not None:
            d_pencils = [
                ConstrainedPencil(change.stiffness, change.mass, self.boundary.rates(change.interface_rows, change.xi))
                for change in changes
            ]
            rates[:, 1:] = np.concatenate([part.rates(d_pencils) for part in self.parts], axis=1)
            rates[self.boundary.always_still, 1:] = 0
        return rates


KINDS = ("full", "eigenmodes", "craig-bampton", "static")
BOUNDARIES = ("clamped", "free")
DERIVATIVES = ("differentiated", "frozen")
WAYS = ("count", "frequency", "static_error")
_WAYS_OF_KIND = {"full": (), "static": (), "eigenmodes": WAYS, "craig-bampton": ("count", "frequency")}
_WHY_NOT = {
    "full": "the full basis keeps every coordinate",
    "static": "a static basis has no eigenmodes",
    "craig-bampton": "a Craig-Bampton basis is statically exact at its interface points with any number of modes",
    "eigenmodes": "",
}


@dataclass(frozen=True)
class BasisChoice:
    """Choice of a basis before it is computed; `count`, `frequency` and `static_error` are three ways to set how many modes."""

    kind: str
    boundary: str = "clamped"  # of eigenmodes: held with the body's frame, or free about mean axes
    count: int | None = None
    frequency: float | None = None  # highest, in Hz
    static_error: float | None = None  # relative error of the compliance at the interface points
    derivative: str = "differentiated"  # or "frozen": the shapes stay what they are when the design changes
    chord: tuple[str, ...] | None = None  # two interface points that the body's frame goes through, instead of a clamp
    spin_stiffening: bool = False  # whether the model tells how a spin of its frame stiffens the body
    beside_frozen: bool = (
        False  # whether it stands beside a frozen one, without elements and with all modes where `count` is more than these
    )

    @property
    def followed(self) -> tuple[str, ...] | None:
        """Interface points whose places the shapes follow; None for all of them."""
        if self.derivative != "differentiated":
            return ()
        return None if self.kind in ("craig-bampton", "static") else tuple(self.chord or ())

    def __post_init__(self) -> None:
        for name, allowed in (("kind", KINDS), ("boundary", BOUNDARIES), ("derivative", DERIVATIVES)):
            if getattr(self, name) not in allowed:
                raise InputError(f"{name} {getattr(self, name)!r} is unknown; available: {', '.join(allowed)}.")
        if self.boundary == "free" and self.kind != "eigenmodes":
            raise InputError(f'boundary "free" belongs to eigenmodes; a {self.kind} basis is clamped. Leave the key out.')
        self._check_chord()
        self._check_number_of_modes()

    def _check_chord(self) -> None:
        if self.chord is None:
            return
        if len(self.chord) != 2 or self.chord[0] == self.chord[1]:
            raise InputError(
                f"chord goes through two interface points; got {', '.join(self.chord) or 'none'}. Name two different ones."
            )
        if self.spin_stiffening:
            raise InputError(
                "spin_stiffening is that of a body whose frame is clamped, or floats about mean axes; a chord turns as the body "
                "bends. Give the frame a clamp, or leave one of them out."
            )
        if self.boundary == "free":
            raise InputError(
                'boundary "free" floats about mean axes, and a chord holds the frame at two points. Leave one of them out.'
            )

    def _check_number_of_modes(self) -> None:
        ways = _WAYS_OF_KIND[self.kind]
        given = [way for way in WAYS if getattr(self, way) is not None]
        if foreign := [way for way in given if way not in ways]:
            remedy = f"Give {' or '.join(ways)}" if ways else "Leave the key out"
            raise InputError(f"{', '.join(foreign)} does not fit to {self.kind}: {_WHY_NOT[self.kind]}. {remedy}.")
        if ways and len(given) != 1:
            raise InputError(f"{self.kind} needs exactly one of {', '.join(ways)}; got {', '.join(given) or 'none'}.")
        least = 1 if self.kind == "eigenmodes" else 0
        if self.count is not None and self.count < least:
            raise InputError(f"count {self.count} is invalid; {self.kind} needs at least {least}.")
