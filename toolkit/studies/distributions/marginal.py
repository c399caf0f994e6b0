"""The distribution of one number, and the germ that it is made from.

A germ is normal (cut off where the number is) or uniform, with mean 0 and standard deviation 1 before it is cut off. A number follows from
its germ by a straight line or, if it is lognormal, by the exponential of one, so that polynomials of germs fit responses well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, ndtri

from toolkit.foundation.errors import InputError
from toolkit.studies.distributions.uncertain_numbers import Uncertain

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
    if not ndtr(ends[1]) - ndtr(ends[0]) > LEAST:
        raise InputError(
            f"uncertain.{name}: less than {LEAST:g} of a {described.distribution} number with mean {mean:g} and sigma {sigma:g} lies "
            f"between {low:g} and {high:g}. Move the bounds to where the number is."
        )
    return Marginal(whole.middle, whole.width, whole.logarithmic, False, *map(float, ends))


LEAST = 1e-3
"""Least probability that the bounds of a number may leave; with less, only the tail of its distribution would remain."""
