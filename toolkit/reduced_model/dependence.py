"""Arrays of a reduced model as functions of its parameters: sparse polynomials, and derivatives for what is none."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, TypeGuard

import numpy as np
import scipy

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Matrix

SEARCHED_ARRAY_SIZE = 1_000_000
"""Numbers of an array that is worth the search for those that are not zero."""
SPARSE_PART = 0.05
"""Part of them that is not zero, below which an array is thin."""


def is_thin(array: np.ndarray, large: int | None = None) -> bool:
    """Whether an array is large, with at least `large` numbers, and zero nearly everywhere."""
    return array.size >= (SEARCHED_ARRAY_SIZE if large is None else large) and bool(
        np.count_nonzero(array) < SPARSE_PART * array.size
    )


def sparing(array: np.ndarray, large: int | None = None) -> Matrix:
    """Array as a matrix with all axes but the last one in one; sparse if it is thin."""
    rows = array.reshape(-1, array.shape[-1])
    return scipy.sparse.csr_array(rows) if is_thin(array, large) else rows


def is_sparse(array: object) -> TypeGuard[scipy.sparse.csr_array]:
    """Whether an array is one of SciPy's sparse arrays.

    Importing those takes a tenth of a second, which a run without any need not pay.
    """
    return hasattr(array, "tocsr")


def listed(array: Matrix) -> tuple[np.ndarray, np.ndarray]:
    """Places in the flattened array in their order, and the values there: of a sparse array the stored ones, of others all."""
    if not is_sparse(array):
        return np.arange(np.size(array)), np.ravel(array)
    every = array.tocsr().tocoo()
    entry = np.ravel_multi_index(every.coords, every.shape)
    order = np.argsort(entry)
    return entry[order], every.data[order]


def places(array: np.ndarray, *others: np.ndarray) -> np.ndarray:
    """Places of the flattened array that are not zero or are named, in their order; all of an array that is not thin."""
    if not is_thin(array):
        return np.arange(array.size)
    return np.unique(np.concatenate([np.flatnonzero(array), *others]))


SELECTED_PART = 0.5
"""Part of an array's places below which it is evaluated there alone."""
ENTRIES_AT_ONCE = 10_000
"""Entries of all polynomials that are evaluated at once: of more, what a call of numpy costs beside its work is nothing."""


@dataclass(frozen=True)
class Derivatives:
    """Derivatives of an array by the parameters at the nominal design, all non-zero entries of all parameters in one list."""

    parameter: np.ndarray  # (n,) number of the parameter
    entry: np.ndarray  # (n,) place in the flattened array
    value: np.ndarray  # (n,)

    def by(self, parameter: int) -> tuple[np.ndarray, np.ndarray]:
        """Derivative by one parameter: places in the flattened array and values there."""
        here = self.parameter == parameter
        return self.entry[here], self.value[here]

    def renumbered(self, numbers: np.ndarray) -> Derivatives:
        """Derivatives with other parameter numbers, without those whose new number is negative."""
        here = numbers[self.parameter] >= 0
        return Derivatives(numbers[self.parameter][here], self.entry[here], self.value[here])

    def __add__(self, other: Derivatives) -> Derivatives:
        return Derivatives(*(np.concatenate([getattr(self, f.name), getattr(other, f.name)]) for f in fields(self)))

    def depends_on(self, parameter: int) -> bool:
        """Whether there is an entry for the parameter."""
        return parameter in self._parameters

    def depends_on_any(self, parameters: Collection[int]) -> bool:
        """Whether there is an entry for any of the parameters."""
        return not self._parameters.isdisjoint(parameters)

    @cached_property
    def _parameters(self) -> frozenset[int]:
        return frozenset(np.unique(self.parameter).tolist())


@dataclass(frozen=True)
class SparsePolynomial:
    """Exact dependence of an array on the parameters p, a sum of terms with few non-zero entries each.

        value(p) = sum_k c_k prod_j p[factor_kj] ** power_kj

    A term has few factors: the four numbers of one group of finite elements. A factor of -1 is none, its power is 0.
    """

    factor: np.ndarray  # (n_terms, n_factors) numbers of parameters
    power: np.ndarray  # (n_terms, n_factors) whole numbers
    term: np.ndarray  # (n,) k of every non-zero entry of c
    entry: np.ndarray  # (n,) its place in the flattened array
    value: np.ndarray  # (n,) c_k there

    def __call__(self, p: np.ndarray, size: int) -> np.ndarray:
        """The flattened array (size,) at parameters p (n_parameters,), real or complex."""
        return scattered(self.entry, self._weights(p, self.power)[self.term] * self.value, size)

    def on(self, places: np.ndarray) -> SparsePolynomial:
        """Polynomial of the array's values at some places in their order, which include all that are not zero."""
        return replace(self, entry=np.searchsorted(places, self.entry))

    def rates(self, p: np.ndarray, slopes: Slopes | None = None) -> Derivatives:
        """Derivatives by all parameters, or by those of `slopes_by`; places can occur more than once."""
        parameter, entry, value, term, factor = slopes or self.slopes_by(np.arange(len(p)))
        slope = self.power.T * np.prod(np.append(p, 1.0)[self.factor] ** self._lowered, axis=2)
        return Derivatives(parameter, entry, slope[factor, term] * value)

    def slopes_by(self, numbers: np.ndarray) -> Slopes:
        """Entries of the derivatives by parameters with other numbers, without those whose new number is negative."""
        factor, place = np.nonzero(np.append(numbers, -1)[self.factor[self.term].T] >= 0)
        term = self.term[place]
        return Slopes(numbers[self.factor[term, factor]], self.entry[place], self.value[place], term, factor)

    @cached_property
    def _lowered(self) -> np.ndarray:
        """Powers of the derivatives of all terms by each of their factors, (n_factors, n_terms, n_factors)."""
        lowered = self.power - np.eye(self.factor.shape[1], dtype=int)[:, None]
        return np.where(self.factor >= 0, lowered, 0)

    def depends_on(self, parameter: int) -> bool:
        """Whether the parameter occurs."""
        return parameter in self._parameters

    def depends_on_any(self, parameters: Collection[int]) -> bool:
        """Whether any of the parameters occurs."""
        return not self._parameters.isdisjoint(parameters)

    @cached_property
    def _parameters(self) -> frozenset[int]:
        return frozenset(np.unique(self.factor).tolist())

    def _weights(self, p: np.ndarray, power: np.ndarray) -> np.ndarray:
        return np.prod(np.append(p, 1.0)[self.factor] ** power, axis=1)  # a factor of -1 is the 1 at the end

    @classmethod
    def joined(cls, polynomials: Sequence[SparsePolynomial], sizes: Sequence[int]) -> SparsePolynomial:
        """Polynomial of several arrays of the given sizes, one behind the other."""
        if len(polynomials) == 1:
            return polynomials[0]
        width, terms, places = max(each.factor.shape[1] for each in polynomials), 0, 0
        parts = []
        for each, size in zip(polynomials, sizes, strict=True):
            none = ((0, 0), (0, width - each.factor.shape[1]))
            factor, power = np.pad(each.factor, none, constant_values=-1), np.pad(each.power, none)
            parts.append((factor, power, each.term + terms, each.entry + places, each.value))
            terms, places = terms + len(each.factor), places + size
        return cls(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


class Slopes(NamedTuple):
    """Entries of a polynomial's derivatives that do not depend on the parameters' values: one for every factor of every entry."""

    parameter: np.ndarray  # its number
    entry: np.ndarray  # place in the flattened array
    value: np.ndarray  # c_k there
    term: np.ndarray  # k
    factor: np.ndarray  # j


class Told(NamedTuple):
    """Nominal values, polynomial and derivatives of an array; if few of its places can be nonzero, on those alone."""

    here: np.ndarray | slice  # places in the flattened array, ascending, or all
    own: np.ndarray  # what stands there at the nominal design
    polynomial: SparsePolynomial | None  # whose entries, as those of the tangents, are places among these
    tangents: dict[int, tuple[np.ndarray, np.ndarray]]  # parameter -> places and values of its derivative
    complex: bool  # whether the polynomial meets a complex parameter


def told_of(
    nominal: np.ndarray,
    polynomial: SparsePolynomial | None,
    tangents: Mapping[int, tuple[np.ndarray, np.ndarray]],
    steps: Collection[int],
) -> Told:
    """What is known of an array from its nominal values, polynomial and derivatives; some parameters make complex `steps`."""
    filled = [] if polynomial is None else [polynomial.entry]
    here = np.unique(np.concatenate([np.flatnonzero(nominal), *filled, *(entry for entry, _ in tangents.values())]))
    stepped = polynomial is not None and polynomial.depends_on_any(steps)
    if len(here) > SELECTED_PART * nominal.size:
        return Told(slice(None), nominal.ravel(), polynomial, dict(tangents), stepped)
    fewer = None if polynomial is None else polynomial.on(here)
    tangents = {k: (np.searchsorted(here, entry), value) for k, (entry, value) in tangents.items()}
    return Told(here, nominal.ravel()[here], fewer, tangents, stepped)


class Together(NamedTuple):
    """Polynomials of several items, evaluated at once, all at real parameters or all at complex ones."""

    places: dict[str, slice]  # item -> where its values are among those of all
    polynomial: SparsePolynomial
    complex: bool

    @classmethod
    def of(cls, told: Mapping[str, Told]) -> Together:
        """Joint polynomial of several items, each given by what is known of it."""
        ends = np.cumsum([len(each.own) for each in told.values()]).tolist()
        places = {item: slice(end - len(each.own), end) for (item, each), end in zip(told.items(), ends, strict=True)}
        found: list[Any] = [each.polynomial for each in told.values()]
        joined = SparsePolynomial.joined(found, [len(each.own) for each in told.values()])
        return cls(places, joined, any(each.complex for each in told.values()))

    def __call__(self, p: np.ndarray) -> dict[str, np.ndarray]:
        """Values of every item, by its name, on the item's places."""
        flat = self.polynomial(p if self.complex else np.real(p), max(place.stop for place in self.places.values()))
        return {item: flat[place] for item, place in self.places.items()}


def scattered(entry: np.ndarray, value: np.ndarray, size: int) -> np.ndarray:
    """Sum of values by place: (size,), real or complex."""
    found = np.bincount(entry, np.real(value), size)
    return found + 1j * np.bincount(entry, np.imag(value), size) if np.iscomplexobj(value) else found
