"""All uncertain numbers together: independent germs, and the numbers that follow from them.

Numbers that go together are made from normal germs whose correlation is chosen so that the numbers have the one that is wanted (Nataf).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr

from toolkit.foundation.errors import InputError
from toolkit.studies.distributions.marginal import Marginal
from toolkit.studies.distributions.uncertain_numbers import Correlation

POINTS = 40
"""Number of quadrature points for each of the two numbers whose correlation is found."""
NEAR = 1e-9
"""Least distance of a correlation coefficient from one."""
NORMAL = Marginal(0.0, 1.0, False, False)


@dataclass(frozen=True)
class Joint:
    """Joint distribution of uncertain numbers.

    Attributes
    ----------
    marginals
        Distribution of each number.
    correlation
        Coefficients of the numbers themselves, (n, n).
    """

    marginals: tuple[Marginal, ...]
    correlation: np.ndarray

    @property
    def together(self) -> np.ndarray:
        """Whether each number is correlated with another one, (n,)."""
        found: np.ndarray = np.any(self.correlation != np.eye(len(self.marginals)), axis=1)
        return found

    @property
    def germs(self) -> tuple[Marginal, ...]:
        """Distributions of the independent germs."""
        return tuple(NORMAL if tied else each for each, tied in zip(self.marginals, self.together, strict=True))

    @property
    def mean(self) -> np.ndarray:
        """Means of the numbers, (n,)."""
        return np.array([each.mean for each in self.marginals])

    @property
    def covariance(self) -> np.ndarray:
        """Covariance matrix of the numbers, (n, n)."""
        sigmas = np.array([each.sigma for each in self.marginals])
        return self.correlation * np.outer(sigmas, sigmas)

    @cached_property
    def root(self) -> np.ndarray:
        """Lower triangular Cholesky factor of the correlation of the normal germs that correlated numbers are made from."""
        found = np.eye(len(self.marginals))
        for i, j in combinations(range(len(found)), 2):
            if self.correlation[i, j]:
                found[i, j] = found[j, i] = _of_normals(self.marginals[i], self.marginals[j], self.correlation[i, j])
        try:
            return np.linalg.cholesky(found)
        except np.linalg.LinAlgError:
            raise InputError(
                "uncertainty.correlations: these coefficients contradict each other; no numbers go together so. Make some smaller."
            ) from None

    def germs_of(self, shares: np.ndarray) -> np.ndarray:
        """Germs (count, n) of points in the unit cube."""
        return np.column_stack([each.quantile(column) for each, column in zip(self.germs, shares.T, strict=True)])

    def numbers(self, germs: np.ndarray) -> np.ndarray:
        """Numbers (count, n) of germs."""
        return np.column_stack([each.number(g) for each, g in zip(self.marginals, self._own(germs)[0].T, strict=True)])

    def slopes(self, germs: np.ndarray) -> np.ndarray:
        """Derivatives of the numbers by the germs, (count, n, n)."""
        own, by_normal = self._own(germs)
        own_slopes = np.column_stack([each.slope(g) for each, g in zip(self.marginals, own.T, strict=True)])
        found: np.ndarray = (own_slopes * by_normal)[:, :, None] * self.root
        return found

    def germs_at_mean(self) -> np.ndarray:
        """Germs (n,) at which every number is its mean."""
        own = np.array([each.germ(each.mean) for each in self.marginals])
        normal = [_normal_of(each, g) if tied else g for each, g, tied in zip(self.marginals, own, self.together, strict=True)]
        found: np.ndarray = np.linalg.solve(self.root, np.array(normal))
        return found

    def _own(self, germs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Germs of the numbers themselves, and their derivatives by the normal germs that they are made from."""
        mixed = germs @ self.root.T
        own, slopes = mixed.copy(), np.ones_like(mixed)
        for k, (each, tied) in enumerate(zip(self.marginals, self.together, strict=True)):
            if tied and not each.infinite:
                own[:, k], slopes[:, k] = _from_normal(each, mixed[:, k])
        return own, slopes


def joint_of(names: Sequence[str], marginals: Mapping[str, Marginal], correlations: Sequence[Correlation]) -> Joint:
    """Joint distribution of all numbers with their correlations.

    Raises
    ------
    InputError
        A name is unknown, a pair is named twice, or the coefficients contradict each other or the distributions.
    """
    matrix, told = np.eye(len(names)), set()
    for each in correlations:
        for name in each.of:
            if name not in marginals:
                raise InputError(f"uncertainty.correlations: {name!r} is no uncertain number; there are {', '.join(names)}.")
        i, j = (list(names).index(name) for name in each.of)
        if frozenset((i, j)) in told:
            raise InputError(f"uncertainty.correlations: {each.of[0]!r} and {each.of[1]!r} are named twice. Leave out one.")
        told.add(frozenset((i, j)))
        matrix[i, j] = matrix[j, i] = each.coefficient
    found = Joint(tuple(marginals[name] for name in names), matrix)
    _ = found.root
    return found


def _from_normal(marginal: Marginal, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The germ of a number with the same share below it as a normal germ, and its derivative."""
    own = marginal.quantile(ndtr(normal))
    return own, NORMAL.density(normal) / marginal.density(own)


def _normal_of(marginal: Marginal, germ: float) -> float:
    """Normal germ that a germ is made from."""
    if marginal.infinite:
        return germ
    return float(brentq(lambda z: float(marginal.quantile(ndtr(np.array(z))) - germ), -8.0, 8.0, xtol=1e-14))


def _of_normals(one: Marginal, other: Marginal, wanted: float) -> float:
    """Correlation of two normal germs whose numbers have the wanted one.

    Raises
    ------
    InputError
        Numbers of these distributions cannot go together so closely.
    """
    points, weights = np.polynomial.hermite_e.hermegauss(POINTS)
    weights = weights / np.sum(weights)

    def number(marginal: Marginal, normal: np.ndarray) -> np.ndarray:
        own = normal if marginal.infinite else _from_normal(marginal, normal)[0]
        return marginal.number(own)

    first = number(one, points)

    def correlation(r: float) -> float:
        mixed = r * points[:, None] + np.sqrt(1 - r * r) * points[None, :]
        second = number(other, mixed)
        product = np.sum(weights[:, None] * weights * (first[:, None] - one.mean) * (second - other.mean))
        return float(product / (one.sigma * other.sigma)) - wanted

    ends = correlation(-1 + NEAR), correlation(1 - NEAR)
    if ends[0] >= 0 or ends[1] <= 0:
        raise InputError(
            f"uncertainty.correlations: numbers of these distributions cannot have a correlation of {wanted:g}, at most from "
            f"{ends[0] + wanted:.3g} to {ends[1] + wanted:.3g}. Take a smaller one."
        )
    return float(brentq(correlation, -1 + NEAR, 1 - NEAR, xtol=1e-12))
