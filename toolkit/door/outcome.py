"""What becomes of one design among many: numbers, or the reason why there are none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from toolkit.door.analysed import analysed
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Verdict
from toolkit.scene.scene import Scene
from toolkit.sensitivity.clock import Progress
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.preparation import Kind
from toolkit.studies.designs.carried_verdicts import Answers, CarriedVerdicts, Measured, answers, apart, measured
from toolkit.studies.designs.indicators import Indicators, written_numbers
from toolkit.studies.engine.executor import Executor, completed


@dataclass(frozen=True)
class Outcome:
    """One design of `Model.map`.

    Attributes
    ----------
    numbers
        The design.
    values
        Response -> its value; empty if the analysis failed.
    gradients
        Response -> variable -> derivative; empty if it failed, or if none were asked for.
    verdict
        Whether the numbers can be trusted; None if it failed, or if no verdict was asked for.
    error
        Why it failed, in the words of the error; empty if it did not.
    """

    numbers: Mapping[str, float]
    values: Mapping[str, float] = field(default_factory=dict)
    gradients: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    verdict: Verdict | None = None
    error: str = ""

    @property
    def failed(self) -> bool:
        """Whether the analysis of this design raised an error."""
        return bool(self.error)


class Task(NamedTuple):
    """A design, and whether its verdict is to be measured."""

    numbers: Mapping[str, float]
    judged: bool


class Solved(NamedTuple):
    """What becomes of a task; `answers` and `measured` are what verdicts of other designs can be carried by."""

    outcome: Outcome
    answers: Answers | None = None
    measured: Measured | None = None


@dataclass(frozen=True)
class Designs:
    """The work of one design after the other of a compiled scene, which every process compiles once.

    Attributes
    ----------
    compiled
        The scene; what is compiled of it stays in this process.
    kind, gradients, judged
        As of `Model.map`.
    """

    compiled: Compiled
    kind: Kind
    gradients: bool | str
    judged: bool | str

    def __call__(self, task: Task) -> Solved:
        """What becomes of a design."""
        numbers = dict(task.numbers)
        try:
            run = analysed(self.compiled.at(task.numbers), self.kind, self.gradients)
            if self.judged is not True:
                return Solved(Outcome(numbers, run.values, run.gradients, run.verdict if self.judged else None))
            judged = measured(run) if task.judged else None
            return Solved(Outcome(numbers, run.values, run.gradients), answers(run), judged)
        except ToolkitError as error:
            return Solved(Outcome(numbers, error=str(error)))

    def __reduce__(self) -> tuple[Any, ...]:
        return _designs, (self.compiled.scene, self.compiled.names, self.kind, self.gradients, self.judged)


def _designs(scene: Scene, names: tuple[str, ...], kind: Kind, gradients: bool | str, judged: bool | str) -> Designs:
    return Designs(Compiled(scene, names), kind, gradients, judged)


def outcomes(
    compiled: Compiled,
    designs: Sequence[Mapping[str, float]],
    kind: Kind,
    gradients: bool | str,
    judged: bool | str,
    executor: Executor,
    progress: Progress | None,
) -> list[Outcome]:
    """Outcomes of all designs in their order; arguments as of `Model.map`."""
    work = Designs(compiled, kind, gradients, judged)
    written = written_numbers(compiled.scene, designs) if judged is True else []
    first = set(apart(written))
    found: dict[int, Solved] = {}
    for k, solved in completed(executor, work, {k: Task(each, k in first) for k, each in enumerate(designs)}):
        found[k] = solved
        if progress:
            progress(len(found), len(designs))
    if judged is True:
        _judge(work, found, written, executor)
    return [found[k].outcome for k in range(len(designs))]


def _judge(work: Designs, found: dict[int, Solved], written: Sequence[Indicators], executor: Executor) -> None:
    """Give each outcome its verdict; designs that none can be carried to are solved once more for that."""
    verdicts = CarriedVerdicts(written, {k: each.answers for k, each in found.items() if each.answers is not None})
    for k, each in sorted(found.items()):
        if each.measured is not None:
            verdicts.learn(k, each.measured)
    while wanted := verdicts.wanted():
        for k, again in completed(executor, work, {k: Task(found[k].outcome.numbers, True) for k in wanted}):
            if again.measured is None:
                found[k] = again
                verdicts.forget(k)
            else:
                verdicts.learn(k, again.measured)
    for k in verdicts.found:
        found[k] = Solved(replace(found[k].outcome, verdict=verdicts.verdict(k)))
