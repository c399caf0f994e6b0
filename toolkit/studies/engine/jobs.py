"""Jobs in, outcomes out: what a store has already does not run again, and what fails is kept with its reason."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import chain
from typing import Protocol, TypeVar

from toolkit.studies.engine.executor import SERIAL, Executor, Job, Key, Progress, completed
from toolkit.studies.engine.outcome import JobOutcome

KeyOf = TypeVar("KeyOf", contravariant=True)
Result = TypeVar("Result", bound=JobOutcome)
AGAIN = "What was finished is kept: run the same command again, with --jobs 1."
"""What to do where a process or a cluster was lost."""


class OutcomeStore(Protocol[KeyOf, Result]):
    """What a store does for an engine."""

    def find(self, key: KeyOf) -> Result | None:
        """The outcome of a key; None if there is none."""

    def keep(self, key: KeyOf, found: Result) -> None:
        """Keep an outcome."""


def run_jobs(
    work: Callable[[Job], Result],
    jobs: Mapping[Key, Job],
    store: OutcomeStore[Key, Result],
    executor: Executor = SERIAL,
    progress: Progress | None = None,
    *,
    remedy: str = AGAIN,
    compile_first: bool = False,
) -> dict[Key, Result]:
    """Outcomes of jobs by their keys.

    Every job runs apart from all others, so that neither their order nor the executor changes a bit of it.

    Parameters
    ----------
    work
        Runs one job.
    jobs
        Key, which names all that the outcome follows from, -> job.
    store
        Outcomes that are known; a new one is kept as soon as it is there.
    executor
        Where jobs run.
    progress
        Called with the outcomes that are known and the jobs in all.
    remedy
        What to do where a process or a cluster was lost.
    compile_first
        Whether one job runs before all others, in this process: several processes would compile the same formulas.

    Raises
    ------
    StudyError
        A process or the cluster ended; what was finished is kept.
    """
    found = {key: known for key in jobs if (known := store.find(key)) is not None}
    missing = {key: job for key, job in jobs.items() if key not in found}
    if progress:
        progress(len(found), len(jobs))
    alone = dict(list(missing.items())[:1]) if compile_first else {}
    others = {key: job for key, job in missing.items() if key not in alone}
    for key, outcome in chain(*(completed(executor, work, part, remedy) for part in (alone, others))):
        store.keep(key, outcome)
        found[key] = outcome
        if progress:
            progress(len(found), len(jobs))
    return found
