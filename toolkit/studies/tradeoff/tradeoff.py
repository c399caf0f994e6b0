"""Speed against accuracy, measured: a grid of settings against a reference, and the cheapest one that keeps a budget.

Settings judged by their errors and their price.

Errors of a setting relative to the reference, of responses and of their gradients.

With the reference R, g and the size s_x of what a relative change of the variable x refers to

    error of a response R_k:    |R_k - R| / |R|
    error of its gradient g_k:  max_x |g_k,x - g_x| s_x / max_x |g_x| s_x

so that a derivative which happens to be near zero is compared with those that matter. Where the denominator is less than
`reference.NEGLIGIBLE` of the other one, as that of a response which is zero, this part of the other one takes its place.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from toolkit.analyses.sensitivity.chosen_frames import automatic
from toolkit.analyses.sensitivity.preparation import responses_of
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.studies.executor import Progress
from toolkit.studies.tradeoff.axes import read_axes
from toolkit.studies.tradeoff.frame_axes import framed
from toolkit.studies.tradeoff.reference import Reference, find_reference
from toolkit.studies.tradeoff.setting import (
    BudgetError,
    Choice,
    ErrorQuantity,
    Setting,
    SettingOutcome,
    grid,
    options_with,
    read_budget,
)
from toolkit.studies.tradeoff.setting_run import Case, fingerprint, model_bodies, run_settings, tables_file, time_settings

TIME_NOISE = 1.05
"""Times that differ by less than this factor are equal: medians of a few runs say no more."""


@dataclass(frozen=True)
class JudgedSetting:
    """A setting, its outcome, its errors, and the largest part of any budget that an error takes.

    `ratio` counts the estimated error of the reference on top of that of the setting, so that 1 or less keeps the budget for sure.
    A setting that failed has no errors and an infinite ratio.
    """

    setting: Setting
    outcome: SettingOutcome
    errors: dict[ErrorQuantity, float]
    ratio: float
    worst: ErrorQuantity | None
    budgeted: frozenset[ErrorQuantity] = frozenset()

    @property
    def price(self) -> float:
        """Time in s of a run with gradients, or of one without if there are no design variables."""
        return self.outcome.medians[1]

    @property
    def kept(self) -> bool:
        """Whether it keeps the budget."""
        return self.ratio <= 1

    def largest(self, derived: bool) -> float:
        """Largest error of all responses that have a budget, or of all such gradients."""
        return max((self.errors[quantity] for quantity in self.budgeted if quantity.derived == derived), default=math.nan)


def judge(setting: Setting, outcome: SettingOutcome, reference: Reference, budget: dict[ErrorQuantity, float]) -> JudgedSetting:
    """Errors of an outcome against the reference and the budget."""
    if outcome.failed:
        return JudgedSetting(setting, outcome, {}, math.inf, None)
    found = errors(reference, outcome)
    ratios = {quantity: (found[quantity] + reference.error(quantity)) / limit for quantity, limit in budget.items()}
    worst = max(ratios, key=lambda quantity: ratios[quantity])
    return JudgedSetting(setting, outcome, found, ratios[worst], worst, frozenset(budget))


def cheapest(settings: Sequence[JudgedSetting]) -> JudgedSetting | None:
    """The fastest setting that keeps the budget; of those as fast within noise, the most exact."""
    kept = [each for each in settings if each.kept]
    if not kept:
        return None
    fastest = min(each.price for each in kept)
    return min((each for each in kept if each.price <= TIME_NOISE * fastest), key=lambda each: each.ratio)


def errors(reference: Reference, outcome: SettingOutcome) -> dict[ErrorQuantity, float]:
    """Quantity -> relative error; infinite for a number that does not exist."""
    found = {}
    for name, each in reference.limits.items():
        found[ErrorQuantity(name, False)] = abs(outcome.value(name) - each.value) / reference.scale(ErrorQuantity(name, False))
    for name, slopes in reference.slopes.items():
        worst = max((abs(outcome.slope(name, x) - each.value) * reference.sizes[x] for x, each in slopes.items()), default=0.0)
        found[ErrorQuantity(name, True)] = worst / reference.scale(ErrorQuantity(name, True))
    return {quantity: math.inf if math.isnan(error) else error for quantity, error in found.items()}


def pareto(points: Sequence[tuple[float, float]]) -> list[int]:
    """Numbers of the points (time, error) that no other dominates, by rising time; of equal points the first.

    A point dominates another if it is not larger in either and smaller in one. Points that are not finite belong to no set.
    """
    finite = [k for k, point in enumerate(points) if all(map(math.isfinite, point))]
    found, least = [], math.inf
    for k in sorted(finite, key=lambda k: points[k]):
        if points[k][1] < least:
            found.append(k)
            least = points[k][1]
    return found


ALL_MODES = 10_000
"""Modes of a part that no part has: it keeps all its coordinates."""


def solver_fragment(case: Case, setting: Setting) -> str:
    """The table [solver] that takes the place of the scene's; what is the default anyway stands in it only if it did before."""
    scene, plain = case.scene(), RunOptions().model_dump()
    options = options_with(scene, setting.solver).model_dump(exclude_unset=True)
    kept = {key: value for key, value in options.items() if key in scene.solver.model_fields_set or value != plain[key]}
    return toml_table("solver", kept)


def changes(case: Case, setting: Setting) -> dict[str, str]:
    """The same as changes of single values, `ffrf ... --set PATH=VALUE`, of those that differ from the scene's."""
    scene = case.scene()
    mine, theirs = scene.solver.model_dump(), options_with(scene, setting.solver).model_dump(exclude_unset=True)
    solver = {f"solver.{key}": toml_value(value) for key, value in theirs.items() if mine.get(key) != value}
    return {
        **solver,
        **{f"bodies.{name}.{key}": str(n) for name, keys in frames(case, setting).items() for key, n in keys.items()},
    }


def frames(case: Case, setting: Setting) -> dict[str, dict[str, int]]:
    """Body -> its number of floating frames, and of modes in each part, as far as the scene has others."""
    scene, found = case.scene(), {}
    for name, body in framed(scene, setting.frames, setting.modes).bodies.items():
        if body is not scene.bodies[name] and body != scene.bodies[name]:
            new, old = ({key: getattr(each, key) for key in ("frames", "modes_per_frame")} for each in (body, scene.bodies[name]))
            found[name] = {key: ALL_MODES if n is None else n for key, n in new.items() if n != old[key]}
    return found


def skin_fragments(case: Case, setting: Setting) -> dict[str, str]:
    """Body -> the tables of its skin file that take the place of those that are there."""
    found = {}
    for body in model_bodies(case.scene(), setting):
        tables = json.loads(tables_file(case.model_file(body, setting.skin)).read_text(encoding="utf-8"))
        if tables:
            found[body] = "\n\n".join(toml_table(name, table) for name, table in tables.items())
    return found


def next_steps(case: Case, setting: Setting) -> Iterator[str]:
    """What to do with a fragment, in words."""
    if chosen := changes(case, setting):
        yield "To try it: " + " ".join(f"--set '{path}={text}'" for path, text in chosen.items())


def toml_table(name: str, content: Mapping[str, object]) -> str:
    """A table under its header; tables in it are written inline."""
    return "\n".join([f"[{name}]", *(f"{key} = {toml_value(value)}" for key, value in content.items())])


def toml_value(value: object) -> str:
    """One value, exactly."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Mapping):
        inside = ", ".join(f"{key} = {toml_value(each)}" for key, each in value.items())
        return f"{{ {inside} }}" if inside else "{}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(toml_value, value))}]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


Stage = Callable[[str], AbstractContextManager[Progress]]
TIMED_RUNS = 5


@dataclass(frozen=True)
class TradeoffPlan:
    """What a study is about to do, checked."""

    case: Case
    scene: Scene
    axes: dict[str, list[Choice]]
    settings: list[Setting]
    budget: dict[ErrorQuantity, float]


@dataclass(frozen=True)
class Tradeoff:
    """What came out: all settings from the fastest to the slowest, failed ones last; the Pareto set; the cheapest within the budget."""

    plan: TradeoffPlan
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
) -> TradeoffPlan:
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
    return TradeoffPlan(case, scene, read, grid(scene, read), budget)


@contextmanager
def silent(_: str) -> Iterator[Progress]:
    """A stage of which nothing is shown."""
    yield lambda done, total: None


def tradeoff(planned: TradeoffPlan, stage: Stage = silent, jobs: int = 1, repeats: int = TIMED_RUNS) -> Tradeoff:
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
