"""What runs at some designs of a study say about themselves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Caution
from toolkit.sensitivity.direct import direct
from toolkit.studies.designs.solved_design import scene_at
from toolkit.studies.engine.outcome import DesignOutcome
from toolkit.studies.study.problem import FURTHER, Problem
from toolkit.studies.study.study_file import LOAD_MARGIN

MOST = 4
"""Most designs that are looked at: a judgement of a motion takes some more runs."""


def extremes(found: Iterable[DesignOutcome]) -> list[DesignOutcome]:
    """Designs of the least and the largest values of the responses, the first ones first; not more than are to be looked at."""
    good = [each for each in found if not each.failed]
    if not good:
        return []
    values = np.array([each.values for each in good]).reshape(len(good), -1)
    places = dict.fromkeys(int(k) for column in values.T for k in (np.argmin(column), np.argmax(column)))
    return [good[k] for k in list(places)[:MOST]]


def cut_off(problem: Problem, found: DesignOutcome, place: tuple[int, int]) -> bool:
    """Whether a response of a design, by the places of case and response, is a load margin whose limit point was not reached."""
    up_to = problem.margin_up_to
    if found.failed or up_to is None or problem.responses[place[1]] != LOAD_MARGIN:
        return False
    return bool(found.values[place] >= up_to)


def margins_cut_off(problem: Problem, found: Sequence[DesignOutcome], statistics: bool, doubt: bool) -> Iterator[Caution]:
    """Load margins of which only the least value is known: right as such, but of no use for statistics."""
    if problem.margin_up_to is None:
        return
    places = [(k, problem.responses.index(LOAD_MARGIN)) for k in range(len(problem.cases))]
    count = sum(any(cut_off(problem, each, place) for place in places) for each in found)
    if count:
        then = "no mean, sigma or quantile follows" if statistics else "their rows hold this number, with gradients of zero"
        yield Caution(
            "margin-cut-off",
            f"in {count} of {len(found)} designs no limit point up to {problem.margin_up_to:g}: {LOAD_MARGIN} is at least that, and "
            f"{then}. It is looked for up to {FURTHER:g} times the limit under constraints.{LOAD_MARGIN}: a larger limit looks farther.",
            doubt=doubt,
        )


def said_at(problem: Problem, named: Mapping[str, DesignOutcome]) -> Iterator[Caution]:
    """Cautions of the runs at some designs in all cases: what several say is told of the first, with the name of its design."""
    told = set()
    for name, found in named.items():
        for case in problem.cases:
            where = f"{name}, {case}" if case else name
            try:
                warnings = direct(scene_at(problem, case, found.design), [], problem.kind).verdict.warnings
            except ToolkitError as error:
                warnings = (Caution("not-found-again", f"solved again along the path from the unloaded state: {error}"),)
            for each in warnings:
                if each.code not in told:
                    told.add(each.code)
                    yield Caution(each.code, f"{where}: {each.text}", each.doubt)
