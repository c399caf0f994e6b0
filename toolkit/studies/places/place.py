"""A place for the work of a study, and the work done there."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from itertools import islice
from typing import TypeVar

from toolkit.foundation.errors import InputError
from toolkit.foundation.processes.one_thread import one_thread
from toolkit.studies.places.dask_cluster import on_cluster
from toolkit.studies.places.processes import in_processes

Key = TypeVar("Key")
Task = TypeVar("Task")
Found = TypeVar("Found")
Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Place:
    """Where many runs are done; numbers do not depend on it.

    Attributes
    ----------
    processes
        How many run at once, each in a process of its own.
    threads
        How many run at once in this process instead.
    dask
        Address of a Dask scheduler whose workers do it, for example "tcp://10.0.0.1:8786"; empty for this machine.

    Raises
    ------
    InputError
        A number is none, or two places are named.
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


HERE = Place()
"""This process, one piece of work after another."""


def done_at(
    place: Place,
    work: Callable[[Task], Found],
    tasks: Mapping[Key, Task],
    remedy: str = "Ask for fewer processes.",
    more: Callable[[], Mapping[Key, Task]] = dict,
) -> Iterator[tuple[Key, Found]]:
    """What the work makes of each task, as it gets done.

    Work and tasks are sent to where they are done: the work once to every process or worker, where it may keep what all tasks have in
    common. Whoever stops listening lets the tasks that are running end, and no others begin. When all tasks are done, `more` is asked for
    others, which follow from what was found, until it has none.

    Raises
    ------
    StudyError
        A process was killed, or the cluster is gone; `remedy` tells what to do then.
    """
    if place.processes > 1 and len(tasks) > 1 and not place.dask:
        return in_processes(work, tasks, place.processes, remedy, more)
    return _in_rounds(
        lambda each: on_cluster(work, each, place.dask, remedy) if place.dask else _here(work, each, place.threads), tasks, more
    )


def _in_rounds(
    done: Callable[[Mapping[Key, Task]], Iterator[tuple[Key, Found]]],
    tasks: Mapping[Key, Task],
    more: Callable[[], Mapping[Key, Task]],
) -> Iterator[tuple[Key, Found]]:
    """What becomes of some tasks, then of those that follow from them."""
    while tasks:
        yield from done(tasks)
        tasks = more()


def _here(work: Callable[[Task], Found], tasks: Mapping[Key, Task], threads: int) -> Iterator[tuple[Key, Found]]:
    """The first task alone, which compiles what all need, then so many at once as there are threads.

    A step loop leaves Python to the other threads while it runs. No thread writes what another one reads: every design has its own plan,
    and memory that it shares with nobody until it leaves it to the next one, so that its numbers do not depend on the company.
    """
    if threads <= 1:
        with one_thread():  # to limit that for each of them anew takes a hundredth of a short one
            yield from ((key, work(task)) for key, task in tasks.items())
        return
    yield from ((key, work(task)) for key, task in islice(tasks.items(), 1))
    pool = ThreadPoolExecutor(threads, "design")
    try:
        futures = {pool.submit(work, task): key for key, task in islice(tasks.items(), 1, None)}
        for future in as_completed(futures):
            yield futures[future], future.result()
    finally:
        pool.shutdown(cancel_futures=True)
