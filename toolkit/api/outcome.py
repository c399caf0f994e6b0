"""One analysis of a compiled scene, and what becomes of one design among many: numbers, or the reason why there are none."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple, NoReturn

from toolkit.analyses.run_start import known_start
from toolkit.analyses.sensitivity.compiled import Compiled
from toolkit.analyses.sensitivity.direct import again, by_direct, enriched, evaluated, values_alone, with_values
from toolkit.analyses.sensitivity.method_names import METHODS
from toolkit.analyses.sensitivity.methods import by_method, more_frames
from toolkit.analyses.sensitivity.preparation import ANALYSES, Kind, Progress, price, solve
from toolkit.analyses.sensitivity.run import Run
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.foundation.compiled.compile_watch import watched_compilation
from toolkit.foundation.errors import InputError, ToolkitError
from toolkit.foundation.processes import one_thread
from toolkit.foundation.verdict import Verdict
from toolkit.scene.scene import Scene
from toolkit.solvers.start.initial_conditions import continued_start
from toolkit.solvers.start.kept_start import refuse_other_run
from toolkit.studies.carried_verdicts import CarriedVerdicts, DesignAnswers, Measured, answers, apart, measured, written_numbers
from toolkit.studies.executor import Executor, completed
from toolkit.system.evaluation import refuse_changed


@one_thread()
def analysed(
    compiled: Compiled,
    kind: Kind,
    gradients: bool | str = False,
    start: Run | None = None,
    progress: Progress | None = None,
    timed: bool = False,
    keep_states: bool = False,
) -> Run:
    """Run of a compiled scene; arguments as of `Model.run`.

    Raises
    ------
    InputError
        There is no such method, or nothing to differentiate by; and all that the analysis raises.
    """
    check_method(gradients)
    if gradients and not compiled.names:
        raise InputError("gradients of what? The model has no design variables. Name some: compile(scene, variables=[...]).")
    refuse_changed(compiled.files)
    compiled = compiled.analysed_by(kind, more_frames if gradients else None)
    if start is not None:
        if timed:
            raise InputError("the price of a run with a start is not measured. Leave out one of timed and start.")
        return _from_start(compiled, kind, gradients, start, progress)
    if gradients:
        return by_method("auto" if gradients is True else str(gradients), compiled, kind, progress, keep_states, timed)
    with watched_compilation() as watch:
        solution = ANALYSES[kind](compiled.primal, progress=progress)
    return with_values(compiled, kind, solution, price(watch, timed, partial(solve, compiled.primal, kind)))


def check_method(gradients: bool | str) -> None:
    """Refuse a method for gradients that does not exist.

    Raises
    ------
    InputError
        It is neither a truth value nor a name of a method.
    """
    if not isinstance(gradients, bool) and not (isinstance(gradients, str) and gradients in METHODS):
        raise InputError(f"there is no method {gradients!r} for gradients. Write True, False, or one of: {', '.join(METHODS)}.")


def _from_start(compiled: Compiled, kind: Kind, gradients: bool | str, start: Run, progress: Progress | None) -> Run:
    """Run that begins in the last state of another one."""
    if gradients not in (False, True, "direct"):
        raise InputError(
            f"gradients of a run with a start are found by direct differentiation, not {gradients!r}. Write gradients=True."
        )
    if not isinstance(start, Run):
        raise InputError(f"start must be a run that an analysis has returned, not {type(start).__name__}.")
    system, known = (compiled.full if gradients else compiled.primal), start.solution
    if known.system.numbering.names != system.numbering.names:
        raise InputError("start is a run of a scene with other bodies or joints. Give one of the same scene, at any numbers.")
    refuse_other_run(system, known.system)
    if kind == "static":
        found = evaluated(solve_statics(system, progress=progress, start=known), bool(gradients))
        method = by_direct if gradients else values_alone
        return replace(found, enriched=partial(enriched, compiled, kind, found.solution, method))
    options = compiled.scene.solver.model_copy(update={"start": "given"})
    q, v, moved = continued_start(system, known.q[-1], known.v[-1], options)
    motion = simulate(system, options, q=q, v=v, progress=progress)
    repeat = partial(again, system, q=q, v=v, known=known_start(motion))
    solution = replace(motion, start_moved=moved)
    return replace(evaluated(solution, bool(gradients), repeat), enriched=_not_in_more_shapes)


def _not_in_more_shapes() -> NoReturn:
    """Refuse to begin with a richer basis where a run with a frozen basis has ended."""
    raise InputError(
        "The motion begins in the last state of a run with the shapes of the frozen basis, which tells no more of them."
    )


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


MOST_KEPT_RUNS, LARGEST_KEPT_RUN = 200, 100_000
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
    answers: DesignAnswers | None = None
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
            if (
                judged is None
                and len(self.runs) < MOST_KEPT_RUNS
                and run.solution.dq.size + run.solution.q.size < LARGEST_KEPT_RUN
            ):
                self.runs[task.number] = run
            return Solved(Outcome(numbers, run.values, run.gradients), answers(run, judged is not None), judged)
        except ToolkitError as error:
            return Solved(Outcome(numbers, error=str(error)))

    def __reduce__(self) -> tuple[Callable[..., Designs], tuple[object, ...]]:
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
