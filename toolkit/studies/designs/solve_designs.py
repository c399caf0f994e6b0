"""Designs in, evaluations out: what a store holds already is not solved again, and what fails is kept with its reason."""

from __future__ import annotations

from collections.abc import Sequence

from toolkit.studies.designs.design_work import DesignJob as Asked
from toolkit.studies.designs.design_work import DesignWork, WithFiles
from toolkit.studies.engine.executor import SERIAL as HERE
from toolkit.studies.engine.executor import Executor as Place
from toolkit.studies.engine.executor import Progress
from toolkit.studies.engine.executor import completed as done_at
from toolkit.studies.engine.outcome import DesignOutcome as Evaluation
from toolkit.studies.engine.store import DesignStore as Store

REMEDY = "What was finished is kept: run the same command again, with --jobs 1."


def solve_designs(
    work: DesignWork, asked: Sequence[Asked], store: Store, place: Place = HERE, progress: Progress | None = None
) -> list[Evaluation]:
    """Evaluations in the order of the designs; equal ones are solved once.

    Every design is solved apart from all others, so that neither their order nor the place changes a bit of it.

    Parameters
    ----------
    work
        The checked study.
    asked
        Designs.
    store
        What is known, opened; it is written while designs are solved.
    place
        Where they are solved.
    progress
        Called with the designs known and the designs in all.

    Raises
    ------
    StudyError
        A process or the cluster ended; what was finished is kept.
    """
    wanted = {(each.lane, each.design.tobytes()): each for each in asked}
    missing = {key: each for key, each in wanted.items() if store.find((each.lane, each.design.tobytes())) is None}
    done = len(wanted) - len(missing)
    if progress:
        progress(done, len(wanted))
    sent = WithFiles.of(work) if place.dask else work
    for _, found in done_at(place, sent, missing, REMEDY):
        store.keep(found.key, found)
        done += 1
        if progress:
            progress(done, len(wanted))
    return [_known(store, each) for each in asked]


def _known(store: Store, asked: Asked) -> Evaluation:
    found = store.find((asked.lane, asked.design.tobytes()))
    assert found is not None
    return found
