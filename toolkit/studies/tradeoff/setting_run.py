"""Settings run: once for their values and gradients, side by side, and again for their times, one after another."""

from __future__ import annotations

import time as clock
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from toolkit.foundation.errors import NeedsDirectError, ToolkitError
from toolkit.scene.scene import Scene
from toolkit.sensitivity.adjoint.adjoint import adjoint_gradients
from toolkit.sensitivity.choice import choose
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.evaluation import by_name, evaluate_responses, evaluate_with_gradients
from toolkit.sensitivity.preparation import solve
from toolkit.sensitivity.result import result
from toolkit.sensitivity.sizes import variable_sizes
from toolkit.studies.engine.executor import Executor, Progress
from toolkit.studies.engine.jobs import run_jobs
from toolkit.studies.engine.store import RunFolder
from toolkit.studies.tradeoff.case import Case
from toolkit.studies.tradeoff.setting import Setting
from toolkit.studies.tradeoff.setting_outcome import SettingOutcome
from toolkit.system.solution import Solution


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
        return _outcome(case.scene_of(setting), list(case.names))
    except ToolkitError as error:
        return SettingOutcome(reason=str(error) or type(error).__name__)


def _outcome(scene: Scene, names: list[str]) -> SettingOutcome:
    found, method = gradients_once(prepare_run(scene, names))
    solution = found.solution
    named = result(scene, solution, found.values, found.gradients, method, 0.0, 0.0)
    return SettingOutcome(
        values=named.values,
        gradients=named.gradients,
        seconds=found.seconds,
        units=named.units,
        sizes=variable_sizes(scene, named) if names else {},
        method=method,
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
                ready[key] = prepare_run(case.scene_of(at[key]), list(case.names), found[key].method)
                values_once(ready[key]), gradients_once(ready[key])
            found[key] = _once_more(ready[key], found[key])
            store.keep(key, found[key])
            done += 1
            progress(done, total)
    return [found[key] for key in keys]


def _once_more(ready: PreparedRun, outcome: SettingOutcome) -> SettingOutcome:
    primal = values_once(ready).seconds
    whole = gradients_once(ready)[0].seconds if ready.method else primal
    return replace(outcome, primal=[*outcome.primal, primal], whole=[*outcome.whole, whole])


@dataclass(frozen=True)
class PreparedRun:
    """A compiled scene, and the method for its gradients: "direct", "adjoint", or "" for none."""

    compiled: Compiled
    method: str


@dataclass(frozen=True)
class TimedRun:
    """Values, gradients and solution of one run, and its time in s."""

    values: dict[str, Any]
    gradients: dict[str, dict[str, float]]
    solution: Solution
    seconds: float


def prepare_run(scene: Scene, names: list[str], method: str = "") -> PreparedRun:
    """A scene ready to run; by default with the method for gradients that is estimated to be the cheaper one."""
    compiled = Compiled(scene, tuple(names))
    return PreparedRun(compiled, (method or choose(compiled, "transient").method) if names else "")


def values_once(ready: PreparedRun) -> TimedRun:
    """One run to the values alone."""
    begun = clock.perf_counter()
    solution = solve(ready.compiled.primal, "transient")
    values = evaluate_responses(solution)
    return TimedRun(values, {}, solution, clock.perf_counter() - begun)


def gradients_once(ready: PreparedRun) -> tuple[TimedRun, str]:
    """One run to values and gradients, and the method that could do it: the adjoint may turn out to need the direct one."""
    if not ready.method:
        return values_once(ready), ""
    if ready.method == "direct":
        return _direct(ready), "direct"
    try:
        return _adjoint(ready), "adjoint"
    except NeedsDirectError:
        return _direct(ready), "direct"


def _direct(ready: PreparedRun) -> TimedRun:
    begun = clock.perf_counter()
    solution = solve(ready.compiled.full, "transient")
    values, gradients = evaluate_with_gradients(solution)
    return TimedRun(values, gradients, solution, clock.perf_counter() - begun)


def _adjoint(ready: PreparedRun) -> TimedRun:
    begun = clock.perf_counter()
    solution = solve(ready.compiled.primal, "transient")
    found, gradient = adjoint_gradients(ready.compiled.full, solution)
    seconds = clock.perf_counter() - begun
    values = {name: partials.value for name, partials in found.items()}
    return TimedRun(values, by_name(ready.compiled.full.design, found, gradient.T), solution, seconds)
