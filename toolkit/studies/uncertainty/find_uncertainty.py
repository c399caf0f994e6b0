"""Uncertain responses: some designs with gradients, the polynomials through them, and random designs to judge these by."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from toolkit.foundation.verdict import Verdict
from toolkit.studies.designs.design_work import WITH, WITHOUT, DesignJob, DesignWork
from toolkit.studies.designs.judged_runs import cut_off
from toolkit.studies.designs.solve_designs import refuse_all_failed, solve_designs
from toolkit.studies.designs.solved_design import solve_design
from toolkit.studies.distributions.sobol_points import scrambled
from toolkit.studies.engine.executor import SERIAL, Executor, Progress
from toolkit.studies.engine.fingerprint import hashed
from toolkit.studies.engine.outcome import DesignOutcome
from toolkit.studies.engine.store import opened_store
from toolkit.studies.uncertainty.doubts import doubts
from toolkit.studies.uncertainty.expansion import EXACT, Expansion, fitted
from toolkit.studies.uncertainty.spread import Neighbour, Spread, beyond, quantiles_of, sampled, without_statistics
from toolkit.studies.uncertainty.uncertain_result import UncertainResult
from toolkit.studies.uncertainty.uncertain_study import UncertainStudy

STORE = "uncertainty.h5"
"""Name of the store in the folder of a study."""
SAMPLES = 2**16
"""Points at which polynomials are looked at for quantiles and probabilities."""
TAILS = 2**13
"""How many of them are looked at for what straight tails would change."""


def find_uncertainty(
    study: UncertainStudy, folder: Path | None = None, executor: Executor = SERIAL, progress: Progress | None = None
) -> UncertainResult:
    """Find out what follows from uncertain numbers.

    Parameters
    ----------
    study
        The checked study.
    folder
        Where all designs are kept, and found again after an interruption; None keeps nothing.
    executor
        Where they are solved.
    progress
        Called with the designs solved and the designs in all.

    Raises
    ------
    InputError
        There are too few designs; the folder holds another study, or another run works in it; or OpenTURNS is not installed.
    NoDesignError
        Not one design could be solved.
    StudyError
        A process or the cluster ended; what was finished is kept.
    """
    problem, options = study.problem, study.options
    start = solve_design(problem, WITH, study.designs[0], None) if options.warm_starts and problem.kind == "static" else None
    start = None if start is None or start.failed else start
    key = problem.fingerprint if start is None else hashed(problem.fingerprint, study.designs[0].tolist())
    asked = [DesignJob(WITH, each) for each in study.designs]
    asked += [DesignJob(WITHOUT, each, False) for each in study.random_designs]
    with opened_store(None if folder is None else folder / STORE, key) as store:
        found = solve_designs(DesignWork(problem, start), asked, store, executor, progress)
    exact, random = found[: len(study.designs)], found[len(study.designs) :]
    refuse_all_failed(exact)
    expansions = _expansions(study, exact)
    spreads = _spreads(study, expansions, exact, random)
    verdict = Verdict.of(doubts(study, spreads, exact, random, start is not None))
    wall = sum(each.seconds for each in found)
    return UncertainResult(study, spreads, expansions, tuple(exact), tuple(random), verdict, wall)


def _expansions(study: UncertainStudy, exact: Sequence[DesignOutcome]) -> dict[str, Expansion]:
    good = [k for k, each in enumerate(exact) if not each.failed]
    germs, places = study.germs[good], study.problem.labels
    values = np.array([[exact[k].values[place] for place in places.values()] for k in good])
    by_numbers = np.array([[exact[k].gradients[place] for place in places.values()] for k in good])
    slopes = np.einsum("krx,kxg->krg", by_numbers, study.joint.slopes(germs))
    names = [study.problem.responses[j] for _, j in places.values()]
    undecided = np.array([study.problem.undecided(name, column) for name, column in zip(names, values.T, strict=True)])
    found = fitted(study.joint.germs, germs, values, slopes, undecided, study.options.degree)
    return dict(zip(places, found, strict=True))


def _spreads(
    study: UncertainStudy, expansions: dict[str, Expansion], exact: Sequence[DesignOutcome], random: Sequence[DesignOutcome]
) -> dict[str, Spread]:
    problem, options, joint = study.problem, study.options, study.joint
    known = [k for k, each in enumerate(exact) if not each.failed]
    germs = joint.germs_of(scrambled(SAMPLES, len(joint.marginals), options.seed))
    good, found = [k for k, each in enumerate(random) if not each.failed], {}
    for label, place in study.problem.labels.items():
        each, name = expansions[label], problem.responses[place[1]]
        values, limit = each.values(germs), problem.study.constraints.get(name)
        alone, together = each.shares()
        at_random = each.values(study.random_germs[good])
        tied = bool(np.any(joint.together))
        straight = _straight_sigma(each, germs[:TAILS], study.germs[known])
        found[label] = Spread(
            problem.unit_of(name),
            each.mean,
            each.sigma,
            _first_order(study, exact[0], place),
            quantiles_of(values, options.quantiles),
            beyond(values, limit),
            None if tied else dict(zip(problem.variables, map(float, alone), strict=True)),
            None if tied else dict(zip(problem.variables, map(float, together), strict=True)),
            each.degree,
            each.left_out,
            _neighbour(each, germs, options.quantiles),
            straight,
            each.error + (abs(straight - each.sigma) if each.left_out > EXACT else 0.0),
            sampled(np.array([random[k].values[place] for k in good]), at_random, options.quantiles, limit)
            if len(good) > 1
            else None,
        )
        if any(cut_off(problem, e, place) for e in (*exact, *random)):
            found[label] = without_statistics(found[label])
    return found


def _straight_sigma(each: Expansion, germs: np.ndarray, solved: np.ndarray) -> float:
    """Sigma with straight tails, from its ratio to that of the polynomials at the same points."""
    own = float(np.std(each.values(germs)))
    return each.sigma * float(np.std(each.straight(germs, solved))) / own if own else 0.0


def _neighbour(each: Expansion, germs: np.ndarray, shares: tuple[float, ...]) -> Neighbour | None:
    """What the polynomials of the degree beside say, at the same points."""
    other = each.neighbour
    return None if other is None else Neighbour(other.degree, other.mean, other.sigma, quantiles_of(other.values(germs), shares))


def _first_order(study: UncertainStudy, first: DesignOutcome, place: tuple[int, int]) -> tuple[float, float] | None:
    """Mean and standard deviation by the value and the derivatives at the means; None if that design could not be solved."""
    if first.failed:
        return None
    slope = first.gradients[place]
    return float(first.values[place]), float(np.sqrt(slope @ study.joint.covariance @ slope))
