"""Responses as polynomials of the germs, fitted to values and gradients of some designs.

    minimise  sum over designs |c . P(g) - f|^2 + |c . dP/dg - df/dg|^2

A design tells 1 + n numbers, so that few designs suffice. How good the fit is follows from the fits without each design
(leave-one-out): the residual of a design that was left out, with its gradient, is (I - H)^-1 times the one it has, H its block of the
projection.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.studies.uncertainty.basis import Basis, basis_of, size_of
from toolkit.studies.uncertainty.marginal import Marginal

HIGHEST = 8
"""Degree beyond which none is tried."""
EXACT = 1e-9
"""Error at designs left out, in parts of sigma, below which the lowest degree is taken: round-off decides between none."""
SPARE = 1.5
"""So many times as many equations as coefficients are wanted."""


@dataclass(frozen=True)
class Expansion:
    """One response as a polynomial of the germs.

    Attributes
    ----------
    basis
        Orthonormal polynomials, the constant first.
    coefficients
        Of them.
    left_out
        Root of the mean square error at designs that were left out of the fit, in parts of the standard deviation.
    """

    basis: Basis
    coefficients: np.ndarray
    left_out: float

    @property
    def mean(self) -> float:
        """Of the response."""
        return float(self.coefficients[0])

    @property
    def sigma(self) -> float:
        """Its standard deviation."""
        return float(np.sqrt(np.sum(self.coefficients[1:] ** 2)))

    @property
    def degree(self) -> int:
        """Of the polynomials."""
        return int(np.max(np.sum(self.basis.degrees, axis=1)))

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
        Of the responses, (designs, responses), and their derivatives by the germs, (designs, responses, n).
    undecided
        By how much round-off may change each response: one that changes by no more has no spread.
    degree
        Of the polynomials; None takes the one whose error at designs left out is least, for every response.

    Raises
    ------
    InputError
        There are too few designs.
    """
    n, equations = len(germs), len(at) * (1 + len(germs))
    possible = [k for k in range(1, HIGHEST + 1) if SPARE * size_of(n, k) <= equations] if degree is None else [degree]
    if not possible or SPARE * size_of(n, possible[0]) > equations or len(at) < 2:
        least = next(k for k in count(2) if SPARE * size_of(n, degree or 1) <= k * (1 + n))
        raise InputError(
            f"uncertainty.runs: {len(at)} designs that could be solved are too few for polynomials of degree {degree or 1} of {n} numbers: "
            f"at least {least} are needed. Give more runs{', or a lower degree' if degree else ''}."
        )
    tried = [_fit(basis_of(germs, each), at, values, slopes) for each in possible]
    idle = (np.ptp(values, axis=0) <= 2 * undecided) & (np.max(np.abs(slopes), axis=(0, 2)) <= undecided)
    chosen = [min(column, key=lambda each: max(each.left_out, EXACT)) for column in zip(*tried, strict=True)]
    return [_constant(each, float(value)) if still else each for each, still, value in zip(chosen, idle, values[0], strict=True)]


def _constant(found: Expansion, value: float) -> Expansion:
    """The same without a spread that is none."""
    coefficients = np.zeros_like(found.coefficients)
    coefficients[0] = value
    return Expansion(found.basis, coefficients, 0.0)


def _fit(basis: Basis, at: np.ndarray, values: np.ndarray, slopes: np.ndarray) -> list[Expansion]:
    designs, n = at.shape
    rows = np.concatenate([basis.values(at)[:, None, :], basis.slopes(at)], axis=1)  # (designs, 1 + n, products)
    wanted = np.concatenate([values[:, None, :], np.swapaxes(slopes, 1, 2)], axis=1)
    matrix, right = rows.reshape(designs * (1 + n), -1), wanted.reshape(designs * (1 + n), -1)
    orthogonal, triangular = np.linalg.qr(matrix)
    coefficients = np.linalg.solve(triangular, orthogonal.T @ right)
    left = (right - matrix @ coefficients).reshape(designs, 1 + n, -1)
    blocks = orthogonal.reshape(designs, 1 + n, -1)
    errors = np.array(
        [np.linalg.solve(np.eye(1 + n) - block @ block.T, each)[0] for block, each in zip(blocks, left, strict=True)]
    )
    found = []
    for column, error in zip(coefficients.T, errors.T, strict=True):
        sigma = Expansion(basis, column, 0.0).sigma
        found.append(Expansion(basis, column, float(np.sqrt(np.mean(error**2))) / sigma if sigma else 0.0))
    return found
