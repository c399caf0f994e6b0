"""Jobs of a study run one after another, in threads, in processes or on a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from itertools import islice
from typing import TypeVar

from toolkit.foundation.errors import InputError
from toolkit.foundation.processes.one_thread import one_thread
from toolkit.studies.engine.dask_cluster import on_cluster
from toolkit.studies.engine.processes import in_processes

Key = TypeVar("Key")
Job = TypeVar("Job")
Result = TypeVar("Result")
Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Executor:
    """Where jobs run; numbers do not depend on it.

    Attributes
    ----------
    processes
        How many run at once, each in a process of its own.
    threads
        How many run at once in this process instead.
    dask
        Address of a Dask scheduler whose workers run them, for example "tcp://10.0.0.1:8786"; empty for this machine.

    Raises
    ------
    InputError
        A number is none, or two of the three are named.
    """

    processes: int = 1
    threads: int = 1
    dask: str = ""

    def __post_init__(self) -> None:
        for word, count in {"processes": self.processes, "threads": self.threads}.items():
            if isinstance(count, bool) or not isinstance(count, int) or count < 1:
                raise InputError(f"{word} = {count!r}: give a whole number, at least 1.")
        if not isinstance(self.dask, str):
            raise InputError(
                f"dask = {self.dask!r}: give the address of a scheduler as a text, for example 'tcp://10.0.0.1:8786'."
            )
        if (self.processes > 1) + (self.threads > 1) + bool(self.dask) > 1:
            raise InputError(
                "designs are analysed in several processes, in several threads, or on a cluster. Leave out all but one of "
                "processes, threads and dask."
            )


SERIAL = Executor()
"""This process, one job after another."""


def completed(
    executor: Executor,
    work: Callable[[Job], Result],
    jobs: Mapping[Key, Job],
    remedy: str = "Ask for fewer processes.",
    more: Callable[[], Mapping[Key, Job]] = dict,
) -> Iterator[tuple[Key, Result]]:
    """Keys of jobs with what the work makes of them, in the order in which they are completed.

    Work and jobs are sent to where they run: the work once to every process or worker, where it may keep what all jobs have in common.
    If the caller stops iterating, jobs that are running end, and no others begin. When all jobs are completed, `more` is asked for others,
    which follow from what was found, until it has none.

    Raises
    ------
    StudyError
        A process was killed, or the cluster is gone; `remedy` tells what to do then.
    """
    if executor.processes > 1 and len(jobs) > 1 and not executor.dask:
        return in_processes(work, jobs, executor.processes, remedy, more)
    return _in_rounds(
        lambda each: (
            on_cluster(work, each, executor.dask, remedy) if executor.dask else _in_this_process(work, each, executor.threads)
        ),
        jobs,
        more,
    )


def _in_rounds(
    done: Callable[[Mapping[Key, Job]], Iterator[tuple[Key, Result]]],
    jobs: Mapping[Key, Job],
    more: Callable[[], Mapping[Key, Job]],
) -> Iterator[tuple[Key, Result]]:
    """Results of some jobs, then of those that follow from them."""
    while jobs:
        yield from done(jobs)
        jobs = more()


def _in_this_process(work: Callable[[Job], Result], jobs: Mapping[Key, Job], threads: int) -> Iterator[tuple[Key, Result]]:
    """The first job alone, which compiles what all need, then so many at once as there are threads.

    A step loop leaves Python to the other threads while it runs. No thread writes what another one reads: every job has its own plan,
    and memory that it shares with nobody until it leaves it to the next one, so that its numbers do not depend on the company.
    """
    if threads <= 1:
        with one_thread():  # to limit that for each of them anew takes a hundredth of a short one
            yield from ((key, work(job)) for key, job in jobs.items())
        return
    yield from ((key, work(job)) for key, job in islice(jobs.items(), 1))
    pool = ThreadPoolExecutor(threads, "design")
    try:
        futures = {pool.submit(work, job): key for key, job in islice(jobs.items(), 1, None)}
        for future in as_completed(futures):
            yield futures[future], future.result()
    finally:
        pool.shutdown(cancel_futures=True)
