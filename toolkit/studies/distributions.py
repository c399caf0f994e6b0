"""Uncertain numbers: the distribution of each, and all of them together as functions of independent germs.

The distribution of one number, and the germ that it is made from.

A germ is normal (cut off where the number is) or uniform, with mean 0 and standard deviation 1 before it is cut off. A number follows from
its germ by a straight line or, if it is lognormal, by the exponential of one, so that polynomials of germs fit responses well.

Numbers that go together are made from normal germs whose correlation is chosen so that the numbers have the one that is wanted (Nataf).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri

from toolkit.description.description import Description, Number, Pair, Positive, Quantity
from toolkit.description.design import check_shares
from toolkit.description.run_options import Count, Seed
from toolkit.foundation.errors import InputError

Coefficient = Annotated[float, Field(strict=True, gt=-1, lt=1), Quantity("none")]
Share = Annotated[float, Field(strict=True, gt=0, lt=1), Quantity("none")]


class Uncertain(Description):
    """The distribution of a number of the scene, or of several that one variable moves.

    Attributes
    ----------
    distribution
        "normal", "lognormal" or "uniform".
    mean
        Of a normal or lognormal number; by default what the scene has.
    sigma
        Standard deviation of a normal or lognormal number, in its own unit.
    between
        Least and largest value. A uniform number needs them; they cut off a normal or lognormal one, whose mean and sigma are those before.
    of
        Paths of numbers of one unit that move together: the distribution is that of by how much, 0 where the scene stands. Without it the
        number is the one that its own name leads to, a path or a short name of the scene.
    factors
        Of each of these numbers: by how much it moves where the variable moves by one. All are one by default.
    """

    distribution: Literal["normal", "lognormal", "uniform"]
    mean: Number | None = None
    sigma: Positive | None = None
    between: Pair | None = None
    of: tuple[str, ...] | None = Field(default=None, min_length=1)
    factors: tuple[Number, ...] | None = None

    @model_validator(mode="after")
    def _fit(self) -> Self:
        if self.between is not None and self.between[0] >= self.between[1]:
            low, high = self.between
            raise ValueError(
                f"between = [{low:g}, {high:g}] holds nothing; write the smaller bound first, and the larger one second"
            )
        if self.distribution == "uniform" and (self.between is None or self.mean is not None or self.sigma is not None):
            raise ValueError(
                "a uniform number is given by `between` alone: its least and largest value; leave out mean and sigma"
            )
        if self.distribution != "uniform" and self.sigma is None:
            raise ValueError(
                f"a {self.distribution} number needs `sigma`, its standard deviation; its mean is the scene's if it is left out"
            )
        check_shares(self.of, self.factors)
        return self


class Correlation(Description):
    """How two uncertain numbers go together.

    Attributes
    ----------
    of
        Their names.
    coefficient
        Pearson's coefficient of correlation of the numbers themselves, above -1 and below 1.
    """

    of: tuple[str, str]
    coefficient: Coefficient

    @model_validator(mode="after")
    def _fit(self) -> Self:
        if self.of[0] == self.of[1]:
            raise ValueError(f"{self.of[0]!r} goes together with itself anyway; name two numbers")
        return self


class Uncertainty(Description):
    """How `ffrf uncertainty` finds out what follows from uncertain numbers.

    Attributes
    ----------
    runs
        Designs that are solved with gradients; the first is the one of all means.
    degree
        Of the polynomials that values and gradients are fitted by; by default the one whose leave-one-out error is least.
    correlations
        Of pairs of uncertain numbers; all others are independent.
    quantiles
        Shares of all cases below the values that are asked for.
    responses
        Which are wanted; by default all that the analysis has, and the load margin if a constraint or the objective asks for it.
    monte_carlo
        Random designs that are solved without gradients, to judge the polynomials by; 0 for none.
    warm_starts
        Whether statics of all designs begins in the equilibrium of the first, which is several times faster, but can lead beyond a
        snap-through.
    seed
        Another one gives other designs.
    points
        Of a robust objective or limit: at how many points of the uncertain numbers every design is solved; the first is the one of all
        means. By default half as many again as a polynomial of degree 2 has coefficients; more points take a higher degree.
    """

    runs: Annotated[int, Field(strict=True, ge=2, le=1_000_000)] = 20
    degree: Count | None = None
    correlations: tuple[Correlation, ...] = ()
    quantiles: tuple[Share, ...] = (0.01, 0.05, 0.5, 0.95, 0.99)
    responses: tuple[str, ...] | None = Field(default=None, min_length=1)
    monte_carlo: Annotated[int, Field(strict=True, ge=0, le=1_000_000)] = 0
    warm_starts: bool = False
    seed: Seed = 0
    points: Annotated[int | None, Field(strict=True, ge=3, le=10_000)] = None


HALF = float(np.sqrt(3.0))
"""Largest value of a uniform germ, whose standard deviation is 1."""


@dataclass(frozen=True)
class Marginal:
    """Distribution of one number.

    Attributes
    ----------
    middle, width
        Number, or its logarithm, of a germ g: middle + width g.
    logarithmic
        Whether it is the logarithm.
    uniform
        Whether the germ is uniform; otherwise it is normal.
    least, largest
        Bounds of the germ.
    """

    middle: float
    width: float
    logarithmic: bool
    uniform: bool
    least: float = -np.inf
    largest: float = np.inf

    def number(self, germ: np.ndarray) -> np.ndarray:
        """Numbers that follow from germs."""
        straight = self.middle + self.width * germ
        return np.exp(straight) if self.logarithmic else straight

    def slope(self, germ: np.ndarray) -> np.ndarray:
        """Derivatives of the numbers by their germs."""
        return self.width * (self.number(germ) if self.logarithmic else np.ones_like(germ))

    def germ(self, number: float) -> float:
        """Germ that a number follows from."""
        return ((float(np.log(number)) if self.logarithmic else number) - self.middle) / self.width

    def quantile(self, share: np.ndarray) -> np.ndarray:
        """Quantiles of the germ: values below which shares of all cases are."""
        if self.uniform:
            return HALF * (2 * share - 1)
        low, high = ndtr(self.least), ndtr(self.largest)
        found: np.ndarray = np.clip(ndtri(low + share * (high - low)), self.least, self.largest)
        return found

    def density(self, germ: np.ndarray) -> np.ndarray:
        """Probability density of germs within their bounds."""
        if self.uniform:
            return np.full_like(germ, 0.5 / HALF)
        return np.exp(-germ * germ / 2) / np.sqrt(2 * np.pi) / (ndtr(self.largest) - ndtr(self.least))

    @property
    def mean(self) -> float:
        """Mean of the number."""
        if self.logarithmic:
            return self._exponential(1)
        return self.middle + self.width * self._moment(1)

    @property
    def sigma(self) -> float:
        """Standard deviation of the number."""
        if self.logarithmic:
            return float(np.sqrt(self._exponential(2) - self._exponential(1) ** 2))
        return self.width * float(np.sqrt(self._moment(2) - self._moment(1) ** 2))

    @property
    def infinite(self) -> bool:
        """Whether nothing is cut off from a normal germ."""
        return not self.uniform and np.isinf(self.least) and np.isinf(self.largest)

    def _exponential(self, power: int) -> float:
        """Mean of a power of the lognormal number: the normal germ is moved by power x width."""
        by = power * self.width
        share = (ndtr(self.largest - by) - ndtr(self.least - by)) / (ndtr(self.largest) - ndtr(self.least))
        return float(np.exp(power * self.middle + by * by / 2) * share)

    def _moment(self, power: int) -> float:
        """Mean of the germ, or of its square."""
        if self.uniform:
            return 0.0 if power == 1 else 1.0
        weights = [float(np.exp(-a * a / 2) / np.sqrt(2 * np.pi)) for a in (self.least, self.largest)]
        share = float(ndtr(self.largest) - ndtr(self.least))
        if power == 1:
            return (weights[0] - weights[1]) / share
        ends = [0.0 if np.isinf(a) else a * w for a, w in zip((self.least, self.largest), weights, strict=True)]
        return 1.0 + (ends[0] - ends[1]) / share


def marginal_of(name: str, described: Uncertain, own: float) -> Marginal:
    """The distribution of a number that stands at `own` in the scene.

    Raises
    ------
    InputError
        A lognormal number is not positive, or next to nothing of it lies between the bounds.
    """
    low, high = described.between or (-np.inf, np.inf)
    if described.distribution == "uniform":
        return Marginal((low + high) / 2, (high - low) / (2 * HALF), False, True, -HALF, HALF)
    mean, sigma = own if described.mean is None else described.mean, described.sigma or 0.0
    if described.distribution == "lognormal":
        if mean <= 0 or high <= 0:
            raise InputError(f"uncertain.{name}: a lognormal number is positive, but its mean is {mean:g}. Write a normal one.")
        width = float(np.sqrt(np.log1p((sigma / mean) ** 2)))
        whole = Marginal(float(np.log(mean)) - width**2 / 2, width, True, False)
        ends = (whole.germ(low) if low > 0 else -np.inf, whole.germ(high) if np.isfinite(high) else np.inf)
    else:
        whole = Marginal(mean, sigma, False, False)
        ends = ((low - mean) / sigma, (high - mean) / sigma)
    if not ndtr(ends[1]) - ndtr(ends[0]) > LEAST_PROBABILITY:
        raise InputError(
            f"uncertain.{name}: less than {LEAST_PROBABILITY:g} of a {described.distribution} number with mean {mean:g} and "
            f"sigma {sigma:g} lies between {low:g} and {high:g}. Move the bounds to where the number is."
        )
    return Marginal(whole.middle, whole.width, whole.logarithmic, False, *map(float, ends))


LEAST_PROBABILITY = 1e-3
"""Least probability that the bounds of a number may leave; with less, only the tail of its distribution would remain."""


QUADRATURE_POINTS = 40
"""Number of quadrature points for each of the two numbers whose correlation is found."""
CERTAIN_CORRELATION = 1e-9
"""Least distance of a correlation coefficient from one."""
NORMAL = Marginal(0.0, 1.0, False, False)


@dataclass(frozen=True)
class JointDistribution:
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


def joint_of(names: Sequence[str], marginals: Mapping[str, Marginal], correlations: Sequence[Correlation]) -> JointDistribution:
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
    found = JointDistribution(tuple(marginals[name] for name in names), matrix)
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
    points, weights = np.polynomial.hermite_e.hermegauss(QUADRATURE_POINTS)
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

    ends = correlation(-1 + CERTAIN_CORRELATION), correlation(1 - CERTAIN_CORRELATION)
    if ends[0] >= 0 or ends[1] <= 0:
        raise InputError(
            f"uncertainty.correlations: numbers of these distributions cannot have a correlation of {wanted:g}, at most from "
            f"{ends[0] + wanted:.3g} to {ends[1] + wanted:.3g}. Take a smaller one."
        )
    return float(brentq(correlation, -1 + CERTAIN_CORRELATION, 1 - CERTAIN_CORRELATION, xtol=1e-12))
