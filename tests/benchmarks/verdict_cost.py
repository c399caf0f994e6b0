"""What a verdict costs beside the run that it judges, and which of its checks cost most: a Markdown table of all models.

python -m tests.benchmarks.verdict_cost [model ...] [--profile]

Every run is made anew from a compiled model and judged once; the first one is not counted, as it loads compiled code. Times are medians
as the processor counts them, of run and verdict in turn; compare ratios, not times of different machines.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import wraps
from inspect import isfunction
from pathlib import Path
from types import GeneratorType
from typing import Any, NamedTuple

import toolkit
from toolkit.analyses.sensitivity import run as run_checks
from toolkit.analyses.sensitivity.errors import step_error
from toolkit.analyses.sensitivity.preparation import Kind
from toolkit.analyses.sensitivity.run import Run
from toolkit.api.model import Model
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ToolkitError
from toolkit.validity import judge

MODELS = Path(__file__).parents[2] / "models"
REPEATS = 5
ANALYSES: dict[str, tuple[Kind, bool]] = {
    "statics": ("static", False),
    "simulate": ("transient", False),
    "sensitivity": ("transient", True),
}
"""Command -> analysis, and whether gradients are wanted."""
ROOMS = ("toolkit.validity.", "toolkit.analyses.sensitivity.", "toolkit.responses.")
"""Where checks are defined."""
NO_CHECKS = {"responses_of", "moving", "Caution"}
COUNTS = 0.01
"""Part of a verdict below which a check is not listed."""


class Cost(NamedTuple):
    """Medians in s of a run, of its verdict and, as far as these were looked at, of every check in it."""

    run: float
    verdict: float
    checks: dict[str, float]

    @property
    def ratio(self) -> float:
        """Runs that the verdict costs."""
        return self.verdict / self.run


def cost(analyse: Callable[[], Run], repeats: int = REPEATS, profile: bool = False) -> Cost:
    """What a run of an analysis costs, and to judge it; with a `profile` what its checks do, which takes a little time too."""
    runs: list[float] = []
    verdicts: list[float] = []
    checks: dict[str, list[float]] = {}
    for _ in range(repeats + 1):
        begun = time.process_time()
        run = analyse()
        runs.append(time.process_time() - begun)
        watch: AbstractContextManager[dict[str, float]] = timed_checks() if profile else nullcontext({})
        with watch as found:
            begun = time.process_time()
            _ = run.verdict
            verdicts.append(time.process_time() - begun)
        for name, spent in found.items():
            checks.setdefault(name, []).append(spent)
    medians = {name: statistics.median(spent[1:] or spent) for name, spent in checks.items()}
    return Cost(statistics.median(runs[1:]), statistics.median(verdicts[1:]), medians)


@contextmanager
def timed_checks() -> Iterator[dict[str, float]]:
    """Time of the processor in every function that `judge` and `Run.verdict` call, without those that it calls of these itself."""
    spent: dict[str, float] = {}
    clock = _Clock(spent)
    changed = [
        (module, name, each)
        for module in (judge, run_checks, step_error)
        for name, each in vars(module).items()
        if _is_check(each)
    ]
    for module, name, each in changed:
        setattr(module, name, clock.watched(name, each))
    try:
        yield spent
    finally:
        for module, name, each in changed:
            setattr(module, name, each)


def _is_check(each: Any) -> bool:
    return isfunction(each) and each.__module__.startswith(ROOMS) and each.__name__ not in NO_CHECKS


class _Clock:
    """Adds up own times of watched functions, and of the generators that they return."""

    def __init__(self, spent: dict[str, float]) -> None:
        self.spent, self.inside = spent, [0.0]

    @contextmanager
    def running(self, name: str) -> Iterator[None]:
        """Count what happens inside for the name, without what watched functions inside count for themselves."""
        self.inside.append(0.0)
        begun = time.process_time()
        try:
            yield
        finally:
            whole = time.process_time() - begun
            self.spent[name] = self.spent.get(name, 0.0) + whole - self.inside.pop()
            self.inside[-1] += whole

    def watched(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function with a clock."""

        @wraps(function)
        def timed(*arguments: Any, **named: Any) -> Any:
            with self.running(name):
                found = function(*arguments, **named)
            return self.each(name, found) if isinstance(found, GeneratorType) else found

        return timed

    def each(self, name: str, generator: Iterator[Any]) -> Iterator[Any]:
        """What a generator yields, with a clock inside of it."""
        while True:
            with self.running(name):
                found = next(generator, self)
            if found is self:
                return
            yield found


def costs(model: str, repeats: int = REPEATS, profile: bool = False) -> dict[str, Cost]:
    """Command -> cost, of those that work for a model."""
    scene = read_scene(MODELS / model / "scene.toml")
    compiled: Model = toolkit.compile(scene, variables=list(scene.design))
    found = {}
    for command, (kind, gradients) in ANALYSES.items():
        if gradients and not scene.design:
            continue
        try:
            found[command] = cost(lambda: compiled.run(kind, gradients=gradients), repeats, profile)  # noqa: B023
        except ToolkitError:
            continue  # it has no such analysis
    return found


def main() -> None:
    """Print the table, and on request what the checks cost."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="*", help="names of folders in models/, by default all")
    parser.add_argument("--profile", action="store_true", help="list the checks of every verdict, the dearest first")
    parser.add_argument("--repeats", type=int, default=REPEATS)
    options = parser.parse_args()
    names = options.models or sorted(each.parent.name for each in MODELS.glob("*/scene.toml"))
    print("| model | command | run, ms | verdict, ms | verdict / run |\n|---|---|---|---|---|")
    ratios: dict[str, list[float]] = {}
    for name in names:
        for command, each in costs(name, options.repeats, options.profile).items():
            ratios.setdefault(command, []).append(each.ratio)
            print(f"| {name} | {command} | {1e3 * each.run:.2f} | {1e3 * each.verdict:.2f} | {each.ratio:.2f} |", flush=True)
            for check, spent in sorted(each.checks.items(), key=lambda pair: -pair[1]):
                if spent > COUNTS * each.verdict:
                    print(f"    {1e3 * spent:8.2f} ms  {spent / each.run:5.2f} runs  {check}")
    every = {"all": [each for found in ratios.values() for each in found], **ratios}
    print(
        "\n"
        + "\n".join(
            f"{command}: median {statistics.median(each):.2f}, largest {max(each):.2f}" for command, each in every.items()
        )
    )


if __name__ == "__main__":
    main()
