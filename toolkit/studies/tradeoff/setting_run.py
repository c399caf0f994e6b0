"""Settings run: once for their values and gradients, side by side, and again for their times, one after another."""

from __future__ import annotations

import time as clock
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

from toolkit.foundation.errors import NeedsDirectError, ToolkitError
from toolkit.scene.scene import Scene
from toolkit.sensitivity.choice import choose
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.direct import by_direct, values_alone
from toolkit.sensitivity.methods import DIFFERENTIATED
from toolkit.sensitivity.run import Run
from toolkit.sensitivity.sizes import variable_sizes
from toolkit.studies.engine.executor import Executor, Progress
from toolkit.studies.engine.jobs import run_jobs
from toolkit.studies.engine.store import RunFolder
from toolkit.studies.tradeoff.case import Case
from toolkit.studies.tradeoff.setting import Setting
from toolkit.studies.tradeoff.setting_outcome import SettingOutcome


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
