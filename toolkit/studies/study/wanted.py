"""Terms of objective and limits: responses, or their mean and standard deviation over uncertain numbers."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from toolkit.sensitivity.preparation import Kind
from toolkit.studies.study.study_file import Limit, Study

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
