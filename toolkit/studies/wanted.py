"""Terms of objective and limits: responses, or their mean and standard deviation over uncertain numbers; and names that are none.

Mean and standard deviation over uncertain numbers by some points of them, with exact derivatives by the design.

Values f_k at the points give a polynomial of the germs by least squares, c = P^+ f with orthonormal P, whose mean and deviation are known:

    mean = c_0,   sigma^2 = c_1^2 + c_2^2 + ...,   dmean = (P^+ df)_0,   dsigma = sum of c_j (P^+ df)_j / sigma,  j > 0

Points and P^+ do not depend on the design: these are derivatives of just these numbers, without second derivatives of any response.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import ceil
from typing import NamedTuple

import numpy as np

from toolkit.analyses.sensitivity.preparation import Kind, responses_of
from toolkit.foundation.errors import InputError, listed, meant
from toolkit.responses.least_frequency import LoadMargin
from toolkit.scene.scene import Scene
from toolkit.studies.distributions import Marginal, Uncertain, joint_of, marginal_of
from toolkit.studies.orthonormal_basis import basis_of, scrambled, size_of
from toolkit.studies.study_file import LOAD_MARGIN, Limit, Study

POINTS_PER_COEFFICIENT = 1.5
"""Ratio of the number of points to that of coefficients."""
DEFAULT_DEGREE, HIGHEST_DEGREE = 2, 8
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
    count = options.points or ceil(POINTS_PER_COEFFICIENT * size_of(len(names), DEFAULT_DEGREE))
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
    if count < POINTS_PER_COEFFICIENT * size_of(n, 1):
        raise InputError(
            f"uncertainty.points = {count} are too few for {n} uncertain number{'s' if n > 1 else ''}. Give at least "
            f"{ceil(POINTS_PER_COEFFICIENT * size_of(n, 1))}, better {ceil(POINTS_PER_COEFFICIENT * size_of(n, DEFAULT_DEGREE))}."
        )
    return max(degree for degree in range(1, HIGHEST_DEGREE + 1) if POINTS_PER_COEFFICIENT * size_of(n, degree) <= count)


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


OBJECTIVE = "the objective"
"""Name of several responses with weights."""


_MODE, _NORM = re.compile(r"frequency_([1-9]\d{0,3})"), "gradient of "


class Statistic(NamedTuple):
    """A statistic of weighted responses over uncertain numbers: mean + times sigma, or one of both.

    Attributes
    ----------
    of
        What it is of: a response, or the objective.
    weights
        Response -> weight.
    mean, sigma
        How often each of both counts.
    """

    of: str
    weights: Mapping[str, float]
    mean: float
    sigma: float


class Wanted(NamedTuple):
    """One limit in the form sign (value - bound) >= 0."""

    name: str
    response: str
    sign: float
    bound: float
    limit: Limit


def objective_name(weights: Mapping[str, float]) -> str:
    """Name of the objective: that of its only response with weight one, or a phrase for several."""
    return next(iter(weights)) if list(weights.values()) == [1.0] else OBJECTIVE


def wants_points(study: Study) -> bool:
    """Whether anything is to be robust."""
    return study.objective.robust is not None or any(each.robust is not None for each in study.constraints.values())


def statistics_of(study: Study) -> dict[str, Statistic]:
    """Name -> statistic of all that is to be robust: the one that counts, and the mean and standard deviation of each."""
    return dict(_statistics(study))


def _statistics(study: Study) -> Iterator[tuple[str, Statistic]]:
    wanted, weights = study.objective, study.objective.weights
    if wanted.robust is not None:
        yield from _of(objective_name(weights), weights, wanted.sign * wanted.robust)
    for name, limit in study.constraints.items():
        for sign, bound in zip((-1.0, 1.0), limit.limits, strict=True):
            if limit.robust is not None and bound is not None:
                yield from _of(name, {name: 1.0}, sign * limit.robust)


def _of(of: str, weights: Mapping[str, float], times: float) -> Iterator[tuple[str, Statistic]]:
    yield _robust(of, times), Statistic(of, weights, 1.0, times)
    yield f"mean of {of}", Statistic(of, weights, 1.0, 0.0)
    yield f"sigma of {of}", Statistic(of, weights, 0.0, 1.0)


def _robust(of: str, times: float) -> str:
    return f"{of} {'-' if times < 0 else '+'} {abs(times):g} sigma"


def weights_of(study: Study, robust: bool) -> Mapping[str, float]:
    """Weights of the terms whose sum is the objective."""
    wanted, weights = study.objective, study.objective.weights
    if not robust or wanted.robust is None:
        return weights
    return {_robust(objective_name(weights), wanted.sign * wanted.robust): 1.0}


def limits_of(study: Study, robust: bool) -> Iterator[Wanted]:
    """All limits of the constraints, the least of a response before the largest."""
    for name, limit in study.constraints.items():
        for sign, bound in zip((1.0, -1.0), limit.limits, strict=True):
            if bound is not None:
                response = _robust(name, -sign * limit.robust) if robust and limit.robust is not None else name
                yield Wanted(name, response, sign, bound, limit)


def number_of(name: str) -> int | None:
    """The number of the mode whose frequency a name asks for; None if it asks for something else."""
    found = _MODE.fullmatch(name)
    return int(found[1]) if found else None


def norm_of(response: str) -> str:
    """Name of the norm of the gradient of a response."""
    return f"{_NORM}{response}"


def in_norm(name: str) -> str | None:
    """Name of the response whose gradient a name asks for; None if it asks for something else."""
    return name.removeprefix(_NORM) if name.startswith(_NORM) else None


def kind_of(study: Study) -> Kind:
    """Kind of the analysis that is solved for every design."""
    return "transient" if study.analysis == "motion" else "static"


def mode_of(study: Study, name: str) -> int | None:
    """The number of the mode whose frequency a study of modes asks for by a name; None if the name is another."""
    return number_of(name) if study.analysis == "modes" else None


def refuse_unknown(study: Study, scene: Scene, places: Mapping[str, str]) -> None:
    """Refuse responses that the analysis does not have; `places` are the keys that name them."""
    statics = kind_of(study) == "static"
    known = responses_of(scene, moving=not statics)
    built_in = ([LOAD_MARGIN] if statics else []) + (["frequency_1", "frequency_2", "..."] if study.analysis == "modes" else [])
    for asked, place in places.items():
        name = _without_norm(study, asked, place)
        if name == LOAD_MARGIN:
            _refuse_no_margin(study, scene, place)
        elif mode_of(study, name) is not None:
            _refuse_no_mode(study, scene, name)
        elif name not in known:
            _refuse_frequency(study, name, place)
            why = f"{study.analysis} does not have it" if name in scene.responses else "there is none of that name"
            why += meant(name, [*known, *built_in])
            raise InputError(
                f"{place}: no response {name!r}, {why}; possible here: {listed([*known, *built_in])}. Others can "
                "be written in the study's table [responses]."
            )
        elif isinstance(scene.responses[name], LoadMargin):
            raise InputError(
                f"{place}: {name!r} does not exist where nothing snaps through. Write {LOAD_MARGIN}, which is built in."
            )


def _without_norm(study: Study, asked: str, place: str) -> str:
    """The response itself of a gradient whose norm is asked for."""
    name, limit = in_norm(asked), study.constraints.get(asked)
    if name is None:
        return asked
    if name == LOAD_MARGIN:
        raise InputError(f"{place}: the load margin is looked for up to a load factor, and cut off there: its gradient leaps.")
    if (inner := in_norm(name)) is not None:
        raise InputError(
            f"{place}: {asked!r} asks for the gradient of a gradient's norm, which would be differences of differences. Write "
            f"{norm_of(inner)!r}."
        )
    if (limit is not None and limit.robust is not None) or (
        study.objective.robust is not None and asked in study.objective.weights
    ):
        raise InputError(f"{place}: norms of gradients are those at the means of uncertain numbers. Leave out `robust`.")
    return name


def _refuse_frequency(study: Study, name: str, place: str) -> None:
    """Refuse a frequency that only modes have built in."""
    if (number := number_of(name)) is None:
        return
    raise InputError(
        f'{place}: {name!r} is built in where analysis = "modes", but the analysis is {study.analysis!r}. Write analysis = "modes", or '
        f'in the study\'s table [responses] one of your own, {{ type = "frequency", number = {number} }}, which counts by their order.'
    )


def _refuse_no_mode(study: Study, scene: Scene, name: str) -> None:
    if name in scene.responses:
        raise InputError(f"responses.{name} is built in where analysis = {study.analysis!r}. Give this one another name.")
    if scene.solver.equilibrium == "spinning":
        raise InputError(
            'analysis: modes are followed about an equilibrium at rest, but the scene\'s solver.equilibrium is "spinning". Write '
            f'analysis = "statics", and instead of {name} a response {{ type = "frequency", number = {number_of(name)} }}.'
        )


def _refuse_no_margin(study: Study, scene: Scene, place: str) -> None:
    if LOAD_MARGIN in scene.responses and not isinstance(scene.responses[LOAD_MARGIN], LoadMargin):
        raise InputError(f"{place}: {LOAD_MARGIN} is built in, but the scene calls another response so. Rename that one.")
    if kind_of(study) != "static" or scene.solver.equilibrium == "spinning" or scene.solver.continuation != "load":
        raise InputError(
            f'{place}: the load margin is that of an equilibrium at rest on a path that has not turned back. Write analysis = "statics", '
            'with the scene\'s solver.equilibrium = "rest" and solver.continuation = "load", or leave it out.'
        )


def refuse_robust_margin(study: Study) -> None:
    limit, why = (
        study.constraints.get(LOAD_MARGIN),
        "the load margin is looked for up to a load factor, and cut off there: it has no mean",
    )
    if limit is not None and limit.robust is not None:
        raise InputError(f"constraints.{LOAD_MARGIN}: {why}. Leave out `robust`; the limit is kept at the means of [uncertain].")
    if study.objective.robust is not None and LOAD_MARGIN in study.objective.weights:
        raise InputError(f"objective: {why}. Leave out `robust`, or choose another response.")
