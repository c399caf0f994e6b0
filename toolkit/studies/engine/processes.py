"""Work side by side in processes of their own on this machine."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import current_process, get_context, parent_process
from multiprocessing.synchronize import Event
from pathlib import Path
from threading import Thread
from typing import Any

from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.processes.own_process import refuse_namesakes, safe_spawning

_AT_HAND: list[Callable[[Any], Any]] = []
"""In a process of a pool: the work that it was started for, which was sent to it once."""
UNGUARDED = (
    'a study in several processes was started outside of `if __name__ == "__main__":`. Each process first runs the script that started '
    "it, and would start the study once more. Put what starts it under this line."
)


class StudyError(ToolkitError, RuntimeError):
    """A process, a worker or a cluster of a study ended without a word."""


def in_processes(
    work: Callable[[Any], Any], tasks: Mapping[Any, Any], count: int, remedy: str, more: Callable[[], Mapping[Any, Any]] = dict
) -> Iterator[tuple[Any, Any]]:
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


def _begin(work: Callable[[Any], Any], begun: Event) -> None:
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


def _at_hand(task: Any) -> Any:
    return _AT_HAND[0](task)
