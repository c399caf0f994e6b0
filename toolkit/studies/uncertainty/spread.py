"""Statistics of one uncertain response."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from toolkit.studies.study.study_file import Limit


@dataclass(frozen=True)
class Sampled:
    """Statistics of a response at random designs.

    Attributes
    ----------
    runs
        Designs that could be solved.
    mean, sigma
        Of the response, each with its standard error.
    quantiles
        Share -> value.
    beyond
        Limit in words -> share of the designs beyond it, with its standard error.
    missed
        Root of the mean square error of the polynomials at these designs, in parts of sigma: no random number is in it but the designs.
    """

    runs: int
    mean: tuple[float, float]
    sigma: tuple[float, float]
    quantiles: Mapping[float, float]
    beyond: Mapping[str, tuple[float, float]]
    missed: float

    def record(self) -> dict[str, Any]:
        """The statistics at random designs as part of a JSON object."""
        return {
            "runs": self.runs,
            "mean": {"value": self.mean[0], "standard_error": self.mean[1]},
            "sigma": {"value": self.sigma[0], "standard_error": self.sigma[1]},
            "quantiles": {f"{share:g}": value for share, value in self.quantiles.items()},
            "beyond": {limit: {"value": p, "standard_error": error} for limit, (p, error) in self.beyond.items()},
            "polynomials_error": self.missed,
        }


@dataclass(frozen=True)
class Neighbour:
    """Statistics by polynomials of another degree: mean, sigma, and quantiles (share -> value)."""

    degree: int
    mean: float
    sigma: float
    quantiles: Mapping[float, float]

    def record(self) -> dict[str, Any]:
        """The statistics by polynomials of another degree as part of a JSON object."""
        quantiles = {f"{share:g}": value for share, value in self.quantiles.items()}
        return {"degree": self.degree, "mean": self.mean, "sigma": self.sigma, "quantiles": quantiles}


@dataclass(frozen=True)
class Spread:
    """Statistics of an uncertain response.

    Attributes
    ----------
    unit
        Label of its unit.
    mean, sigma
        By the polynomials; nan with all that follows from them where designs are cut off, of which only the least value is known.
    first_order
        Both by value and derivatives at the means alone; None if that design could not be solved.
    quantiles
        Share -> value.
    beyond
        Limit in words -> probability that the response is beyond it.
    alone, together
        Uncertain number -> share of the variance that comes from it alone, and from it together with all others (Sobol's indices of the
        first order and total ones); None where numbers go together.
    degree
        Degree of the polynomials.
    left_out
        Their error at designs that were left out of the fit, in parts of the standard deviation of the solved values.
    neighbour
        What polynomials of one degree less or more say; None if no others are possible.
    straight_sigma
        Sigma if the polynomials went on straight beyond the farthest designs that were solved.
    error
        By how much mean and sigma may be off: the root of the mean square error at designs that were left out, which bounds both, and what
        straight tails change.
    sampled
        The same at random designs; None without them.
    """

    unit: str
    mean: float
    sigma: float
    first_order: tuple[float, float] | None
    quantiles: Mapping[float, float]
    beyond: Mapping[str, float]
    alone: Mapping[str, float] | None
    together: Mapping[str, float] | None
    degree: int
    left_out: float
    neighbour: Neighbour | None
    straight_sigma: float
    error: float
    sampled: Sampled | None = None

    def record(self) -> dict[str, Any]:
        """The statistics of the response as part of a JSON object."""
        return {
            "mean": self.mean,
            "sigma": self.sigma,
            "unit": self.unit,
            "first_order": None if self.first_order is None else dict(zip(("mean", "sigma"), self.first_order, strict=True)),
            "quantiles": {f"{share:g}": value for share, value in self.quantiles.items()},
            "beyond": dict(self.beyond),
            "sobol_first": None if self.alone is None else dict(self.alone),
            "sobol_total": None if self.together is None else dict(self.together),
            "degree": self.degree,
            "leave_one_out_error": self.left_out,
            "neighbour": None if self.neighbour is None else self.neighbour.record(),
            "sigma_straight_tails": self.straight_sigma,
            "error": self.error,
            "monte_carlo": None if self.sampled is None else self.sampled.record(),
        }


def without_statistics(spread: Spread) -> Spread:
    """The spread of a response that is cut off at some designs, without all statistics but shares beyond limits.

    These shares of random designs are kept because the limits lie below the cut.
    """
    nan, seen = math.nan, spread.sampled
    none = dict.fromkeys(spread.quantiles, nan)
    if seen is not None:
        seen = replace(seen, mean=(nan, nan), sigma=(nan, nan), quantiles=none, missed=nan)
    return replace(
        spread, mean=nan, sigma=nan, first_order=None, quantiles=none, beyond=dict.fromkeys(spread.beyond, nan), alone=None,
        together=None, left_out=nan, neighbour=None, straight_sigma=nan, error=nan, sampled=seen,
    )  # fmt: skip


def limits_of(limit: Limit | None) -> dict[str, tuple[float, float]]:
    """Ways to be beyond a limit: a phrase -> the limit, and 1 if beyond is above it or -1 if it is below."""
    low, high = limit.limits if limit else (None, None)
    found = {} if low is None else {f"below {low:g}": (low, -1.0)}
    return found | ({} if high is None else {f"above {high:g}": (high, 1.0)})


def beyond(values: np.ndarray, limit: Limit | None) -> dict[str, float]:
    """Shares of values beyond a limit."""
    return {words: float(np.mean(sign * (values - at) > 0)) for words, (at, sign) in limits_of(limit).items()}


def quantiles_of(values: np.ndarray, shares: tuple[float, ...]) -> dict[float, float]:
    """Quantiles of values, share -> the value below which so many are."""
    return dict(zip(shares, map(float, np.quantile(values, shares)), strict=True))


NORMAL = 3.0
"""Kurtosis of a normal distribution, taken as the least one: few designs show less than there is."""


def sampled(values: np.ndarray, polynomials: np.ndarray, shares: tuple[float, ...], limit: Limit | None) -> Sampled:
    """Statistics of a response at random designs, with the error of its polynomials there."""
    count, mean, sigma = len(values), float(np.mean(values)), float(np.std(values, ddof=1))
    fourth = float(np.mean((values - mean) ** 4)) / sigma**4 if sigma else 1.0
    sigma_error = sigma / 2 * float(np.sqrt((max(fourth, NORMAL) - 1) / count))
    share = beyond(values, limit)
    errors = {words: (p, float(np.sqrt(max(p * (1 - p), 1 / count) / count))) for words, p in share.items()}
    missed = float(np.sqrt(np.mean((values - polynomials) ** 2))) / sigma if sigma else 0.0
    return Sampled(
        count, (mean, sigma / float(np.sqrt(count))), (sigma, sigma_error), quantiles_of(values, shares), errors, missed
    )
