"""Responses as polynomials of the germs, the statistics of each, and all that follows from uncertain numbers.

Responses as polynomials of the germs, fitted to values and gradients of some designs.

    minimise  sum over designs |c . P(g) - f|^2 + |c . dP/dg - df/dg|^2

A design tells 1 + n numbers, so that few designs suffice. How good the fit is follows from the fits without each design
(leave-one-out): the residual of a design that was left out, with its gradient, is (I - H)^-1 times the one it has, H its block of the
projection.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import count
from typing import TYPE_CHECKING

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.verdict import Verdict, finite
from toolkit.studies.distributions import Marginal
from toolkit.studies.orthonormal_basis import Basis, basis_of, size_of
from toolkit.studies.store import DesignOutcome
from toolkit.studies.study_file import Limit
from toolkit.studies.uncertain_study import UncertainStudy

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Record

HIGHEST_DEGREE = 8
"""Highest degree that is tried."""
EXACT_FIT = 1e-9
"""Error at designs left out, relative to the values' spread, below which the lowest degree is taken: round-off decides."""
EQUATIONS_PER_COEFFICIENT = 1.5
"""Wanted ratio of the number of equations to that of coefficients."""
DETERMINED_DESIGN = 1e-8
"""Least eigenvalue of I - H of a design, between 0 and 1, from which the fit without it is determined by the others."""


@dataclass(frozen=True)
class Expansion:
    """One response as a polynomial of the germs.

    Attributes
    ----------
    basis
        Orthonormal polynomials, the constant first.
    coefficients
        Coefficients of the polynomials.
    error
        Root of the mean square error at designs that were left out of the fit; infinite if the others do not determine it.
    spread
        Standard deviation of the values at the designs, which are scattered as the germs are distributed.
    neighbour
        The better one of the fits of one degree less and one degree more; None if none is possible.
    """

    basis: Basis
    coefficients: np.ndarray
    error: float
    spread: float
    neighbour: Expansion | None = None

    @property
    def left_out(self) -> float:
        """Error at designs left out, relative to the spread of the values: a fit that explodes does not judge itself."""
        scale = self.spread or self.sigma
        return self.error / scale if scale else 0.0

    @property
    def mean(self) -> float:
        """Mean of the response."""
        return float(self.coefficients[0])

    @property
    def sigma(self) -> float:
        """Standard deviation of the response."""
        return float(np.sqrt(np.sum(self.coefficients[1:] ** 2)))

    @property
    def degree(self) -> int:
        """Degree of the polynomials."""
        return int(np.max(np.sum(self.basis.degrees, axis=1)))

    def values(self, germs: np.ndarray) -> np.ndarray:
        """Values of the response at germs (count, n)."""
        return self.basis.values(germs) @ self.coefficients

    def straight(self, germs: np.ndarray, solved: np.ndarray) -> np.ndarray:
        """Values of the response, straight on from where germs leave the least and largest ones of the solved designs."""
        edge = np.clip(germs, np.min(solved, axis=0), np.max(solved, axis=0))
        return self.values(edge) + np.einsum("cgp,p,cg->c", self.basis.slopes(edge), self.coefficients, germs - edge)

    def shares(self) -> tuple[np.ndarray, np.ndarray]:
        """Sobol's indices by the germs, (n,): shares of the variance by each alone, and by each together with all others."""
        parts, used = self.coefficients**2, self.basis.degrees > 0
        total = np.sum(parts[1:]) or 1.0
        alone = used & (np.sum(used, axis=1) == 1)[:, None]
        return parts @ alone / total, parts @ used / total


def fitted(
    germs: tuple[Marginal, ...], at: np.ndarray, values: np.ndarray, slopes: np.ndarray, undecided: np.ndarray, degree: int | None
) -> list[Expansion]:
    """The best polynomial of every response.

    Parameters
    ----------
    germs
        Their distributions.
    at
        Germs of the designs, (designs, n).
    values, slopes
        Values of the responses, (designs, responses), and their derivatives by the germs, (designs, responses, n).
    undecided
        Largest change of each response by round-off: one that changes by no more has no spread.
    degree
        Degree of the polynomials; None takes the one whose error at designs left out is least, for every response.

    Raises
    ------
    InputError
        There are too few designs, or they do not determine the polynomials.
    """
    n, equations = len(germs), len(at) * (1 + len(germs))
    possible = [
        k for k in range(1, max(HIGHEST_DEGREE, degree or 0) + 1) if EQUATIONS_PER_COEFFICIENT * size_of(n, k) <= equations
    ]
    if (degree or 1) not in possible or len(at) < 2:
        least = next(k for k in count(2) if EQUATIONS_PER_COEFFICIENT * size_of(n, degree or 1) <= k * (1 + n))
        raise InputError(
            f"uncertainty.runs: {len(at)} designs that could be solved are too few for polynomials of degree {degree or 1} of {n} numbers: "
            f"at least {least} are needed. Give more runs{', or a lower degree' if degree else ''}."
        )
    wanted = possible if degree is None else [k for k in possible if abs(k - degree) <= 1]
    tried = {k: _fit(basis_of(germs, k), at, values, slopes) for k in wanted}
    if not any(np.isfinite(each.error) for k in tried if degree in (None, k) for each in tried[k]):
        raise InputError(
            f"uncertainty.runs: polynomials of {n} numbers are not determined by {len(at)} designs where one of these is left out, so "
            f"that nothing says how good they are. Give more runs{', or a lower degree' if degree else ''}."
        )
    idle = (np.ptp(values, axis=0) <= 2 * undecided) & (np.max(np.abs(slopes), axis=(0, 2)) <= undecided)
    return [
        _constant(tried[wanted[0]][r], float(values[0, r]))
        if still
        else _chosen({k: each[r] for k, each in tried.items()}, degree)
        for r, still in enumerate(idle)
    ]


def _chosen(tried: dict[int, Expansion], degree: int | None) -> Expansion:
    """The fit of the least error, or of the wanted degree, with the better one of its two neighbours."""
    best = degree or min(tried, key=lambda k: max(tried[k].left_out, EXACT_FIT))
    beside = [k for k in (best - 1, best + 1) if k in tried and np.isfinite(tried[k].error)]
    if not beside:
        return tried[best]
    other = min(beside, key=lambda k: max(tried[k].left_out, EXACT_FIT))
    return replace(tried[best], neighbour=tried[other])


def _constant(found: Expansion, value: float) -> Expansion:
    """The expansion of a constant response, without the spread by round-off."""
    coefficients = np.zeros_like(found.coefficients)
    coefficients[0] = value
    return Expansion(found.basis, coefficients, 0.0, 0.0)


def _fit(basis: Basis, at: np.ndarray, values: np.ndarray, slopes: np.ndarray) -> list[Expansion]:
    designs, n = at.shape
    rows = np.concatenate([basis.values(at)[:, None, :], basis.slopes(at)], axis=1)  # (designs, 1 + n, products)
    wanted = np.concatenate([values[:, None, :], np.swapaxes(slopes, 1, 2)], axis=1)
    matrix, right = rows.reshape(designs * (1 + n), -1), wanted.reshape(designs * (1 + n), -1)
    orthogonal, triangular = np.linalg.qr(matrix)
    blocks = orthogonal.reshape(designs, 1 + n, -1)
    open_parts = np.eye(1 + n) - blocks @ np.swapaxes(blocks, 1, 2)
    spreads = np.std(values, axis=0)
    size = np.abs(np.diag(triangular))
    if np.min(size) < DETERMINED_DESIGN * np.max(size) or np.min(np.linalg.eigvalsh(open_parts)) < DETERMINED_DESIGN:
        return [Expansion(basis, np.full(matrix.shape[1], np.nan), np.inf, float(each)) for each in spreads]
    coefficients = np.linalg.solve(triangular, orthogonal.T @ right)
    left = (right - matrix @ coefficients).reshape(designs, 1 + n, -1)
    errors = np.linalg.solve(open_parts, left)[:, 0]
    return [
        Expansion(basis, column, float(np.sqrt(np.mean(error**2))), float(spread))
        for column, error, spread in zip(coefficients.T, errors.T, spreads, strict=True)
    ]


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

    def record(self) -> Record:
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

    def record(self) -> Record:
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

    def record(self) -> Record:
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


NORMAL_KURTOSIS = 3.0
"""Kurtosis of a normal distribution, taken as the least one: few designs show less than there is."""


def sampled(values: np.ndarray, polynomials: np.ndarray, shares: tuple[float, ...], limit: Limit | None) -> Sampled:
    """Statistics of a response at random designs, with the error of its polynomials there."""
    count, mean, sigma = len(values), float(np.mean(values)), float(np.std(values, ddof=1))
    fourth = float(np.mean((values - mean) ** 4)) / sigma**4 if sigma else 1.0
    sigma_error = sigma / 2 * float(np.sqrt((max(fourth, NORMAL_KURTOSIS) - 1) / count))
    share = beyond(values, limit)
    errors = {words: (p, float(np.sqrt(max(p * (1 - p), 1 / count) / count))) for words, p in share.items()}
    missed = float(np.sqrt(np.mean((values - polynomials) ** 2))) / sigma if sigma else 0.0
    return Sampled(
        count, (mean, sigma / float(np.sqrt(count))), (sigma, sigma_error), quantiles_of(values, shares), errors, missed
    )


@dataclass(frozen=True)
class UncertainResult:
    """Uncertain responses of a study.

    Attributes
    ----------
    study
        The study with the distributions of its numbers.
    responses
        Response, with its case before it where cases have names -> what is known about it.
    expansions
        The same -> polynomial of the germs.
    solved
        Designs with gradients, the first at the means.
    sampled
        Random designs without gradients.
    verdict
        Whether the numbers can be trusted.
    wall
        Time that all designs took, also before an interruption, in s.
    """

    study: UncertainStudy
    responses: Mapping[str, Spread]
    expansions: Mapping[str, Expansion]
    solved: tuple[DesignOutcome, ...]
    sampled: tuple[DesignOutcome, ...]
    verdict: Verdict
    wall: float

    @property
    def failed(self) -> int:
        """How many designs could not be solved."""
        return sum(each.failed for each in (*self.solved, *self.sampled))

    @property
    def said(self) -> str:
        """What it took, as a sentence."""
        random = f" and {len(self.sampled)} random ones without" if self.sampled else ""
        return f"{len(self.solved)} designs with gradients{random}, {self.failed} of which could not be solved, in {self.wall:.1f} s."

    def values(self, response: str, germs: np.ndarray) -> np.ndarray:
        """A response by its polynomial at germs (count, n)."""
        return self.expansions[response].values(germs)

    def record(self) -> Record:
        """The JSON object."""
        joint, names = self.study.joint, self.study.problem.variables
        return {
            "uncertain": {
                "variables": {
                    name: {"mean": each.mean, "sigma": each.sigma} for name, each in zip(names, joint.marginals, strict=True)
                },
                "responses": {name: finite(each.record()) for name, each in self.responses.items()},
            },
            "evaluations": len(self.solved) + len(self.sampled),
            "failed": self.failed,
            "wall_s": self.wall,
            **self.verdict.record(),
        }
