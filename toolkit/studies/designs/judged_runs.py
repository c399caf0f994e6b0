"""What runs at some designs of a study say about themselves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Caution
from toolkit.sensitivity.direct import direct
from toolkit.studies.study.evaluation import Evaluation
from toolkit.studies.study.problem import Problem
from toolkit.studies.study.solved_design import scene_at

MOST = 4
"""Most designs that are looked at: a judgement of a motion takes some more runs."""


def extremes(found: Iterable[Evaluation]) -> list[Evaluation]:
    """Designs of the least and the largest values of the responses, the first ones first; not more than are to be looked at."""
    good = [each for each in found if not each.failed]
    if not good:
        return []
    values = np.array([each.values for each in good]).reshape(len(good), -1)
    places = dict.fromkeys(int(k) for column in values.T for k in (np.argmin(column), np.argmax(column)))
    return [good[k] for k in list(places)[:MOST]]


def said_at(problem: Problem, named: Mapping[str, Evaluation]) -> Iterator[Caution]:
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
