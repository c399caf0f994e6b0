"""Many scenes measured side by side; equal ones once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from toolkit.scene.scene import Scene
from toolkit.studies.places.place import Place, Progress, done_at
from toolkit.studies.stability.kept_runs import KeptRuns, fingerprint
from toolkit.studies.stability.measure import Measured, measure

REMEDY = "Run it again with --jobs 1 or a smaller --most-steps."


@dataclass(frozen=True)
class Task:
    """A scene to be measured; arguments as of `measure`."""

    scene: Scene
    design: list[str]
    sizes: Mapping[str, float] | None = None
    both_methods: bool = True

    @property
    def key(self) -> str:
        """Hash of all that the run follows from."""
        return fingerprint(self.scene, self.design, self.sizes, self.both_methods)

    def run(self) -> Measured:
        """Measure it."""
        return measure(self.scene, self.design, self.sizes, self.both_methods)


def measured(tasks: Sequence[Task], jobs: int, progress: Progress | None = None, folder: Path | None = None) -> list[Measured]:
    """Results in the order of the tasks; equal tasks run once, and those that a folder holds already do not run again.

    Raises
    ------
    StudyError
        As `done_at`.
    """
    keys, kept = [task.key for task in tasks], KeptRuns(folder)
    wanted = dict(zip(keys, tasks, strict=True))
    found = {key: known for key in wanted if (known := kept.find(key)) is not None}
    missing = {key: task for key, task in wanted.items() if key not in found}
    alone = dict(list(missing.items())[:1])  # what is not compiled yet would be compiled by every process
    others = {key: task for key, task in missing.items() if key not in alone}
    for key, result in chain(*(done_at(Place(jobs), Task.run, part, REMEDY) for part in (alone, others))):
        found[key] = result
        kept.keep(key, result)
        if progress:
            progress(len(found), len(wanted))
    return [found[key] for key in keys]
