"""What becomes of one design among many: numbers, or the reason why there are none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from toolkit.door.analysed import analysed
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Verdict
from toolkit.scene.scene import Scene
from toolkit.sensitivity.clock import Progress
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.preparation import Kind
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
    judged: bool

    def __call__(self, numbers: Mapping[str, float]) -> Outcome:
        """What becomes of a design."""
        try:
            run = analysed(self.compiled.at(numbers), self.kind, self.gradients)
            return Outcome(dict(numbers), run.values, run.gradients, run.verdict if self.judged else None)
        except ToolkitError as error:
            return Outcome(dict(numbers), error=str(error))

    def __reduce__(self) -> tuple[Any, ...]:
        return _designs, (self.compiled.scene, self.compiled.names, self.kind, self.gradients, self.judged)


def _designs(scene: Scene, names: tuple[str, ...], kind: Kind, gradients: bool | str, judged: bool) -> Designs:
    return Designs(Compiled(scene, names), kind, gradients, judged)


def outcomes(
    compiled: Compiled,
    designs: Sequence[Mapping[str, float]],
    kind: Kind,
    gradients: bool | str,
    judged: bool,
    executor: Executor,
    progress: Progress | None,
) -> list[Outcome]:
    """Outcomes of all designs in their order; arguments as of `Model.map`."""
    found: dict[int, Outcome] = {}
    for k, outcome in completed(executor, Designs(compiled, kind, gradients, judged), dict(enumerate(designs))):
        found[k] = outcome
        if progress:
            progress(len(found), len(designs))
    return [found[k] for k in range(len(designs))]
