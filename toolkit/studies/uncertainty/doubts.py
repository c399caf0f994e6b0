"""Cautions about uncertain responses."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from toolkit.foundation.verdict import Caution
from toolkit.studies.designs.judged_runs import extremes, margins_cut_off, said_at
from toolkit.studies.designs.solve_designs import failed_designs
from toolkit.studies.designs.solved_design import solve_design
from toolkit.studies.engine.outcome import DesignOutcome
from toolkit.studies.study.study_file import LOAD_MARGIN
from toolkit.studies.uncertainty.spread import Spread
from toolkit.studies.uncertainty.uncertain_study import UncertainStudy

MISSED = 0.1
"""Limit of the polynomials' error at designs left out, relative to the spread of solved values: 1 % of the variance."""
SETTLED = 0.05
"""Largest change of mean and sigma with the degree of the polynomials, relative to sigma."""
BEYOND = 0.1
"""Largest relative change of sigma if polynomials go on straight beyond the solved designs; a straight line does not change."""
SURE = 1e-6
"""Error at designs left out, relative to the spread, below which a response is taken for a polynomial, also beyond them."""
RARE = 1e-3
"""Probability below which a result of the polynomials rests on their tails, beyond all designs."""
OTHERS_ALONE = ", and all numbers are those of the others alone: so probable is it that nothing can be said."
"""Consequence of failed designs, for their caution."""
ANOTHER = 1e-5
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
    bad = {name: each.left_out for name, each in spreads.items() if each.left_out > MISSED}
    if bad:
        worst = max(bad, key=lambda name: bad[name])
        yield Caution(
            "polynomials",
            f"the polynomials of {', '.join(bad)} are off by {bad[worst]:.2g} of the spread of the solved values at designs that were "
            f"left out, most for {worst} (limit {MISSED:g}). Give more runs; a "
            "maximum that moves from place to place has kinks, its smooth maximum has not.",
        )
    for name, each in spreads.items():
        rare = [words for words, p in each.beyond.items() if 0 < min(p, 1 - p) < RARE or p in (0.0, 1.0)]
        if rare and each.sampled is None and each.sigma:
            yield Caution(
                "tails",
                f"that {name} is {rare[0]} is so rare, or so common, that it rests on tails of polynomials and distributions.",
                doubt=False,
            )


def _other_polynomials(spreads: Mapping[str, Spread]) -> Iterator[Caution]:
    """Doubts where polynomials of another degree, or with other tails, give another mean or sigma."""
    for name, each in spreads.items():
        if each.left_out < SURE:
            continue
        if each.neighbour is not None:
            degree, mean, sigma = each.neighbour.degree, each.neighbour.mean, each.neighbour.sigma
            if max(abs(mean - each.mean), abs(sigma - each.sigma)) > SETTLED * each.sigma:
                yield Caution(
                    "degree",
                    f"{name} has mean {each.mean:.4g} and sigma {each.sigma:.4g} by polynomials of degree {each.degree}, but {mean:.4g} "
                    f"and {sigma:.4g} by those of degree {degree} (limit {SETTLED:.0%} of sigma). Give more runs, or random designs "
                    "(monte_carlo) to judge them by.",
                )
        if abs(each.straight_sigma - each.sigma) > BEYOND * each.sigma:
            yield Caution(
                "extrapolated",
                f"sigma of {name}, {each.sigma:.4g}, rests on polynomials beyond the solved designs: {each.straight_sigma:.4g} if they go "
                f"on straight there (limit {BEYOND:.0%}). Give more runs, or random designs (monte_carlo) to judge them by.",
            )


def _tails(spreads: Mapping[str, Spread]) -> Iterator[Caution]:
    """Doubts about quantiles on which polynomials of two degrees do not agree, where mean and sigma may do so."""
    for name, each in spreads.items():
        other = each.neighbour
        if each.left_out < SURE or not each.sigma or other is None:
            continue
        off = {share: abs(other.quantiles[share] - value) / each.sigma for share, value in each.quantiles.items()}
        if off and off[worst := max(off, key=lambda share: off[share])] > BEYOND:
            seen = "" if each.sampled is None else f", {each.sampled.quantiles[worst]:.4g} by random designs"
            yield Caution(
                "tail-quantiles",
                f"the quantile {worst:g} of {name} is {each.quantiles[worst]:.4g} by polynomials of degree {each.degree}, but "
                f"{other.quantiles[worst]:.4g} by those of degree {other.degree}{seen} (limit {BEYOND:.0%} of sigma). Give more runs, or "
                "random designs (monte_carlo) to judge it by.",
            )


def _samples(spreads: Mapping[str, Spread]) -> Iterator[Caution]:
    """Doubts where random designs disagree with the polynomials."""
    for name, each in spreads.items():
        if each.sampled is not None and each.sampled.missed > MISSED:
            yield Caution(
                "monte-carlo",
                f"the polynomials of {name} are off by {each.sampled.missed:.2g} sigma at {each.sampled.runs} random designs (limit "
                f"{MISSED:g}). Believe what these say, or give more runs with gradients.",
            )


def _elsewhere(study: UncertainStudy, ends: Sequence[DesignOutcome]) -> Iterator[Caution]:
    """A doubt that the path from the unloaded state leads to another equilibrium than the warm start."""
    for end in ends:
        cold = solve_design(study.problem, end.lane, end.design, None, False)
        if cold.failed or not np.allclose(cold.values, end.values, rtol=ANOTHER, atol=0):
            yield Caution(
                "beyond-snap-through",
                "a design of an extreme value is another one along the path from the unloaded state: it lies beyond a snap-through. "
                "Leave out uncertainty.warm_starts.",
            )
            return
