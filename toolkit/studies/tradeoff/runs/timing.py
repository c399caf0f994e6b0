"""Times of settings: one after another in one process with nothing beside it, in rounds, so that a slow minute hits all alike."""

from __future__ import annotations

from collections.abc import Sequence

from toolkit.studies.places.place import Progress
from toolkit.studies.tradeoff.runs.one_run import Ready, gradients_once, ready_to_run, values_once
from toolkit.studies.tradeoff.runs.worker import Case
from toolkit.studies.tradeoff.settings.record import Record
from toolkit.studies.tradeoff.settings.setting import Setting


def timed(case: Case, settings: Sequence[Setting], records: Sequence[Record], repeats: int, progress: Progress) -> list[Record]:
    """The records with the times of so many runs each; those that are kept already count.

    Compiling the scene is no part of a time, nor the very first run, in which code and data are loaded. Records of settings that
    failed stay as they are.
    """
    store, found = case.store, {record.key: record for record in records}
    at = {case.key(setting): setting for setting in settings}
    lacking = {key: repeats - len(record.whole) for key, record in found.items() if not record.failure}
    total, done = sum(max(n, 0) for n in lacking.values()), 0
    ready: dict[str, Ready] = {}
    for turn in range(max(lacking.values(), default=0)):
        for key in [key for key, n in lacking.items() if n > turn]:
            if key not in ready:
                ready[key] = ready_to_run(case.scene_of(at[key]), list(case.names), found[key].method)
                values_once(ready[key]), gradients_once(ready[key])
            found[key] = _once_more(ready[key], found[key])
            store.keep(found[key])
            done += 1
            progress(done, total)
    return [found[case.key(setting)].model_copy(update={"labels": setting.labels}) for setting in settings]


def _once_more(ready: Ready, record: Record) -> Record:
    primal = values_once(ready).seconds
    whole = gradients_once(ready)[0].seconds if ready.method else primal
    return record.model_copy(update={"primal": [*record.primal, primal], "whole": [*record.whole, whole]})
