"""Settings of a study run side by side, but for those whose records are kept already."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import partial

from toolkit.studies.places.place import Place, Progress, done_at
from toolkit.studies.tradeoff.runs.worker import Case, measure
from toolkit.studies.tradeoff.settings.record import Record
from toolkit.studies.tradeoff.settings.setting import Setting

REMEDY = "What was finished is kept: run the same command again, with --jobs 1."


def measured(case: Case, settings: Sequence[Setting], jobs: int, progress: Progress) -> list[Record]:
    """Records of all settings, in their order; those that are kept already are not run again.

    Raises
    ------
    StudyError
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
    waiting = dict(enumerate(_models_first(list(missing.values()))))
    for _, record in done_at(Place(jobs), partial(measure, case), waiting, REMEDY):
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
