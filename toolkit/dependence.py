"""Arrays of a reduced model as functions of its parameters: sparse polynomials, and derivatives for what is none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np


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

    def rate(self, p: np.ndarray, parameter: int) -> tuple[np.ndarray, np.ndarray]:
        """Derivative by one parameter: places in the flattened array and values there; a place can occur more than once."""
        hit = self.factor == parameter
        slope = np.sum(self.power * hit, axis=1) * self._weights(p, self.power - hit)
        here = hit.any(axis=1)[self.term]
        return self.entry[here], slope[self.term[here]] * self.value[here]

    def depends_on(self, parameter: int) -> bool:
        """Whether the parameter occurs."""
        return bool(np.any(self.factor == parameter))

    def _weights(self, p: np.ndarray, power: np.ndarray) -> np.ndarray:
        return np.prod(np.append(p, 1.0)[self.factor] ** power, axis=1)  # a factor of -1 is the 1 at the end


@dataclass(frozen=True)
class Derivatives:
    """Derivatives of an array by the parameters at the nominal design, all non-zero entries of all parameters in one list."""

    parameter: np.ndarray  # (n,) number of the parameter
    entry: np.ndarray  # (n,) place in the flattened array
    value: np.ndarray  # (n,)

    def rate(self, parameter: int) -> tuple[np.ndarray, np.ndarray]:
        """Derivative by one parameter: places in the flattened array and values there."""
        here = self.parameter == parameter
        return self.entry[here], self.value[here]

    def depends_on(self, parameter: int) -> bool:
        """Whether there is an entry for the parameter."""
        return bool(np.any(self.parameter == parameter))


def scattered(entry: np.ndarray, value: np.ndarray, size: int) -> Any:
    """Sum of values by place: (size,), real or complex."""
    found = np.bincount(entry, np.real(value), size)
    return found + 1j * np.bincount(entry, np.imag(value), size) if np.iscomplexobj(value) else found
