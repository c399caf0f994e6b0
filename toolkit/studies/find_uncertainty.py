"""Uncertain responses: some designs with gradients, the polynomials through them, and random designs to judge these by."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from toolkit.foundation.verdict import Caution, Verdict
from toolkit.studies.design_work import (
    WITH_GRADIENTS,
    WITHOUT_GRADIENTS,
    DesignJob,
    DesignWork,
    cut_off,
    extremes,
    failed_designs,
    margins_cut_off,
    refuse_all_failed,
    said_at,
    solve_designs,
)
from toolkit.studies.executor import SERIAL, Executor, Progress
from toolkit.studies.orthonormal_basis import scrambled
from toolkit.studies.solved_design import solve_design
from toolkit.studies.store import DesignOutcome, hashed, opened_store
from toolkit.studies.study_file import LOAD_MARGIN
from toolkit.studies.uncertain_result import (
    EXACT_FIT,
    Expansion,
    Neighbour,
    Spread,
    UncertainResult,
    beyond,
    fitted,
    quantiles_of,
    sampled,
    without_statistics,
)
from toolkit.studies.uncertain_study import UncertainStudy

POLYNOMIAL_ERROR_LIMIT = 0.1
"""Limit of the polynomials' error at designs left out, relative to the spread of solved values: 1 % of the variance."""
SETTLED_MOMENTS = 0.05
"""Largest change of mean and sigma with the degree of the polynomials, relative to sigma."""
TAIL_EFFECT_LIMIT = 0.1
"""Largest relative change of sigma if polynomials go on straight beyond the solved designs; a straight line does not change."""
POLYNOMIAL_ROUND_OFF = 1e-6
"""Error at designs left out, relative to the spread, below which a response is taken for a polynomial, also beyond them."""
RARE_PROBABILITY = 1e-3
"""Probability below which a result of the polynomials rests on their tails, beyond all designs."""
OTHERS_ALONE = ", and all numbers are those of the others alone: so probable is it that nothing can be said."
"""Consequence of failed designs, for their caution."""
OTHER_EQUILIBRIUM = 1e-5
"""Relative change of a value by which an equilibrium is another one."""


def doubts(
    study: UncertainStudy,
    spreads: Mapping[str, Spread],
    exact: Sequence[DesignOutcome],
    random: Sequence[DesignOutcome],
    warm: bool,
) -> Iterator[Caution]:
    """Cautions about failed designs, about polynomials, and of runs at the means and at extreme designs."""
    yield from failed_designs([*exact, *random], OTHERS_ALONE, doubt=True)
    asked = study.options.responses is None or LOAD_MARGIN in study.options.responses
    yield from margins_cut_off(study.problem, [*exact, *random], statistics=True, doubt=asked)
    yield from _polynomials(spreads)
    yield from _other_polynomials(spreads)
    yield from _tails(spreads)
    yield from _samples(spreads)
    if np.any(study.joint.together):
        yield Caution(
            "correlated", "numbers go together, so that no share of the variance belongs to one of them alone.", doubt=False
        )
    ends = extremes(exact)
    named = {
        f"design {k + 1}" if k else "at the means": each
        for k, each in enumerate(exact)
        if any(each is end for end in ends) or not k
    }
    yield from said_at(study.problem, {name: each for name, each in named.items() if not each.failed})
    if warm:
        yield from _elsewhere(study, extremes([*exact, *random]))


def _polynomials(spreads: Mapping[str, Spread]) -> Iterator[Caution]:
    bad = {name: each.left_out for name, each in spreads.items() if each.left_out > POLYNOMIAL_ERROR_LIMIT}
    if bad:
        worst = max(bad, key=lambda name: bad[name])
        yield Caution(
            "polynomials",
            f"the polynomials of {', '.join(bad)} are off by {bad[worst]:.2g} of the spread of the solved values at designs that were "
            f"left out, most for {worst} (limit {POLYNOMIAL_ERROR_LIMIT:g}). Give more runs; a "
            "maximum that moves from place to place has kinks, its smooth maximum has not.",
        )
    for name, each in spreads.items():
        rare = [words for words, p in each.beyond.items() if 0 < min(p, 1 - p) < RARE_PROBABILITY or p in (0.0, 1.0)]
        if rare and each.sampled is None and each.sigma:
            yield Caution(
                "tails",
                f"that {name} is {rare[0]} is so rare, or so common, that it rests on tails of polynomials and distributions.",
                doubt=False,
            )


def _other_polynomials(spreads: Mapping[str, Spread]) -> Iterator[Caution]:
    """Doubts where polynomials of another degree, or with other tails, give another mean or sigma."""
    for name, each in spreads.items():
        if each.left_out < POLYNOMIAL_ROUND_OFF:
            continue
        if each.neighbour is not None:
            degree, mean, sigma = each.neighbour.degree, each.neighbour.mean, each.neighbour.sigma
            if max(abs(mean - each.mean), abs(sigma - each.sigma)) > SETTLED_MOMENTS * each.sigma:
                yield Caution(
                    "degree",
                    f"{name} has mean {each.mean:.4g} and sigma {each.sigma:.4g} by polynomials of degree {each.degree}, but {mean:.4g} "
                    f"and {sigma:.4g} by those of degree {degree} (limit {SETTLED_MOMENTS:.0%} of sigma). Give more runs, or "
                    "random designs "
                    "(monte_carlo) to judge them by.",
                )
        if abs(each.straight_sigma - each.sigma) > TAIL_EFFECT_LIMIT * each.sigma:
            yield Caution(
                "extrapolated",
                f"sigma of {name}, {each.sigma:.4g}, rests on polynomials beyond the solved designs: {each.straight_sigma:.4g} if they go "
                f"on straight there (limit {TAIL_EFFECT_LIMIT:.0%}). Give more runs, or random designs (monte_carlo) to judge them by.",
            )


def _tails(spreads: Mapping[str, Spread]) -> Iterator[Caution]:
    """Doubts about quantiles on which polynomials of two degrees do not agree, where mean and sigma may do so."""
    for name, each in spreads.items():
        other = each.neighbour
        if each.left_out < POLYNOMIAL_ROUND_OFF or not each.sigma or other is None:
            continue
        off = {share: abs(other.quantiles[share] - value) / each.sigma for share, value in each.quantiles.items()}
        if off and off[worst := max(off, key=lambda share: off[share])] > TAIL_EFFECT_LIMIT:
            seen = "" if each.sampled is None else f", {each.sampled.quantiles[worst]:.4g} by random designs"
            yield Caution(
                "tail-quantiles",
                f"the quantile {worst:g} of {name} is {each.quantiles[worst]:.4g} by polynomials of degree {each.degree}, but "
                f"{other.quantiles[worst]:.4g} by those of degree {other.degree}{seen} (limit {TAIL_EFFECT_LIMIT:.0%} of "
                "sigma). Give more runs, or "
                "random designs (monte_carlo) to judge it by.",
            )


def _samples(spreads: Mapping[str, Spread]) -> Iterator[Caution]:
    """Doubts where random designs disagree with the polynomials."""
    for name, each in spreads.items():
        if each.sampled is not None and each.sampled.missed > POLYNOMIAL_ERROR_LIMIT:
            yield Caution(
                "monte-carlo",
                f"the polynomials of {name} are off by {each.sampled.missed:.2g} sigma at {each.sampled.runs} random designs (limit "
                f"{POLYNOMIAL_ERROR_LIMIT:g}). Believe what these say, or give more runs with gradients.",
            )


def _elsewhere(study: UncertainStudy, ends: Sequence[DesignOutcome]) -> Iterator[Caution]:
    """A doubt that the path from the unloaded state leads to another equilibrium than the warm start."""
    for end in ends:
        cold = solve_design(study.problem, end.lane, end.design, None, False)
        if cold.failed or not np.allclose(cold.values, end.values, rtol=OTHER_EQUILIBRIUM, atol=0):
            yield Caution(
                "beyond-snap-through",
                "a design of an extreme value is another one along the path from the unloaded state: it lies beyond a snap-through. "
                "Leave out uncertainty.warm_starts.",
            )
            return


STORE = "uncertainty.h5"
"""Name of the store in the folder of a study."""
SAMPLES = 2**16
"""Points at which polynomials are looked at for quantiles and probabilities."""
TAIL_SAMPLES = 2**13
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
    start = (
        solve_design(problem, WITH_GRADIENTS, study.designs[0], None)
        if options.warm_starts and problem.kind == "static"
        else None
    )
    start = None if start is None or start.failed else start
    key = problem.fingerprint if start is None else hashed(problem.fingerprint, study.designs[0].tolist())
    asked = [DesignJob(WITH_GRADIENTS, each) for each in study.designs]
    asked += [DesignJob(WITHOUT_GRADIENTS, each, False) for each in study.random_designs]
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
        straight = _straight_sigma(each, germs[:TAIL_SAMPLES], study.germs[known])
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
            each.error + (abs(straight - each.sigma) if each.left_out > EXACT_FIT else 0.0),
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
