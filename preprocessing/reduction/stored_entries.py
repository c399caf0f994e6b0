"""Which entries of a reduced model's arrays are stored: the same on every processor, whatever the last digits are.

A full basis selects nodal coordinates, and most entries of its arrays are zero. Some of these are sums that cancel, of which
round-off is left: other round-off on another processor, and nothing at all on a third. So an entry counts only if it is more than
round-off of what it could be (`toolkit.reduced_model.shapes`). Shapes that were computed fill their arrays, and the round-off of an
eigenvalue problem is anywhere between 1e-17 and 1e-9 of what counts: no bound tells it from small entries on every processor. So
all entries are stored then, or none where the largest is round-off.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, replace

import numpy as np
from scipy.sparse import csr_array, issparse

from toolkit.foundation.value_types import Matrix
from toolkit.reduced_model.dependence import Derivatives, SparsePolynomial, listed
from toolkit.reduced_model.model import InterfacePoint, Invariants
from toolkit.reduced_model.parts import SpatialInvariants
from toolkit.reduced_model.shapes import EntryScale, entry_factors

ROUND_OFF = 1e-12
"""Part of what an entry could be, below which it is round-off: sums over a thousand elements leave 1e-13, and of an entry as
small as this no digit would count beside the others."""
SHAPE_ROUND_OFF = 1e-9
"""Part of what a whole item of computed shapes could change, below which its change is round-off of their eigenvalue problem."""
BY_COORDINATE = ("position", "rotation", "moment")
"""Last words of the names of items whose last axis is that of [1; q_f]."""

AnyInvariants = Invariants | SpatialInvariants
Rates = Mapping[str, Mapping[str, Matrix]]
"""Parameter -> item -> derivative, of invariants of a full basis a sparse one."""


def without_round_off(inv: AnyInvariants) -> AnyInvariants:
    """Invariants of a full basis, in arrays or sparse, with zeros in the place of round-off."""
    scales = entry_factors(inv)
    return type(inv)(**{f.name: _significant(getattr(inv, f.name), scales[f.name]) for f in fields(inv)})


def _significant(array: Matrix, scale: EntryScale) -> Matrix:
    entry, value = listed(array)
    kept = np.where(np.abs(value) > ROUND_OFF * scale.at(entry), value, 0.0)
    if not issparse(array):
        return kept.reshape(np.shape(array))
    return csr_array((kept, np.unravel_index(entry, array.shape)), shape=array.shape)


def derivatives(
    inv: AnyInvariants, rates: Rates, parameters: Sequence[str], computed: bool, interfaces: Mapping[str, InterfacePoint]
) -> dict[str, Derivatives]:
    """All derivatives as one list of entries for every item that has any.

    Parameters
    ----------
    inv : the invariants themselves
    rates : parameter -> item -> derivative
    parameters : names in their order
    computed : whether the shapes were computed, or are those of a full basis
    interfaces : at which arc lengths the polynomials of `interfaces.*` hold
    """
    scales = entry_factors(inv)
    found: dict[str, list[tuple[int, np.ndarray, np.ndarray]]] = {}
    for parameter, items in rates.items():
        fastest = max(_fastest(items[item], scales[item]) for item in scales if item != "stress_operator")  # of small scales
        for item, rate in items.items():
            if item in scales and not computed:
                entry, value = _of_invariant(rate, scales[item], fastest)
            elif item in scales:
                entry, value = _told(rate, np.full(rate.shape, bool(np.any(rate))))
            else:
                entry, value = _told(rate, _of_item(item, rate, computed, interfaces, fastest))
            if len(entry):
                found.setdefault(item, []).append((list(parameters).index(parameter), entry, value))
    return {item: _joined(rows) for item, rows in found.items()}


def joined_rates(rates: Rates, parameters: Sequence[str]) -> dict[str, Derivatives]:
    """Nonzero entries as one list for every item that has any; `rates` is parameter -> item -> derivative."""
    found: dict[str, list[tuple[int, np.ndarray, np.ndarray]]] = {}
    for parameter, items in rates.items():
        for item, rate in items.items():
            if np.any(rate):
                entry = np.flatnonzero(rate)
                found.setdefault(item, []).append((list(parameters).index(parameter), entry, rate.ravel()[entry]))
    return {item: _joined(rows) for item, rows in found.items()}


def with_more(found: dict[str, Derivatives], others: Mapping[str, Derivatives]) -> dict[str, Derivatives]:
    """Derivatives, together with others of the same items by other parameters."""
    return found | {item: found[item] + each if item in found else each for item, each in others.items()}


def _joined(rows: Iterable[tuple[int, np.ndarray, np.ndarray]]) -> Derivatives:
    numbers, entries, values = zip(*((np.full(len(entry), k), entry, value) for k, entry, value in rows), strict=True)
    return Derivatives(np.concatenate(numbers), np.concatenate(entries), np.concatenate(values))


def _told(rate: np.ndarray, stored: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places in the flattened array, and values, of the stored entries."""
    entry = np.flatnonzero(stored)
    return entry, rate.ravel()[entry]


def _of_invariant(rate: Matrix, scale: EntryScale, fastest: float) -> tuple[np.ndarray, np.ndarray]:
    """Entries that are more than round-off, where the entry of all invariants that changes most in parts of its scale sets the
    measure: the mass, whose one entry does not change where a node moves across a straight beam, is none for itself."""
    entry, value = listed(rate)
    more = np.abs(value) > ROUND_OFF * max(fastest, _fastest(rate, scale)) * scale.at(entry)
    return entry[more], value[more]


def _fastest(rate: Matrix, scale: EntryScale) -> float:
    """Largest change of an entry in parts of its scale."""
    entry, value = listed(rate)
    own = scale.at(entry)
    return float(np.divide(np.abs(value), own, out=np.zeros(len(own)), where=own > 0).max(initial=0))


def _of_item(item: str, rate: np.ndarray, computed: bool, interfaces: Mapping[str, InterfacePoint], fastest: float) -> np.ndarray:
    """Columns of computed shapes whole, or none of them; other entries as far as they are more than round-off of the item's
    largest.

    The coefficient of (s - s_0)^k counts as what it adds at the end of its element. Shapes that stay 1 where a point is held
    leave a whole item of round-off: it is measured by the item itself, times how `fastest` an invariant changes in its parts. A point
    that no shape moves is held, whatever the design.
    """
    group, *rest = item.split(".")
    size, least = np.abs(rate), 0.0
    if group == "interfaces" and rest[-1] in BY_COORDINATE:
        point = interfaces[rest[0]]
        reach = np.ptp(np.real(point.arc_length_range))
        powers = (reach ** np.arange(len(rate))).reshape(-1, *(1,) * (rate.ndim - 1))
        own = np.abs(getattr(point, rest[-1]) * powers)[..., 1:].max(initial=0)
        size, least = size * powers, SHAPE_ROUND_OFF * fastest * own if own > 0 else np.inf
    if not (computed and rest[-1] in BY_COORDINATE):
        return size > ROUND_OFF * size.max(initial=0)
    found = np.zeros(rate.shape, bool)
    found[..., 0] = size[..., 0] > ROUND_OFF * size[..., 0].max(initial=0)
    found[..., 1:] = size[..., 1:].max(initial=0) > least
    return found


def polynomials_without_round_off(
    polynomials: Mapping[str, SparsePolynomial], inv: AnyInvariants, nominal: Sequence[float]
) -> dict[str, SparsePolynomial]:
    """Polynomials of a full basis without coefficients that are round-off of what one monomial contributes.

    Parameters
    ----------
    inv : the invariants at the nominal design
    nominal : values of the parameters in their order
    """
    of_inertia = dict(_inertia_by_monomial(polynomials, inv))
    found = {}
    for item, polynomial in polynomials.items():
        shape = getattr(inv, item).shape
        kept = np.zeros(len(polynomial.value), bool)
        for monomial, here in _by_monomial(polynomial):
            scale = _scale(item, shape, polynomial, here, of_inertia.get(monomial), inv, _value(monomial, nominal))
            kept[here] = np.abs(polynomial.value[here]) > ROUND_OFF * scale
        if kept.any():
            terms, number = np.unique(polynomial.term[kept], return_inverse=True)  # without those of which nothing is left
            parts = (polynomial.factor[terms], polynomial.power[terms], number, polynomial.entry[kept], polynomial.value[kept])
            found[item] = SparsePolynomial(*parts)
    return found


Monomial = tuple[tuple[int, int], ...]
"""Numbers of parameters and their powers."""


def _by_monomial(polynomial: SparsePolynomial) -> Iterator[tuple[Monomial, np.ndarray]]:
    """Monomials with the numbers of all coefficients of all terms that have it."""
    terms: dict[Monomial, list[int]] = {}
    for k, (factor, power) in enumerate(zip(polynomial.factor.tolist(), polynomial.power.tolist(), strict=True)):
        terms.setdefault(tuple(sorted((f, p) for f, p in zip(factor, power, strict=True) if f >= 0)), []).append(k)
    for monomial, numbers in terms.items():
        yield monomial, np.flatnonzero(np.isin(polynomial.term, numbers))


def _value(monomial: Monomial, nominal: Sequence[float]) -> float:
    return float(np.prod([nominal[f] ** p for f, p in monomial]))


def _inertia_by_monomial(
    polynomials: Mapping[str, SparsePolynomial], inv: AnyInvariants
) -> Iterator[tuple[Monomial, np.ndarray]]:
    """Diagonal (z,) of G, or of the sum of the Q_aa, that every monomial contributes."""
    item, planes = ("second_moment", 3) if isinstance(inv, SpatialInvariants) else ("inertia", 1)
    z = getattr(inv, item).shape[-1]
    for monomial, here in _by_monomial(polynomials[item]):
        entry, value = polynomials[item].entry[here], polynomials[item].value[here]
        plane, row, column = np.unravel_index(entry, (len(getattr(inv, item)) if planes > 1 else 1, z, z))
        own = (row == column) & (plane < planes)
        yield monomial, np.bincount(row[own], value[own], z)


def _scale(
    item: str,
    shape: tuple[int, ...],
    polynomial: SparsePolynomial,
    here: np.ndarray,
    inertia: np.ndarray | None,
    inv: AnyInvariants,
    unit: float,
) -> np.ndarray:
    """Largest possible size of the coefficients `here` of one monomial, whose value at the nominal design is `unit`."""
    entry, value = polynomial.entry[here], polynomial.value[here]
    row, column = np.unravel_index(entry, shape)[-2:] if len(shape) > 1 else (entry, entry)
    if item == "stress_operator":
        return _of_rows(entry // shape[-1], column, np.abs(value))
    if item in ("mass", "first_moment"):
        mass = np.abs(float(inv.mass) / unit)  # of the whole body: a part that only turns has none of its own
        assert inertia is not None
        return np.full(len(here), mass) if item == "mass" else np.sqrt(mass * np.abs(inertia[column]))
    if item in ("stiffness", "damping"):
        on_diagonal = row == column
        inertia = np.bincount(row[on_diagonal], value[on_diagonal], shape[-1])
    assert inertia is not None
    return np.sqrt(np.abs(inertia[row] * inertia[column]))


def _of_rows(row: np.ndarray, column: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Largest sizes of a stress operator's entries in a list, as `entry_scales` has them."""
    columns = np.zeros(column.max(initial=0) + 1)
    np.maximum.at(columns, column, size)
    rows = np.zeros(row.max(initial=0) + 1)
    np.maximum.at(rows, row, np.divide(size, columns[column], out=np.zeros_like(size), where=columns[column] > 0))
    return rows[row] * columns[column]


HELD_POINT = 1e-12
"""Part of the largest displacement of a node, or of the rotation that it is over the body's size, below which a point is held."""


def with_held_points(
    interfaces: Mapping[str, InterfacePoint], displacements: np.ndarray, size: float
) -> dict[str, InterfacePoint]:
    """Interface points with zeros where all shapes together leave a position or a rotation at rest.

    Parameters
    ----------
    interfaces : by their names
    displacements : of nodes by the shapes, of any shape
    size : of the body, a length
    """
    largest = float(np.abs(displacements).max(initial=0))
    return {
        name: replace(point, position=_held(point.position, size, largest), rotation=_held(point.rotation, size, largest / size))
        for name, point in interfaces.items()
    }


def _held(coefficients: np.ndarray, size: float, largest: float) -> np.ndarray:
    """Coefficients of the powers of the arc length, which is at most the size."""
    found, powers = coefficients.copy(), np.arange(len(coefficients)).reshape(-1, *(1,) * (coefficients.ndim - 1))
    if np.abs(coefficients[..., 1:] * size**powers).max(initial=0) <= HELD_POINT * largest:
        found[..., 1:] = 0
    return found
