"""What becomes of one design among many: numbers, or the reason why there are none."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

from toolkit.door.analysed import analysed
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Verdict
from toolkit.sensitivity.clock import Progress
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.preparation import Kind
from toolkit.studies.processes import side_by_side

PIECES = 4
"""Pieces of work of every process: few, because each compiles the scene, and more than one, because designs differ in their price."""


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
    """Designs that one process analyses after each other."""

    scene: Any
    names: tuple[str, ...]
    designs: list[Mapping[str, float]]
    kind: Kind
    gradients: bool | str
    judged: bool


def outcomes(
    compiled: Compiled,
    designs: Sequence[Mapping[str, float]],
    kind: Kind,
    gradients: bool | str,
    judged: bool,
    processes: int,
    threads: int,
    progress: Progress | None,
) -> list[Outcome]:
    """Outcomes of all designs in their order; arguments as of `Model.map`."""
    tell = progress or (lambda *_: None)
    if processes <= 1:
        done: list[Outcome] = []
        for outcome in _here(partial(_outcome, compiled, kind=kind, gradients=gradients, judged=judged), designs, threads):
            done.append(outcome)
            tell(len(done), len(designs))
        return done
    size = -(-len(designs) // (PIECES * processes)) or 1
    starts = range(0, len(designs), size)
    tasks = {k: Task(compiled.scene, compiled.names, list(designs[k : k + size]), kind, gradients, judged) for k in starts}
    found: dict[int, list[Outcome]] = {}
    for k, piece in side_by_side(analyse, tasks, processes, "Ask for fewer processes."):
        found[k] = piece
        tell(sum(map(len, found.values())), len(designs))
    return [outcome for k in starts for outcome in found[k]]


def _here(
    work: Callable[[Mapping[str, float]], Outcome], designs: Sequence[Mapping[str, float]], threads: int
) -> Iterator[Outcome]:
    """Outcomes in this process: the first one alone, which compiles what all need, then so many at once as there are threads.

    A step loop leaves Python to the other threads while it runs. No thread writes what another one reads: every design has its own plan and
    memory, so that its numbers do not depend on the company.
    """
    yield from map(work, designs[:1])
    if threads <= 1:
        yield from map(work, designs[1:])
        return
    pool = ThreadPoolExecutor(threads, "design")
    try:
        yield from pool.map(work, designs[1:])
    finally:
        pool.shutdown(cancel_futures=True)


def analyse(task: Task) -> list[Outcome]:
    """What a process does."""
    compiled = Compiled(task.scene, task.names)
    return [_outcome(compiled, design, task.kind, task.gradients, task.judged) for design in task.designs]


def _outcome(compiled: Compiled, numbers: Mapping[str, float], kind: Kind, gradients: bool | str, judged: bool) -> Outcome:
    try:
        run = analysed(compiled.at(numbers), kind, gradients)
        return Outcome(dict(numbers), run.values, run.gradients, run.verdict if judged else None)
    except ToolkitError as error:
        return Outcome(dict(numbers), error=str(error))
