"""What becomes of one design among many: numbers, or the reason why there are none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from toolkit.door.analysed import analysed
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Verdict
from toolkit.scene.scene import Scene
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.preparation import Kind, Progress
from toolkit.sensitivity.run import Run
from toolkit.studies.carried_verdicts import Answers, CarriedVerdicts, Measured, answers, apart, measured, written_numbers
from toolkit.studies.executor import Executor, completed


@dataclass(frozen=True)
class Outcome:
    """Result of one design of `Model.map`.

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


KEPT, SMALL = 200, 100_000
"""So many runs wait for their verdict in memory, of at most so many coordinates and derivatives of these at all times: some 1 to 3 MB
each. Others are solved again where it is to be measured."""


class Task(NamedTuple):
    """Design with its number, whether its verdict is to be measured, and whether that could be carried to no other one."""

    number: int
    numbers: Mapping[str, float]
    judged: bool
    alone: bool = False


class Solved(NamedTuple):
    """Solved task; `answers` and `measured` are what verdicts of other designs can be carried by."""

    outcome: Outcome
    answers: Answers | None = None
    measured: Measured | None = None


@dataclass(frozen=True)
class Designs:
    """Analysis of one design after the other of a compiled scene, which every process compiles once.

    Attributes
    ----------
    compiled
        The scene; what is compiled of it stays in this process.
    kind, gradients, judged
        As of `Model.map`.
    runs
        Number of a design -> its run, where that was not judged and may have to be; only of short runs, and not of too many.
    """

    compiled: Compiled
    kind: Kind
    gradients: bool | str
    judged: bool | str
    runs: dict[int, Run] = field(default_factory=dict)

    def __call__(self, task: Task) -> Solved:
        """Outcome of a design, with what its verdict is measured or carried by."""
        numbers = dict(task.numbers)
        try:
            run = self.runs.pop(task.number, None)
            if run is None:
                run = analysed(self.compiled.at(task.numbers), self.kind, self.gradients)
            if self.judged is not True:
                return Solved(Outcome(numbers, run.values, run.gradients, run.verdict if self.judged else None))
            judged = measured(run, task.alone) if task.judged else None
            if judged is None and len(self.runs) < KEPT and run.solution.dq.size + run.solution.q.size < SMALL:
                self.runs[task.number] = run
            return Solved(Outcome(numbers, run.values, run.gradients), answers(run, judged is not None), judged)
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
    work, rounds = Designs(compiled, kind, gradients, judged), _Rounds(compiled.scene, designs, judged is True)
    for k, solved in completed(executor, work, rounds.first(), more=rounds.more):
        rounds.take(k, solved)
        if progress:
            progress(len(rounds.found), len(designs))
    return rounds.outcomes()


class _Rounds:
    """Rounds of solving the designs of a map: once all, then again those that no verdict can be carried to.

    Parameters
    ----------
    scene
        The scene at its own numbers.
    designs
        As of `Model.map`.
    carried
        Whether outcomes get verdicts here, instead of in the task.
    """

    def __init__(self, scene: Scene, designs: Sequence[Mapping[str, float]], carried: bool) -> None:
        self.designs, self.found = designs, dict[int, Solved]()
        self.written = written_numbers(scene, designs) if carried else []
        self.verdicts: CarriedVerdicts | None = None

    def first(self) -> dict[int, Task]:
        """Tasks of all designs, with those to be judged in any case."""
        judged = apart(self.written)
        return {k: Task(k, each, k in judged, not judged.get(k, True)) for k, each in enumerate(self.designs)}

    def take(self, k: int, solved: Solved) -> None:
        """Store a solved design; of one that was solved before, its verdict."""
        if self.verdicts is None:
            self.found[k] = solved
        elif solved.measured is not None:
            self.verdicts.learn(k, solved.measured)
        else:
            self.found[k] = solved
            self.verdicts.forget(k)

    def more(self) -> dict[int, Task]:
        """Tasks of designs to be judged next."""
        if not self.written:
            return {}
        if self.verdicts is None:
            known = {k: each.answers for k, each in sorted(self.found.items()) if each.answers is not None}
            self.verdicts = CarriedVerdicts(self.written, known)
            for k in known:
                if (measured := self.found[k].measured) is not None:
                    self.verdicts.learn(k, measured)
        return {k: Task(k, self.designs[k], True) for k in self.verdicts.wanted()}

    def outcomes(self) -> list[Outcome]:
        """Outcomes of all designs in their order."""
        known = {} if self.verdicts is None else {k: self.verdicts.verdict(k) for k in self.verdicts.found}
        found = {k: each.outcome for k, each in sorted(self.found.items())}
        return [replace(each, verdict=known[k]) if k in known else each for k, each in found.items()]
