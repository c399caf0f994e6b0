"""Work of a study side by side in processes of their own, or one piece after another in this one."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import TypeVar

from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.processes.own_process import refuse_namesakes, safe_spawning

Key = TypeVar("Key")
Task = TypeVar("Task")
Found = TypeVar("Found")
Progress = Callable[[int, int], None]


class StudyError(ToolkitError, RuntimeError):
    """A process of a study ended without a word."""


def side_by_side(work: Callable[[Task], Found], tasks: Mapping[Key, Task], jobs: int, remedy: str) -> Iterator[tuple[Key, Found]]:
    """What the work makes of each task, as it gets done; `work` and tasks are sent to processes that begin anew.

    A script that asks for more than one job needs `if __name__ == "__main__":`. Whoever stops listening lets the tasks that are running
    end, and no others begin.

    Raises
    ------
    StudyError
        A process was killed, as happens when memory runs out; `remedy` tells what to do then.
    """
    if jobs <= 1 or len(tasks) <= 1:
        yield from ((key, work(task)) for key, task in tasks.items())
        return
    refuse_namesakes()
    with safe_spawning():
        pool = ProcessPoolExecutor(min(jobs, len(tasks)), get_context("spawn"), _leave_interrupts)
        try:
            futures = {pool.submit(work, task): key for key, task in tasks.items()}
            for future in as_completed(futures):
                yield futures[future], future.result()
        except BrokenProcessPool as error:
            raise StudyError(f"a process of the study was killed, perhaps because memory ran out. {remedy}") from error
        finally:
            pool.shutdown(cancel_futures=True)


def _leave_interrupts() -> None:
    """Ctrl-C belongs to the process that a person sees; this one ends its task."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
