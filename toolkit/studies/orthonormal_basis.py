"""Polynomials of independent germs that are orthonormal for their distributions, and points of Sobol's sequence."""

from __future__ import annotations

import math
from dataclasses import dataclass
from importlib.util import find_spec
from math import comb
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial import polynomial

from toolkit.foundation.errors import InputError
from toolkit.studies.distributions import Marginal

if TYPE_CHECKING:
    from scipy.stats.qmc import Sobol


@dataclass(frozen=True)
class Basis:
    """Products of polynomials of the germs, of all degrees up to a largest one.

    Attributes
    ----------
    coefficients
        Coefficients of every germ's polynomials by their degrees: (degrees, powers), the power 0 first.
    degrees
        Degrees of every product in the germs, (products, n); the first product is the constant.
    """

    coefficients: tuple[np.ndarray, ...]
    degrees: np.ndarray

    def values(self, germs: np.ndarray) -> np.ndarray:
        """Values of all products at germs (count, n): (count, products)."""
        found = np.ones((len(germs), len(self.degrees)))
        for each, column, degrees in zip(self.coefficients, germs.T, self.degrees.T, strict=True):
            found *= polynomial.polyval(column, each.T).T[:, degrees]
        return found

    def slopes(self, germs: np.ndarray) -> np.ndarray:
        """Derivatives of all products by the germs, (count, n, products)."""
        single = [polynomial.polyval(g, each.T).T for each, g in zip(self.coefficients, germs.T, strict=True)]
        derived = [
            polynomial.polyval(g, polynomial.polyder(each.T)).T for each, g in zip(self.coefficients, germs.T, strict=True)
        ]
        found = np.ones((len(germs), germs.shape[1], len(self.degrees)))
        for j in range(germs.shape[1]):
            for k, degrees in enumerate(self.degrees.T):
                found[:, j] *= (derived if j == k else single)[k][:, degrees]
        return found


def basis_of(germs: tuple[Marginal, ...], degree: int) -> Basis:
    """Basis of all products up to a total degree.

    Raises
    ------
    InputError
        OpenTURNS is not installed.
    """
    if find_spec("openturns") is None:
        raise InputError(
            "polynomials of uncertain numbers need the package openturns, which is not installed. Install: pip install "
            "'ffrf-toolkit[studies]'."
        )
    degrees = np.array(sorted(_degrees(len(germs), degree), key=lambda each: (sum(each), [-k for k in each])))
    return Basis(tuple(_single(each, degree) for each in germs), degrees)


def size_of(n: int, degree: int) -> int:
    """Number of products of n germs up to a total degree."""
    return comb(n + degree, degree)


def _degrees(n: int, most: int) -> list[tuple[int, ...]]:
    if n == 0:
        return [()]
    return [(k, *rest) for k in range(most + 1) for rest in _degrees(n - 1, most - k)]


def _single(germ: Marginal, degree: int) -> np.ndarray:
    """Polynomials of one germ, orthonormal for its distribution."""
    import openturns as ot

    low, high = float(germ.least), float(germ.largest)
    if germ.uniform:
        distribution, unit = ot.Uniform(-1.0, 1.0), high
    elif germ.infinite:
        distribution, unit = ot.Normal(), 1.0
    else:
        bounds = ot.Interval([low], [high], [bool(np.isfinite(low))], [bool(np.isfinite(high))])
        distribution, unit = ot.TruncatedDistribution(ot.Normal(), bounds), 1.0
    family = ot.StandardDistributionPolynomialFactory(distribution)
    found = np.zeros((degree + 1, degree + 1))
    for k in range(degree + 1):
        found[k, : k + 1] = np.array(family.build(k).getCoefficients()) / unit ** np.arange(k + 1)
    return found


def scrambled(count: int, dimension: int, seed: int) -> np.ndarray:
    """The first scrambled points, (count, dimension)."""
    power = max(1, math.ceil(math.log2(count)))
    found: np.ndarray = _sequence(dimension, scramble=True, rng=np.random.default_rng(seed)).random_base2(power)[:count]
    return found


def plain(count: int, dimension: int) -> np.ndarray:
    """The first points as they are, (count, dimension), without the very first, which is a corner."""
    power = max(1, math.ceil(math.log2(count + 1)))
    found: np.ndarray = _sequence(dimension, scramble=False).random_base2(power)[1 : count + 1]
    return found


def _sequence(dimension: int, **options: Any) -> Sobol:
    """The sequence; the package is imported here, since it takes as long as a fifth of the program, and designs are solved without it."""
    from scipy.stats.qmc import Sobol

    return Sobol(dimension, **options)
