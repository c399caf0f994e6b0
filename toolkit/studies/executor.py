"""Jobs of a study, one after another, in threads, in processes or on a Dask cluster; what a store has does not run again."""

from __future__ import annotations

import logging
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import chain, islice
from multiprocessing import current_process, get_context, parent_process
from multiprocessing.synchronize import Event
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from toolkit.foundation.errors import InputError, ToolkitError
from toolkit.foundation.processes import one_thread, refuse_namesakes, safe_spawning
from toolkit.studies.store import JobOutcome, program

if TYPE_CHECKING:
    from distributed import Client

_AT_HAND: list[Callable[..., Any]] = []
"""In a process of a pool: the work that it was started for, which was sent to it once."""
UNGUARDED = (
    'a study in several processes was started outside of `if __name__ == "__main__":`. Each process first runs the script that started '
    "it, and would start the study once more. Put what starts it under this line."
)


class StudyError(ToolkitError, RuntimeError):
    """A process, a worker or a cluster of a study ended without a word."""


def in_processes(
    work: Callable[[Job], Result],
    tasks: Mapping[Key, Job],
    count: int,
    remedy: str,
    more: Callable[[], Mapping[Key, Job]] = dict,
) -> Iterator[tuple[Key, Result]]:
    """What the work makes of each task, as it gets done; the work is sent to every process once, and tasks one by one.

    When all are done, `more` is asked for others, until it has none.

    A script that asks for this needs `if __name__ == "__main__":`; without it no process begins, and the error says so. Whoever stops
    listening lets the tasks that are running end, and no others begin.

    Raises
    ------
    StudyError
        A process was killed, as happens when memory runs out; `remedy` tells what to do then. Or none could begin.
    """
    if _in_import():
        raise SystemExit(UNGUARDED)
    refuse_namesakes()
    with safe_spawning():
        context = get_context("spawn")
        begun = context.Event()
        pool = ProcessPoolExecutor(min(count, len(tasks)), context, _begin, (work, begun))
        try:
            while tasks:
                futures = {pool.submit(_at_hand, task): key for key, task in tasks.items()}
                for future in as_completed(futures):
                    yield futures[future], future.result()
                tasks = more()
        except BrokenProcessPool as error:
            raise StudyError(_reason(remedy) if begun.is_set() else _no_begin(remedy)) from error
        finally:
            pool.shutdown(cancel_futures=True)


def _reason(remedy: str) -> str:
    return f"a process of the study was killed, perhaps because memory ran out. {remedy}"


def _no_begin(remedy: str) -> str:
    """Why no process came as far as its work: it runs the script of this process first, unless that is no file."""
    script = getattr(sys.modules["__main__"], "__file__", None)
    try:
        guarded = script is None or "__name__" in Path(script).read_text(encoding="utf-8", errors="replace")
    except OSError:
        guarded = True
    if not guarded:
        return UNGUARDED
    return f"the processes of the study ended before their work began. What they wrote says why; or memory ran out. {remedy}"


def _in_import() -> bool:
    """Whether this process runs the script of the one that started it, before its own work, when Python lets it start no others."""
    return getattr(current_process(), "_inheriting", False)


def _begin(work: Callable[..., object], begun: Event) -> None:
    """Ctrl-C belongs to the process that a person sees; this one ends its task, and ends at once where that process is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, name="parent", daemon=True).start()
    _AT_HAND.append(work)
    begun.set()


def _end_with_parent() -> None:
    """Nobody would fetch what this process finds: it would wait for tasks for ever."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _at_hand(task: object) -> Any:
    return _AT_HAND[0](task)


STARTING_SECONDS = 20
"""Seconds for which scheduler and workers are waited for."""


def on_cluster(
    work: Callable[[Job], Result], tasks: Mapping[Key, Job], address: str, remedy: str
) -> Iterator[tuple[Key, Result]]:
    """What the work makes of each task, as it gets done.

    The work travels once to every worker, where all of its tasks share it, and what they compile. It is a task of its own: if the only
    worker that holds it is killed, the scheduler sends it to another one.

    Raises
    ------
    InputError
        Dask is not installed, or nobody answers at the address, or nobody works there.
    StudyError
        The cluster ended, or workers are killed again and again; or they run another version of the program.
    """
    if find_spec("distributed") is None:
        raise InputError(
            "--dask needs the package distributed, which is not installed. Install: pip install 'ffrf-toolkit[studies]'."
        )
    import distributed

    with _silent_logs(), _client(address) as client:
        at_hand = client.submit(arrived, work, program(), pure=False)
        futures = {client.submit(run, at_hand, task, pure=False): key for key, task in tasks.items()}
        try:
            for future in distributed.as_completed(list(futures), loop=client.loop):
                if future.status == "cancelled":
                    raise StudyError(f"the Dask cluster at {address} is gone. {remedy}")
                yield futures.pop(future), future.result()
        except (distributed.KilledWorker, distributed.client.FutureCancelledError) as error:
            raise StudyError(
                f"workers of the Dask cluster at {address} were killed again and again: {error}. {remedy}"
            ) from error
        finally:
            client.cancel(list(futures), force=True)


@contextmanager
def _silent_logs() -> Iterator[None]:
    """What Dask tells its own log about lost connections is told by this module's errors."""
    log = logging.getLogger("distributed")
    before = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        log.setLevel(before)


def _client(address: str) -> Client:
    """A client of a cluster that has workers."""
    import distributed

    try:
        client = distributed.Client(address, timeout=STARTING_SECONDS, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(
            f"no Dask scheduler answers at {address!r} ({type(error).__name__}). Start one with `dask scheduler`, and give the address "
            "that it prints."
        ) from error
    try:
        client.wait_for_workers(1, timeout=STARTING_SECONDS)
    except TimeoutError as error:
        client.close()
        raise InputError(
            f"the Dask scheduler at {address!r} has no workers. Start some: `dask worker {address} --nthreads 1`."
        ) from error
    return client


def arrived(work: Callable[[Job], Result], version: str) -> Callable[[Job], Result]:
    """The work on a worker, if that runs the same program."""
    if program() != version:
        raise StudyError(
            "a worker of the Dask cluster runs another version of ffrf-toolkit, whose numbers might differ. Install the same one there."
        )
    return work


def run(work: Callable[[Job], Result], task: Job) -> Result:
    """One task, on a worker."""
    return work(task)


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


KeyOf = TypeVar("KeyOf", contravariant=True)
JobResult = TypeVar("JobResult", bound=JobOutcome)
AGAIN = "What was finished is kept: run the same command again, with --jobs 1."
"""What to do where a process or a cluster was lost."""


class OutcomeStore(Protocol[KeyOf, JobResult]):
    """What a store does for an engine."""

    def find(self, key: KeyOf) -> JobResult | None:
        """The outcome of a key; None if there is none."""

    def keep(self, key: KeyOf, found: JobResult) -> None:
        """Keep an outcome."""


def run_jobs(
    work: Callable[[Job], JobResult],
    jobs: Mapping[Key, Job],
    store: OutcomeStore[Key, JobResult],
    executor: Executor = SERIAL,
    progress: Progress | None = None,
    *,
    remedy: str = AGAIN,
    compile_first: bool = False,
) -> dict[Key, JobResult]:
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
