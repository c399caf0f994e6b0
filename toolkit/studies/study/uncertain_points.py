"""Mean and standard deviation over uncertain numbers by some points of them, with exact derivatives by the design.

Values f_k at the points give a polynomial of the germs by least squares, c = P^+ f with orthonormal P, whose mean and deviation are known:

    mean = c_0,   sigma^2 = c_1^2 + c_2^2 + ...,   dmean = (P^+ df)_0,   dsigma = sum of c_j (P^+ df)_j / sigma,  j > 0

Points and P^+ do not depend on the design: these are derivatives of just these numbers, without second derivatives of any response.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.studies.distributions.basis import basis_of, size_of
from toolkit.studies.distributions.joint import joint_of
from toolkit.studies.distributions.marginal import Marginal, marginal_of
from toolkit.studies.distributions.sobol_points import scrambled
from toolkit.studies.distributions.uncertain_numbers import Uncertain
from toolkit.studies.study.study_file import Study

SPARE = 1.5
"""Ratio of the number of points to that of coefficients."""
DEGREE, HIGHEST = 2, 8
"""Degree of the polynomials if the study does not give the number of points; and the highest degree."""


@dataclass(frozen=True)
class UncertainPoints:
    """Points of uncertain numbers at which a design is solved; the first is the one of all means.

    Attributes
    ----------
    names
        Numbers of the scene that no variable moves.
    numbers
        Their values, (points, names).
    shifts
        What is added to the variables, (points, n).
    fit
        P^+, (coefficients, points).
    """

    names: tuple[str, ...]
    numbers: np.ndarray
    shifts: np.ndarray
    fit: np.ndarray

    def __len__(self) -> int:
        return len(self.shifts)

    def at(self, point: int) -> dict[str, float]:
        """Numbers of the scene at a point."""
        return dict(zip(self.names, map(float, self.numbers[point]), strict=True))

    def statistics(self, values: np.ndarray, slopes: np.ndarray, undecided: float) -> tuple[float, np.ndarray, float, np.ndarray]:
        """Mean and standard deviation of values at all points, (points,), each with its derivative, of those by the design (points, n).

        A spread that may be round-off is none, and is least there.
        """
        found, moved = self.fit @ values, self.fit @ slopes
        sigma = float(np.sqrt(np.sum(found[1:] ** 2)))
        if sigma <= undecided:
            return float(found[0]), moved[0], 0.0, np.zeros_like(moved[0])
        return float(found[0]), moved[0], sigma, found[1:] @ moved[1:] / sigma

    def curvatures(self, values: np.ndarray, slopes: np.ndarray, curved: np.ndarray, undecided: float) -> np.ndarray:
        """Second derivatives of mean and standard deviation, (2, n, n), of those at all points (points, n, n), which may leave parts out.

        d2sigma = (sum of dc_j dc_j^T + c_j d2c_j - dsigma dsigma^T) / sigma,  j > 0;  a spread that may be round-off has none.
        """
        found, moved, bent = self.fit @ values, self.fit @ slopes, np.tensordot(self.fit, curved, 1)
        _, _, sigma, by_sigma = self.statistics(values, slopes, undecided)
        if sigma == 0.0:
            return np.array([bent[0], np.zeros_like(bent[0])])
        own = moved[1:].T @ moved[1:] + np.tensordot(found[1:], bent[1:], 1) - np.outer(by_sigma, by_sigma)
        return np.array([bent[0], own / sigma])


def uncertain_points(study: Study, scene: Scene) -> UncertainPoints:
    """Points of the uncertain numbers of a study.

    Raises
    ------
    InputError
        No number is uncertain; a distribution is invalid, or does not fit a number that a variable moves; or there are too few points.
    """
    if not study.uncertain:
        place = next((f"constraints.{name}" for name, each in study.constraints.items() if each.robust is not None), "objective")
        raise InputError(
            f"{place}: nothing is uncertain, so that `robust` says nothing. Write [uncertain] with numbers of the scene and their "
            'distributions, for example t_w = { distribution = "normal", sigma = 0.05 }.'
        )
    moved = {name: _variable_of(study, scene, name) for name in study.uncertain}
    marginals = {name: _marginal(scene, name, each, moved[name]) for name, each in study.uncertain.items()}
    names, options = tuple(marginals), study.uncertainty
    joint = joint_of(names, marginals, options.correlations)
    count = options.points or ceil(SPARE * size_of(len(names), DEGREE))
    germs = np.vstack([joint.germs_at_mean(), joint.germs_of(scrambled(count - 1, len(names), options.seed))])
    basis = basis_of(joint.germs, _degree(len(names), count))
    numbers = np.vstack([joint.mean, joint.numbers(germs[1:])])
    shifts, variables = np.zeros((count, len(study.variables))), list(study.variables)
    for name, column in zip(names, numbers.T, strict=True):
        if (variable := moved[name]) is not None:
            shifts[:, variables.index(variable)] += column
    own = [k for k, name in enumerate(names) if moved[name] is None]
    origins = np.array([scene.value_of(names[k]) if study.uncertain[names[k]].of else 0.0 for k in own])
    return UncertainPoints(tuple(names[k] for k in own), numbers[:, own] + origins, shifts, np.linalg.pinv(basis.values(germs)))


def _degree(n: int, count: int) -> int:
    """Highest degree of the polynomials that so many points determine."""
    if count < SPARE * size_of(n, 1):
        raise InputError(
            f"uncertainty.points = {count} are too few for {n} uncertain number{'s' if n > 1 else ''}. Give at least "
            f"{ceil(SPARE * size_of(n, 1))}, better {ceil(SPARE * size_of(n, DEGREE))}."
        )
    return max(degree for degree in range(1, HIGHEST + 1) if SPARE * size_of(n, degree) <= count)


def _variable_of(study: Study, scene: Scene, name: str) -> str | None:
    """The variable that moves the same numbers by the same factors; None if no variable moves any of them."""
    mine = dict(zip(scene.paths_of(name), scene.factors_of(name), strict=True))
    for variable in study.variables:
        its = dict(zip(scene.paths_of(variable), scene.factors_of(variable), strict=True))
        if mine == its:
            return variable
        if both := sorted(mine.keys() & its.keys()):
            raise InputError(
                f"uncertain.{name}: {both[0]} is moved by the variable {variable!r} too, but not all of its numbers by the same factors. "
                "Let both move the same numbers, or leave one of them out."
            )
    return None


def _marginal(scene: Scene, name: str, described: Uncertain, variable: str | None) -> Marginal:
    """Distribution of an uncertain number, or of its deviation where a variable moves the number."""
    if variable is None or described.of:
        return marginal_of(name, described, 0.0 if described.of else scene.value_of(name))
    if described.distribution != "normal" or described.mean is not None or described.between is not None:
        raise InputError(
            f"uncertain.{name}: the variable {variable!r} moves this number, so that its mean is the design's and only its deviation is "
            f'uncertain. Write {{ distribution = "normal", sigma = ... }}, or for another deviation a new name with of = ["{name}"].'
        )
    return marginal_of(name, described, 0.0)
