"""Settings run: once for their values and gradients, side by side, and again for their times, one after another."""

from __future__ import annotations

import json
import os
import time as clock
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from toolkit.analyses.sensitivity.certificate.fresh_models import build_all, given_values, rebuildable, source, with_model
from toolkit.analyses.sensitivity.compiled import Compiled
from toolkit.analyses.sensitivity.direct import by_direct, values_alone
from toolkit.analyses.sensitivity.methods import DIFFERENTIATED, choose
from toolkit.analyses.sensitivity.preparation import variable_sizes
from toolkit.analyses.sensitivity.run import Run
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import NeedsDirectError, ToolkitError
from toolkit.foundation.files.safe_files import write_whole
from toolkit.foundation.files.toml_file import read_toml
from toolkit.reduced_model.file import is_reduced_model
from toolkit.scene.scene import Scene
from toolkit.studies.executor import Executor, Progress, run_jobs
from toolkit.studies.store import RunFolder, file_hashes, hashed, scene_fingerprint
from toolkit.studies.tradeoff.frame_axes import framed
from toolkit.studies.tradeoff.setting import Setting, SettingOutcome, with_options


@dataclass(frozen=True)
class Case:
    """What all settings of a study have in common; small enough to be sent to another process.

    Attributes
    ----------
    path, changes
        The scene's file, and values that replace those in it.
    names
        Design variables; none if no gradients are wanted.
    folder
        Where outcomes and models are kept.
    identity
        `fingerprint` of all this.
    """

    path: Path
    changes: dict[str, str]
    names: tuple[str, ...]
    folder: Path
    identity: str

    def scene(self) -> Scene:
        """The scene as it stands."""
        return read_scene(self.path, self.changes)

    @property
    def models(self) -> Path:
        """Folder of reduced models that were built with other keys."""
        return self.folder / "models"

    def key(self, setting: Setting) -> str:
        """Hash of everything that a setting's outcome follows from."""
        return hashed(self.identity, setting.solver, setting.skin, setting.frames, setting.modes)

    def model_file(self, body: str, keys: dict[str, Any]) -> Path:
        """Where the model of a body with some keys is kept."""
        return self.models / f"{hashed(self.identity, body, keys)}.h5"

    def scene_of(self, setting: Setting) -> Scene:
        """The scene solved by a setting, whose models have been built."""
        scene = with_options(self.scene(), setting.solver)
        for body in model_bodies(scene, setting):
            scene = with_model(scene, body, self.model_file(body, setting.skin).resolve())
        return framed(scene, setting.frames, setting.modes)

    def build_models(self, setting: Setting) -> None:
        """Build all models of a setting that are not there.

        Raises
        ------
        InputError
            The preprocessing refuses a skin file with the setting's keys.
        """
        scene = self.scene()
        for body in model_bodies(scene, setting):
            _build(scene, body, setting.skin, self.model_file(body, setting.skin))


def fingerprint(scene: Scene, names: list[str]) -> str:
    """Hash of a scene with all its files, its variables, and of the program that runs it."""
    return scene_fingerprint(scene, names, file_hashes(_skin_files(scene)))


def _skin_files(scene: Scene) -> list[Path]:
    """The skin files that models are built from, and the airfoils that they name."""
    found = []
    for skin in dict.fromkeys(rebuildable(scene).values()):
        airfoil = read_toml(skin, "a skin.toml").get("airfoil", {})
        found += [skin, *(skin.parent / str(airfoil[key]) for key in ("file", "target") if key in airfoil)]
    return found


def model_bodies(scene: Scene, setting: Setting) -> list[str]:
    """Bodies whose models a setting builds with other keys."""
    return list(rebuildable(scene)) if setting.skin else []


def tables_file(model: Path) -> Path:
    """Where the tables of skin.toml that a model's keys changed are kept."""
    return model.with_suffix(".json")


def _build(scene: Scene, body: str, keys: dict[str, Any], file: Path) -> None:
    """Build a model if it is not there, at the values that the scene gives; beside it what its keys changed in skin.toml."""
    if tables_file(file).is_file() and is_reduced_model(file):
        return
    file.parent.mkdir(parents=True, exist_ok=True)
    mine = file.with_name(f"{file.stem}.{os.getpid()}.h5")  # another process may be building the same one
    wanted = {"file": str(mine.resolve()), "values": given_values(scene, body), "keys": keys}
    try:
        (built,) = build_all(source(scene, body), [wanted])
        mine.replace(file)
    finally:
        mine.unlink(missing_ok=True)
    write_whole(tables_file(file), json.dumps(built["tables"], indent=1).encode())


def kept_outcomes(case: Case) -> RunFolder[SettingOutcome]:
    """The outcomes that the folder of a study has."""
    return RunFolder(case.folder / "records", SettingOutcome)


def run_settings(case: Case, settings: Sequence[Setting], jobs: int, progress: Progress) -> list[SettingOutcome]:
    """Outcomes of settings in their order; those that are kept already are not run again.

    Raises
    ------
    StudyError
        A process was killed, as happens when memory runs out.
    """
    wanted = {case.key(setting): setting for setting in _models_first(settings)}
    found = run_jobs(partial(run_setting, case), wanted, kept_outcomes(case), Executor(jobs), progress)
    return [found[case.key(setting)] for setting in settings]


def _models_first(settings: Sequence[Setting]) -> list[Setting]:
    """One setting of every reduced model first, so that no two processes build the same one at a time."""
    met: Counter[str] = Counter()
    turns = []
    for setting in settings:
        turns.append(met[str(setting.skin)])
        met[str(setting.skin)] += 1
    return [settings[k] for k in sorted(range(len(settings)), key=lambda k: turns[k] > 0)]


def run_setting(case: Case, setting: Setting) -> SettingOutcome:
    """Run a setting once; a refusal of the toolkit is what came out."""
    try:
        case.build_models(setting)
        return _outcome(case.scene_of(setting), case.names)
    except ToolkitError as error:
        return SettingOutcome(reason=str(error) or type(error).__name__)


def _outcome(scene: Scene, names: tuple[str, ...]) -> SettingOutcome:
    run, seconds = PreparedRun.of(scene, names).once()
    solution = run.solution
    return SettingOutcome(
        values=run.values,
        gradients=run.gradients,
        seconds=seconds,
        units=run.units,
        sizes=variable_sizes(scene, run) if names else {},
        method=run.method if names else "",
        steps=solution.steps,
        newton_iterations=solution.newton_iterations,
        drift=float(solution.drift),
        coordinates=solution.system.n_q,
    )


def time_settings(
    case: Case, settings: Sequence[Setting], outcomes: Sequence[SettingOutcome], repeats: int, progress: Progress
) -> list[SettingOutcome]:
    """The outcomes with the times of so many runs each; those that are kept already count.

    Settings run in one process with nothing beside it, in rounds, so that a slow minute hits all alike. Compiling the scene is no part of
    a time, nor the very first run, in which code and data are loaded. Outcomes of settings that failed stay as they are.
    """
    store, keys = kept_outcomes(case), [case.key(setting) for setting in settings]
    found, at = dict(zip(keys, outcomes, strict=True)), dict(zip(keys, settings, strict=True))
    lacking = {key: repeats - len(each.whole) for key, each in found.items() if not each.failed}
    total, done = sum(max(n, 0) for n in lacking.values()), 0
    ready: dict[str, PreparedRun] = {}
    for turn in range(max(lacking.values(), default=0)):
        for key in [key for key, n in lacking.items() if n > turn]:
            if key not in ready:
                ready[key] = PreparedRun.of(case.scene_of(at[key]), case.names, found[key].method)
                ready[key].once(gradients=False), ready[key].once()
            found[key] = _once_more(ready[key], found[key])
            store.keep(key, found[key])
            done += 1
            progress(done, total)
    return [found[key] for key in keys]


def _once_more(ready: PreparedRun, outcome: SettingOutcome) -> SettingOutcome:
    primal = ready.once(gradients=False)[1]
    whole = ready.once()[1] if ready.method else primal
    return replace(outcome, primal=[*outcome.primal, primal], whole=[*outcome.whole, whole])


@dataclass(frozen=True)
class PreparedRun:
    """A compiled scene that runs again and again, and the method for its gradients: "direct", "adjoint", or "" for none."""

    compiled: Compiled
    method: str

    @classmethod
    def of(cls, scene: Scene, names: tuple[str, ...], method: str = "") -> PreparedRun:
        """A scene ready to run; by default with the method for gradients that is estimated to be the cheaper one."""
        compiled = Compiled(scene, names)
        return cls(compiled, (method or choose(compiled, "transient")[0]) if names else "")

    def once(self, gradients: bool = True) -> tuple[Run, float]:
        """One run to values and gradients, or to the values alone, and its time in s.

        The adjoint may turn out to need direct differentiation.
        """
        begun = clock.perf_counter()
        if not (gradients and self.method):
            run = values_alone(self.compiled, "transient")
            return run, clock.perf_counter() - begun
        try:
            run = DIFFERENTIATED[self.method](self.compiled, "transient")
        except NeedsDirectError:
            begun = clock.perf_counter()
            run = by_direct(self.compiled, "transient")
        return run, clock.perf_counter() - begun
