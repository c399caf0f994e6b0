"""A reduced model at one design: every item at the wanted parameter values, with its exact derivatives, or a refusal."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property, lru_cache, reduce
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from toolkit.foundation.errors import InputError, listed, meant
from toolkit.foundation.itself import Itself
from toolkit.reduced_model.dependence import (
    ENTRIES_AT_ONCE,
    Derivatives,
    Slopes,
    SparsePolynomial,
    Together,
    Told,
    places,
    scattered,
    sparing,
    told_of,
)
from toolkit.reduced_model.model import InterfacePoint, Invariants, ReducedModel, Shape
from toolkit.reduced_model.parts import BeamSections, SpatialInvariants

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Matrix, Scalar

REMEMBERED_DESIGN_POINTS = 8
"""Design points that are kept with what was evaluated there: complex steps in other numbers of a scene ask for the same ones again."""


@dataclass(frozen=True)
class DesignPoint:
    """Reduced model at given values of its parameters, nominal where none is given.

        item(p) = polynomial(p) + sum_j d_j (p_j - nominal_j)

    The derivatives d_j are known at the nominal design only. So the sum is exact for an imaginary step there; for anything else it is
    a tangent, which is refused unless `first_order` asks for it.

    Raises
    ------
    InputError
        A parameter is unknown; or nothing that was loaded tells how the model depends on it.
    """

    model: ReducedModel
    values: Mapping[str, Scalar] = field(default_factory=dict)
    first_order: bool = False

    def __post_init__(self) -> None:
        for parameter in self.values:
            if parameter in self.model.nominal:
                continue
            raise InputError(
                f"reduced model {self.model.label} has no parameter {parameter!r}{meant(parameter, self.model.parameters)}; available: "
                f"{listed(self.model.parameters)}. Use one of these names, or state it in the skin file and run "
                "preprocessing again."
            )

    @cached_property
    def kept(self) -> dict[Hashable, Any]:
        """Objects that others have made of the model at this design, stored for as long as the design is remembered."""
        return {}

    @cached_property
    def p(self) -> np.ndarray:
        return np.array([self.values.get(name, nominal) for name, nominal in self.model.nominal.items()])

    def parameter(self, number: int) -> Scalar:
        """Value of the parameter with the given number, real or complex."""
        return self.p[number]

    @cached_property
    def _steps(self) -> dict[int, Scalar]:
        """Differences from the nominal design, by the number of the parameter."""
        numbers, nominal = self.model.numbers, self.model.nominal
        steps = {numbers[name]: value - nominal[name] for name, value in self.values.items()}
        return {k: step for k, step in steps.items() if step != 0}

    @cached_property
    def _complex(self) -> frozenset[int]:
        """Parameters with a complex step: items that depend on none of them are real."""
        return frozenset(k for k, step in self._steps.items() if isinstance(step, complex))

    def invariants(self) -> Invariants | SpatialInvariants:
        """All invariants at this design.

        Raises
        ------
        InputError
            As `value`; or a tangent has led to a stiffness that no body has.
        """
        kind = type(self.model.invariants)
        names = [item.name for item in fields(kind)]
        return kind(**dict(zip(names, self.some_invariants(*names), strict=True)))

    def some_invariants(self, *items: str) -> tuple[np.ndarray, ...]:
        """Invariants of the given names; errors as `invariants` if the stiffness is among them."""
        self.check_extrapolated(items)
        return tuple(map(self.value, items))

    def sections(self) -> BeamSections | None:
        """Sections of the body's beams; None of a model that does not give them at this design. Errors as `value`."""
        nominal = self.model.sections
        if nominal is None or (self._steps and None in self.model.dependence("sections.axial_stiffness")):
            return None
        changed = {name: self.value(f"sections.{name}") for name in vars(nominal) if name != "axis"}
        return BeamSections(axis=nominal.axis, **changed)

    def check_extrapolated(self, items: Sequence[str]) -> None:
        """Refuse a stiffness that a tangent has led to and that no body has, if it is among some items."""
        if self.first_order and "stiffness" in items:
            self.check_stiffness(self.value("stiffness"))

    def check_stiffness(self, stiffness: np.ndarray) -> None:
        """Refuse a stiffness at this design, of the body or of a part of it, that a tangent has led to and that no body has.

        A skin is so much stiffer in tension than in bending that a small error of the one exceeds all of the other.

        Raises
        ------
        InputError
            It is not positive definite.
        """
        if not (self.first_order and (names := self.extrapolated())):
            return
        stiffness = np.real(stiffness)
        diagonal = np.diag(stiffness)
        if not np.all(diagonal > 0) or np.linalg.eigvalsh(stiffness / np.sqrt(np.outer(diagonal, diagonal)))[0] <= 0:
            knows = "interface" in self.model.left_out  # as such a basis does
            other = "" if knows else ', or use kind = "craig-bampton" in its [basis], whose tangents reach further'
            raise InputError(
                f"following the tangent in {', '.join(names)}, the stiffness in reduced model {self.model.label} is no longer positive "
                f"definite: the step is too large for first order. Rerun preprocessing with the wanted values{other}."
            )

    def interface(self, name: str) -> InterfacePoint:
        """Interface point at this design; its range is that of the nominal design."""
        if name not in self._interfaces:
            self._interfaces[name] = self._interface(name)
        return self._interfaces[name]

    @cached_property
    def _interfaces(self) -> dict[str, InterfacePoint]:
        """Interface points that were evaluated so far, by name."""
        return {}

    def _interface(self, name: str) -> InterfacePoint:
        point = self.model.interfaces[name]  # type: ignore[index]
        changed = {key: self.value(f"interfaces.{name}.{key}") for key in ("arc_length", "position", "rotation")}
        return InterfacePoint(arc_length_range=point.arc_length_range, **changed)

    def shape(self) -> Shape:
        """Points with a target at this design."""
        nominal: Any = self.model.shape
        return Shape(self.value("shape.position"), self.value("shape.target"), nominal.arc_length)

    def value(self, item: str) -> np.ndarray:
        """Array of an item at this design.

        Raises
        ------
        InputError
            Nothing that was loaded tells the item's value at this design.
        """
        if item not in self._known:
            self._known[item] = self._evaluated(item)
        return self._known[item]

    @cached_property
    def _known(self) -> dict[str, Any]:
        """Items that were asked for, and other results stored with them."""
        return {}

    def _evaluated(self, item: str) -> np.ndarray:
        nominal = self.model.item(item)
        if not self._steps or self._told(item) is None:
            return nominal
        here, flat = self.filled(item)
        found = np.zeros(nominal.size, flat.dtype)
        found[here] = flat
        return found.reshape(nominal.shape)

    def filled(self, item: str) -> tuple[np.ndarray | slice, np.ndarray]:
        """Places in a flattened item that can be nonzero at designs of this kind, or all, and the values there; as `value`."""
        told = self._told(item) if self._steps else None
        if told is None:
            flat = self.model.item(item).ravel()
            here = self._filled_at_nominal(item)
            return here, flat[here]
        flat = told.own if told.polynomial is None else self._by_polynomial(item, told)
        for k, (entry, slope) in told.tangents.items():
            flat = flat + scattered(entry, self._steps[k] * slope, len(told.own))
        if not any(real for _, real, _ in self.kind[1:]):
            flat = told.own + 1j * np.imag(flat)  # the nominal body itself, whose last digits a thin skin feels
        return told.here, flat

    def _filled_at_nominal(self, item: str) -> np.ndarray:
        known, key = self.model.told, ("filled", item)
        if key not in known:
            known[key] = places(self.model.item(item))
        found: np.ndarray = known[key]
        return found

    @cached_property
    def kind(self) -> tuple[bool, *tuple[tuple[int, bool, bool], ...]]:
        """Key of designs whose items follow from the same data: parameters that are off, by a real or a complex step."""
        return (self.first_order, *((k, np.real(step) != 0, k in self._complex) for k, step in self._steps.items()))

    def _told(self, item: str) -> Told | None:
        """File's data on an item that changes, None of others; looked up once for all designs of a kind."""
        known, key = self.model.told, (self.kind, item)
        if key not in known:
            known[key] = self._looked_up(item)
        found: Told | None = known[key]
        return found

    def _looked_up(self, item: str) -> Told | None:
        if None not in self.model.dependence(item) and not self.moves(item):
            return None
        by_tangent = [k for k in self._steps if self._is_tangent(item, k)]
        self.check(item, by_tangent)
        derivatives, polynomials = self.model.dependence(item)
        tangents = {k: derivatives[item].by(k) for k in by_tangent}  # type: ignore[index]
        return told_of(self.model.item(item), (polynomials or {}).get(item), tangents, self._complex)

    def _by_polynomial(self, item: str, told: Told) -> np.ndarray:
        """Values of an item's polynomial on its places, evaluated together for all items asked for at designs of this kind."""
        key = "polynomial of {}".format
        if key(item) not in self._known:
            recorded = self.model.told.get((self.kind, told.complex))
            if recorded is None or item not in recorded.places:
                recorded = self._recorded(item, told, recorded)
            self._known.update({key(name): values for name, values in recorded(self.p).items()})
        found: np.ndarray = self._known[key(item)]
        return found

    def _recorded(self, item: str, told: Told, others: Together | None) -> Together:
        """Joint polynomial of an item and others; of the item alone if all are too large together."""
        wanted = {} if others is None else {name: self.model.told[self.kind, name] for name in others.places}
        wanted[item] = told
        if sum(0 if each.polynomial is None else len(each.polynomial.entry) for each in wanted.values()) > ENTRIES_AT_ONCE:
            return Together.of({item: told})
        found = self.model.told[self.kind, told.complex] = Together.of(wanted)
        return found

    def rows(self, item: str) -> Matrix:
        """Item as a matrix (.., n) of its last axis; sparse if it is large and zero nearly everywhere.

        Raises
        ------
        InputError
            As `value`.
        """
        key = f"rows of {item}"
        if key not in self._known:
            self._known[key] = sparing(self.value(item))
        return self._known[key]

    def moves(self, item: str) -> bool:
        """Whether an item differs from its nominal value, be it by an imaginary step."""
        told = ((part or {}).get(item) for part in self.model.dependence(item))
        return any(each is not None and each.depends_on_any(self._steps) for each in told)

    def extrapolated(self) -> list[str]:
        """Names of the parameters whose real step the model follows by a tangent."""
        items = list(self.model.all_derivatives)
        moved = [k for k, step in self._steps.items() if np.real(step) != 0]
        return [self.model.parameters[k] for k in moved if any(self._is_tangent(item, k) for item in items)]

    def _is_tangent(self, item: str, k: int) -> bool:
        tangent = (self.model.dependence(item)[0] or {}).get(item)
        return tangent is not None and tangent.depends_on(k)

    def _depends(self, item: str, k: int) -> bool:
        polynomial = (self.model.dependence(item)[1] or {}).get(item)
        return self._is_tangent(item, k) or (polynomial is not None and polynomial.depends_on(k))

    def check(self, item: str, by_tangent: list[int]) -> None:
        """Refuse an item that the file does not give at this design, or a tangent step that was not asked for."""
        names = self.model.parameters
        if None in self.model.dependence(item):
            first = names[next(iter(self._steps), 0)]
            raise InputError(
                f"{first!r} has no derivatives in reduced model {self.model.label}: nothing there tells how {item} depends on it. "
                f"Leave it at {self.model.nominal[first]:g}, or rerun preprocessing."
            )
        moved = [k for k, step in self._steps.items() if np.real(step) != 0 and self._depends(item, k)]
        if by_tangent and moved and not self.first_order:
            first, where = names[moved[0]], self.model.nominal[names[moved[0]]]
            raise InputError(
                f"{first!r} of reduced model {self.model.label} is fixed at {where:g}: the file holds the derivative of {item} by "
                f"{names[by_tangent[0]]!r} at the nominal design only. Rerun preprocessing with the wanted value, or write "
                'extrapolation = "first-order" in the body\'s table to follow the tangent, with an error of second order.'
            )


def design_at(model: ReducedModel, values: Mapping[str, Scalar], first_order: bool) -> DesignPoint:
    """Design point of a model at some values; the same object while it is among the last that were asked for."""
    return _design_at(Itself(model), tuple(values.items()), first_order)


@lru_cache(maxsize=REMEMBERED_DESIGN_POINTS)
def _design_at(same: Itself[ReducedModel], values: tuple[tuple[str, Scalar], ...], first_order: bool) -> DesignPoint:
    return DesignPoint(same.item, dict(values), first_order)


class ElasticMatrices(NamedTuple):
    """Entries of several matrices of the elastic coordinates, row by row."""

    row: np.ndarray
    column: np.ndarray
    values: tuple[np.ndarray, ...]


def elastic_matrices(design: DesignPoint, *items: str) -> ElasticMatrices:
    """Invariants of some names on the elastic coordinates; an axis for the undeformed shape before these is left out.

    Raises
    ------
    InputError
        As `DesignPoint.some_invariants`.
    """
    design.check_extrapolated(items)
    found = [design.filled(item) for item in items]
    known, key = design.model.told, ("elastic", design.kind, items)
    if key not in known:
        n_f, sizes = design.model.n_f, [design.model.item(item).shape[0] for item in items]
        known[key] = _common(n_f, [_inside(here, n_f, size) for (here, _), size in zip(found, sizes, strict=True)])
    row, column, places = known[key]
    values = [_on(len(row), flat, *at) for (_, flat), at in zip(found, places, strict=True)]
    filled = reduce(np.logical_or, (value != 0 for value in values))
    if not filled.all():
        row, column, values = row[filled], column[filled], [value[filled] for value in values]
    return ElasticMatrices(row, column, tuple(values))


def _inside(here: np.ndarray | slice, n_f: int, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Entries between elastic coordinates: places in the flattened (n_f, n_f) matrix, and which of the given places they are."""
    row, column = (each - (size - n_f) for each in np.divmod(np.arange(size * size)[here], size))
    elastic = np.flatnonzero((row >= 0) & (column >= 0))
    return row[elastic] * n_f + column[elastic], elastic


def _common(
    n_f: int, parts: list[tuple[np.ndarray, np.ndarray]]
) -> tuple[np.ndarray, np.ndarray, list[tuple[np.ndarray, np.ndarray]]]:
    """Rows and columns of all matrices' entries, and for each matrix where its entries are among them and which they are."""
    every = np.sort(np.concatenate([place for place, _ in parts]), kind="stable")  # of sorted runs, which `unique` would hash
    union = every[np.diff(every, prepend=-1) > 0]
    return union // n_f, union % n_f, [(np.searchsorted(union, place), own) for place, own in parts]


def _on(size: int, flat: np.ndarray, to: np.ndarray, own: np.ndarray) -> np.ndarray:
    found = np.zeros(size, flat.dtype)
    found[to] = flat[own]
    return found


NONE = Derivatives(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0))


def rates_at(design: DesignPoint, item: str, numbers: Mapping[str, int]) -> Derivatives:
    """Derivatives of an item by parameters: numbers of these, places in the flattened item, and values to be summed by place.

    Parameters
    ----------
    numbers : the wanted parameters, and the number that each shall have in the result

    Raises
    ------
    InputError
        Nothing that was loaded tells a derivative at this design.
    """
    linear, polynomial, slopes = _told(design, item, tuple(numbers.items()))
    if polynomial is None:
        return linear
    found = polynomial.rates(np.real(design.p), slopes)
    return linear + found if len(linear.parameter) else found


def _told(
    design: DesignPoint, item: str, numbers: tuple[tuple[str, int], ...]
) -> tuple[Derivatives, SparsePolynomial | None, Slopes | None]:
    """File's data on an item's derivatives; looked up once for all designs of a kind."""
    known, key = design.model.told, (design.kind, item, numbers)
    if key not in known:
        by_name = dict(numbers)
        wanted = np.array([by_name.get(name, -1) for name in design.model.parameters])
        derivatives, polynomials = design.model.dependence(item)
        polynomial, tangent = (polynomials or {}).get(item), (derivatives or {}).get(item, NONE)
        design.check(item, [int(k) for k in np.unique(tangent.parameter) if wanted[k] >= 0])
        known[key] = tangent.renumbered(wanted), polynomial, polynomial and polynomial.slopes_by(wanted)
    found: tuple[Derivatives, SparsePolynomial | None, Slopes | None] = known[key]
    return found
