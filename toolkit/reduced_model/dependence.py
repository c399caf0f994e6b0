"""Arrays of a reduced model as functions of its parameters: sparse polynomials, and derivatives for what is none."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

FEW = 0.5
"""Part of an array's places below which it is evaluated there alone."""


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
        """With other numbers of the parameters, without those whose new number is negative."""
        here = numbers[self.parameter] >= 0
        return Derivatives(numbers[self.parameter][here], self.entry[here], self.value[here])

    def __add__(self, other: Derivatives) -> Derivatives:
        return Derivatives(*(np.concatenate([getattr(self, f.name), getattr(other, f.name)]) for f in fields(self)))

    def depends_on(self, parameter: int) -> bool:
        """Whether there is an entry for the parameter."""
        return parameter in self._parameters

    def depends_on_any(self, parameters: Collection[int]) -> bool:
        """Whether there is one of them."""
        return not self._parameters.isdisjoint(parameters)

    @cached_property
    def _parameters(self) -> frozenset[int]:
        return frozenset(np.unique(self.parameter).tolist())


@dataclass(frozen=True)
class Polynomial:
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

    def on(self, places: np.ndarray) -> Polynomial:
        """That of the values at some places in their order, among which are all that are not zero."""
        return replace(self, entry=np.searchsorted(places, self.entry))

    def rates(self, p: np.ndarray) -> Derivatives:
        """Derivatives by all parameters, one entry for every factor of every term; places can occur more than once."""
        found = []
        for j in range(self.factor.shape[1]):
            lowered = self.power - (np.arange(self.factor.shape[1]) == j)
            slope = self.power[:, j] * self._weights(p, np.where(self.factor >= 0, lowered, 0))
            here = self.factor[self.term, j] >= 0
            term = self.term[here]
            found.append((self.factor[term, j], self.entry[here], slope[term] * self.value[here]))
        return Derivatives(*(np.concatenate(arrays) for arrays in zip(*found, strict=True)))

    def depends_on(self, parameter: int) -> bool:
        """Whether the parameter occurs."""
        return parameter in self._parameters

    def depends_on_any(self, parameters: Collection[int]) -> bool:
        """Whether there is one of them."""
        return not self._parameters.isdisjoint(parameters)

    @cached_property
    def _parameters(self) -> frozenset[int]:
        return frozenset(np.unique(self.factor).tolist())

    def _weights(self, p: np.ndarray, power: np.ndarray) -> np.ndarray:
        return np.prod(np.append(p, 1.0)[self.factor] ** power, axis=1)  # a factor of -1 is the 1 at the end


class Told(NamedTuple):
    """What is known of an array, on those of its places alone that are not zero or can become so, if these are few."""

    here: np.ndarray | slice  # places in the flattened array, ascending, or all
    polynomial: Polynomial | None  # whose entries, as those of the tangents, are places among these
    tangents: dict[int, tuple[np.ndarray, np.ndarray]]  # parameter -> places and values of its derivative


def told_of(nominal: np.ndarray, polynomial: Polynomial | None, tangents: Mapping[int, tuple[np.ndarray, np.ndarray]]) -> Told:
    """Of an array at the nominal design, its polynomial, and derivatives by some parameters."""
    filled = [] if polynomial is None else [polynomial.entry]
    here = np.unique(np.concatenate([np.flatnonzero(nominal), *filled, *(entry for entry, _ in tangents.values())]))
    if len(here) > FEW * nominal.size:
        return Told(slice(None), polynomial, dict(tangents))
    fewer = None if polynomial is None else polynomial.on(here)
    return Told(here, fewer, {k: (np.searchsorted(here, entry), value) for k, (entry, value) in tangents.items()})


def scattered(entry: np.ndarray, value: np.ndarray, size: int) -> Any:
    """Sum of values by place: (size,), real or complex."""
    found = np.bincount(entry, np.real(value), size)
    return found + 1j * np.bincount(entry, np.imag(value), size) if np.iscomplexobj(value) else found
