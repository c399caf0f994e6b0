"""Settings run side by side in processes of their own, or one after another in this one."""

from __future__ import annotations

import signal
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context

from toolkit.errors import ToolkitError
from toolkit.studies.record import Record
from toolkit.studies.setting import Setting
from toolkit.studies.worker import Case, measure

Progress = Callable[[int, int], None]


class WorkerError(ToolkitError, RuntimeError):
    """A process ended without a word."""


def measured(case: Case, settings: Sequence[Setting], jobs: int, progress: Progress) -> list[Record]:
    """Records of all settings, in their order; those that are kept already are not run again.

    Raises
    ------
    WorkerError
        A process was killed, as happens when memory runs out.
    """
    store, found = case.store, {}
    missing: dict[str, Setting] = {}
    for setting in settings:
        key = case.key(setting)
        if record := store.find(key):
            found[key] = record
        else:
            missing[key] = setting
    done = len(settings) - len(missing)
    progress(done, len(settings))
    for record in (_aside if jobs > 1 and len(missing) > 1 else _here)(case, _models_first(list(missing.values())), jobs):
        found[record.key] = record
        done += 1
        progress(done, len(settings))
    return [found[case.key(setting)].model_copy(update={"labels": setting.labels}) for setting in settings]


def _models_first(settings: list[Setting]) -> list[Setting]:
    """One setting of every reduced model first, so that no two processes build the same one at a time."""
    met: Counter[str] = Counter()
    turns = []
    for setting in settings:
        turns.append(met[str(setting.skin)])
        met[str(setting.skin)] += 1
    return [settings[k] for k in sorted(range(len(settings)), key=lambda k: turns[k] > 0)]


def _here(case: Case, settings: list[Setting], _: int) -> Iterator[Record]:
    for setting in settings:
        yield measure(case, setting)


def _aside(case: Case, settings: list[Setting], jobs: int) -> Iterator[Record]:
    pool = ProcessPoolExecutor(min(jobs, len(settings)), get_context("spawn"), _leave_interrupts)
    try:
        for future in as_completed([pool.submit(measure, case, setting) for setting in settings]):
            yield future.result()
    except BrokenProcessPool as error:
        raise WorkerError(
            "a process of the study was killed, perhaps because memory ran out. What was finished is kept: run the same command again, "
            "with --jobs 1."
        ) from error
    finally:
        pool.shutdown(cancel_futures=True)  # settings that are running end and are kept


def _leave_interrupts() -> None:
    """Ctrl-C belongs to the process that a person sees; this one ends its setting."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
