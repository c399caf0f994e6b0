"""Responses as polynomials of the germs, fitted to values and gradients of some designs.

    minimise  sum over designs |c . P(g) - f|^2 + |c . dP/dg - df/dg|^2

A design tells 1 + n numbers, so that few designs suffice. How good the fit is follows from the fits without each design
(leave-one-out): the residual of a design that was left out, with its gradient, is (I - H)^-1 times the one it has, H its block of the
projection.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.studies.distributions.basis import Basis, basis_of, size_of
from toolkit.studies.distributions.marginal import Marginal

HIGHEST = 8
"""Highest degree that is tried."""
EXACT = 1e-9
"""Error at designs left out, relative to the values' spread, below which the lowest degree is taken: round-off decides."""
SPARE = 1.5
"""Wanted ratio of the number of equations to that of coefficients."""
DETERMINED = 1e-8
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
    possible = [k for k in range(1, max(HIGHEST, degree or 0) + 1) if SPARE * size_of(n, k) <= equations]
    if (degree or 1) not in possible or len(at) < 2:
        least = next(k for k in count(2) if SPARE * size_of(n, degree or 1) <= k * (1 + n))
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
    best = degree or min(tried, key=lambda k: max(tried[k].left_out, EXACT))
    beside = [k for k in (best - 1, best + 1) if k in tried and np.isfinite(tried[k].error)]
    if not beside:
        return tried[best]
    other = min(beside, key=lambda k: max(tried[k].left_out, EXACT))
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
    if np.min(size) < DETERMINED * np.max(size) or np.min(np.linalg.eigvalsh(open_parts)) < DETERMINED:
        return [Expansion(basis, np.full(matrix.shape[1], np.nan), np.inf, float(each)) for each in spreads]
    coefficients = np.linalg.solve(triangular, orthogonal.T @ right)
    left = (right - matrix @ coefficients).reshape(designs, 1 + n, -1)
    errors = np.linalg.solve(open_parts, left)[:, 0]
    return [
        Expansion(basis, column, float(np.sqrt(np.mean(error**2))), float(spread))
        for column, error, spread in zip(coefficients.T, errors.T, spreads, strict=True)
    ]
