"""Work side by side in processes of their own on this machine."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context, parent_process
from threading import Thread
from typing import Any

from toolkit.foundation.processes.own_process import refuse_namesakes, safe_spawning
from toolkit.studies.places.study_error import StudyError

_AT_HAND: list[Callable[[Any], Any]] = []
"""In a process of a pool: the work that it was started for, which was sent to it once."""


def in_processes(work: Callable[[Any], Any], tasks: Mapping[Any, Any], count: int, remedy: str) -> Iterator[tuple[Any, Any]]:
    """What the work makes of each task, as it gets done; the work is sent to every process once, and tasks one by one.

    A script that asks for this needs `if __name__ == "__main__":`. Whoever stops listening lets the tasks that are running end, and no
    others begin.

    Raises
    ------
    StudyError
        A process was killed, as happens when memory runs out; `remedy` tells what to do then.
    """
    refuse_namesakes()
    with safe_spawning():
        pool = ProcessPoolExecutor(min(count, len(tasks)), get_context("spawn"), _begin, (work,))
        try:
            futures = {pool.submit(_at_hand, task): key for key, task in tasks.items()}
            for future in as_completed(futures):
                yield futures[future], future.result()
        except BrokenProcessPool as error:
            raise StudyError(f"a process of the study was killed, perhaps because memory ran out. {remedy}") from error
        finally:
            pool.shutdown(cancel_futures=True)


def _begin(work: Callable[[Any], Any]) -> None:
    """Ctrl-C belongs to the process that a person sees; this one ends its task, and ends at once where that process is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, name="parent", daemon=True).start()
    _AT_HAND.append(work)


def _end_with_parent() -> None:
    """Nobody would fetch what this process finds: it would wait for tasks for ever."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _at_hand(task: Any) -> Any:
    return _AT_HAND[0](task)
