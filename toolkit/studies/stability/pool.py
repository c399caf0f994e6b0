"""Many scenes measured side by side in processes of their own, or one after another in this one."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context

from toolkit.errors import ToolkitError
from toolkit.scene import Scene
from toolkit.studies.stability.measure import Measured, measure

Progress = Callable[[int, int], None]


class StudyError(ToolkitError, RuntimeError):
    """A process of a study ended without a word."""


@dataclass(frozen=True)
class Task:
    """A scene to be measured; arguments as of `measure`."""

    scene: Scene
    design: list[str]
    sizes: Mapping[str, float] | None = None
    both_methods: bool = True

    def run(self) -> Measured:
        """Measure it."""
        return measure(self.scene, self.design, self.sizes, self.both_methods)


def measured(tasks: Sequence[Task], jobs: int, progress: Progress | None = None) -> list[Measured]:
    """Results in the order of the tasks; equal tasks run once.

    With more than one job the tasks run in processes that begin anew: a script that calls this needs `if __name__ == "__main__":`.

    Raises
    ------
    StudyError
        A process was killed, as happens when memory runs out.
    """
    keys = [repr(task) for task in tasks]
    missing = dict(zip(keys, tasks, strict=True))
    found: dict[str, Measured] = {}
    for key, result in (_aside if jobs > 1 and len(missing) > 1 else _here)(missing, jobs):
        found[key] = result
        if progress:
            progress(len(found), len(missing))
    return [found[key] for key in keys]


def _here(tasks: dict[str, Task], _: int) -> Iterator[tuple[str, Measured]]:
    for key, task in tasks.items():
        yield key, task.run()


def _aside(tasks: dict[str, Task], jobs: int) -> Iterator[tuple[str, Measured]]:
    first, *others = tasks
    yield first, tasks[first].run()  # here: what is not compiled yet would be compiled by every process
    pool = ProcessPoolExecutor(min(jobs, len(others)), get_context("spawn"), _leave_interrupts)
    try:
        futures = {pool.submit(tasks[key].run): key for key in others}
        for future in as_completed(futures):
            yield futures[future], future.result()
    except BrokenProcessPool as error:
        raise StudyError(
            "a process of the study was killed, perhaps because memory ran out. Run it again with --jobs 1 or a smaller --most-steps."
        ) from error
    finally:
        pool.shutdown(cancel_futures=True)


def _leave_interrupts() -> None:
    """Ctrl-C belongs to the process that a person sees; this one ends its task."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
