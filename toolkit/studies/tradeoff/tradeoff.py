"""Speed against accuracy, measured: a grid of settings against a reference, and the cheapest one that keeps a budget."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.scene_file.reader import read_scene
from toolkit.sensitivity.frames.chosen_frames import automatic
from toolkit.sensitivity.preparation import responses_of
from toolkit.studies.engine.executor import Progress
from toolkit.studies.tradeoff.axes import read_axes
from toolkit.studies.tradeoff.budget import BudgetError, ErrorQuantity, read_budget
from toolkit.studies.tradeoff.case import Case, fingerprint
from toolkit.studies.tradeoff.judgement import JudgedSetting, cheapest, judge, pareto
from toolkit.studies.tradeoff.reference import Reference, find_reference
from toolkit.studies.tradeoff.setting import Choice, Setting, grid
from toolkit.studies.tradeoff.setting_run import run_settings, time_settings

Stage = Callable[[str], AbstractContextManager[Progress]]
REPEATS = 5


@dataclass(frozen=True)
class Plan:
    """What a study is about to do, checked."""

    case: Case
    scene: Scene
    axes: dict[str, list[Choice]]
    settings: list[Setting]
    budget: dict[ErrorQuantity, float]


@dataclass(frozen=True)
class Tradeoff:
    """What came out: all settings from the fastest to the slowest, failed ones last; the Pareto set; the cheapest within the budget."""

    plan: Plan
    reference: Reference
    settings: list[JudgedSetting]
    pareto: list[JudgedSetting]
    recommended: JudgedSetting | None

    @property
    def failed(self) -> list[JudgedSetting]:
        """Settings that the solver or the preprocessing refused."""
        return [each for each in self.settings if each.outcome.failed]

    @property
    def spread(self) -> float:
        """Factor by which repeated runs of a setting differ, the median of all settings: 1 on a machine with nothing else to do."""
        return median(
            [max(each.outcome.whole) / min(each.outcome.whole) for each in self.settings if each.outcome.whole] or [1.0]
        )

    def check(self) -> None:
        """Raise what is to be said if no setting keeps the budget.

        Raises
        ------
        BudgetError
            Says how near the best one comes, what stands in the way, and what to try.
        """
        if self.recommended is None:
            raise BudgetError(_why_none(self))


def plan(
    path: Path,
    folder: Path,
    changes: dict[str, str] | None = None,
    names: Sequence[str] | None = None,
    axes: str | None = None,
    budgets: Sequence[str] = (),
    gradient_budgets: Sequence[str] = (),
) -> Plan:
    """Everything that can be wrong is found here, before the work begins.

    Parameters
    ----------
    path : Path
        The scene's file.
    folder : Path
        Where runs and models are kept, and found again.
    changes : path -> value
        As those of `read_scene`.
    names : sequence of str
        Design variables, by default those that the scene declares; without any, no gradients are measured.
    axes, budgets, gradient_budgets
        As those of `ffrf tradeoff`: "step=0.1/0.05,scheme"; "drive_angle=1e-3".

    Raises
    ------
    InputError
        An axis, a response or a number is invalid.
    """
    changes = changes or {}
    scene = read_scene(path, changes)
    if bodies := automatic(scene):
        raise InputError(
            f'bodies.{bodies[0]}.frames = "auto" is chosen by runs, and this study compares numbers. Write one in the scene, and vary '
            "it: --axes frames=1/2/4/8."
        )
    names = list(scene.design if names is None else names)
    read = read_axes(scene, axes)
    budget = read_budget(list(responses_of(scene)), budgets, gradient_budgets, bool(names))
    case = Case(path.resolve(), changes, tuple(names), folder.resolve(), fingerprint(scene, names))
    return Plan(case, scene, read, grid(scene, read), budget)


@contextmanager
def silent(_: str) -> Iterator[Progress]:
    """A stage of which nothing is shown."""
    yield lambda done, total: None


def tradeoff(planned: Plan, stage: Stage = silent, jobs: int = 1, repeats: int = REPEATS) -> Tradeoff:
    """Run a plan; what its folder has already is not run again.

    Parameters
    ----------
    stage : title -> context with a function for progress
    jobs : int
        Processes that compute values side by side; a script that asks for more than one needs `if __name__ == "__main__":`. Times are
        measured afterwards, one after another.
    repeats : int
        Runs whose median is a setting's time.

    Raises
    ------
    ConvergenceError
        The reference cannot be computed.
    StudyError
        A process was killed.
    """
    case, settings = planned.case, planned.settings
    with stage("reference") as progress:
        reference = find_reference(
            planned.scene, planned.axes, planned.budget, lambda wanted: run_settings(case, wanted, jobs, progress)
        )
    with stage("settings") as progress:
        outcomes = run_settings(case, settings, jobs, progress)
    with stage("times") as progress:
        outcomes = time_settings(case, settings, outcomes, repeats, progress)
    judged = [judge(setting, each, reference, planned.budget) for setting, each in zip(settings, outcomes, strict=True)]
    judged.sort(key=lambda each: (each.outcome.failed, each.price))
    best = pareto([(each.price, each.ratio) for each in judged])
    return Tradeoff(planned, reference, judged, [judged[k] for k in best], cheapest(judged))


def _why_none(found: Tradeoff) -> str:
    budget, worked = found.plan.budget, [each for each in found.settings if each.worst is not None]
    if not worked:
        return f"no setting could be run; the first one: {found.failed[0].outcome.reason}"
    best = min(worked, key=lambda each: each.ratio)
    quantity = best.worst
    assert quantity is not None
    own = found.reference.error(quantity)
    text = (
        f"no setting keeps the budget. The nearest is {best.setting}: its error of {quantity} is {best.errors[quantity]:.1e}, known to "
        f"{own:.1e}, and the budget {budget[quantity]:.1e}. "
    )
    if own > budget[quantity] / 2:
        return text + (
            f"The reference itself is that uncertain about {quantity}: give it a larger budget, or name the budgets of the others alone"
            + (", or try finer meshes." if found.reference.in_mesh else ", or begin with smaller steps, --set solver.step.")
        )
    if "step" in best.setting.choices:
        half = min(float(each.setting.solver["step"]) for each in worked) / 2
        return text + f"Try smaller steps, --axes step={half:.4g}/{half / 2:.4g}/{half / 4:.4g}, or a larger budget."
    return text + "Vary the step too, --axes step,..., or give a larger budget."
