"""Designs of a study solved side by side, each once, and what their runs say about themselves."""

from __future__ import annotations

import atexit
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import Any

import numpy as np

from toolkit.analyses.sensitivity.direct import direct
from toolkit.components.bodies.model_body import ModelBody
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.files.safe_files import write_whole
from toolkit.foundation.verdict import Caution
from toolkit.scene.scene import Scene
from toolkit.studies.executor import SERIAL, Executor, Progress, run_jobs
from toolkit.studies.problem import MARGIN_SEARCH_FACTOR, Problem
from toolkit.studies.solved_design import scene_at, solve_design
from toolkit.studies.store import DesignKey, DesignOutcome, DesignStore
from toolkit.studies.study_file import LOAD_MARGIN

WITH_GRADIENTS, WITHOUT_GRADIENTS = 0, 1
"""Lanes of designs with and without gradients."""


@dataclass(frozen=True)
class DesignJob:
    """A design that is to be solved, and what is wanted of it.

    Attributes
    ----------
    lane
        Under which it is kept.
    design
        Values of the variables, (n,).
    gradients
        Whether they are wanted.
    """

    lane: int
    design: np.ndarray
    gradients: bool = True

    @property
    def key(self) -> DesignKey:
        """What its outcome is kept under."""
        return self.lane, self.design.tobytes()


@dataclass(frozen=True)
class DesignWork:
    """Solves designs of a problem; the scene is compiled once wherever this is sent, and what is compiled stays there.

    Attributes
    ----------
    problem
        The checked study.
    start
        A design whose equilibria all others begin in, so that no number depends on their order; None for the unloaded state.
    """

    problem: Problem
    start: DesignOutcome | None = None

    def __call__(self, job: DesignJob) -> DesignOutcome:
        """The design, without the equilibria that it was solved by."""
        return replace(solve_design(self.problem, job.lane, job.design, self.start, job.gradients), states=())

    def __reduce__(self) -> tuple[object, ...]:
        problem = self.problem
        return _made, (self.start, *(getattr(problem, each.name) for each in fields(problem)))


def _made(start: DesignOutcome | None, *parts: Any) -> DesignWork:
    return DesignWork(Problem(*parts), start)


@dataclass(frozen=True)
class WithFiles:
    """The same work with the files that its scene reads, for machines that do not have them.

    Attributes
    ----------
    work
        The work.
    files
        Content of the files, in the order of `Scene.read_files`.
    """

    work: DesignWork
    files: tuple[bytes, ...]

    @classmethod
    def of(cls, work: DesignWork) -> WithFiles:
        """The work with its files as they are now."""
        return cls(work, tuple(path.read_bytes() for path in work.problem.scene.read_files()))

    def __call__(self, job: DesignJob) -> DesignOutcome:
        """The design, in this process."""
        return self.work(job)

    def __reduce__(self) -> tuple[object, ...]:
        return _unpacked, (self.work, self.files)


def _unpacked(work: DesignWork, files: tuple[bytes, ...]) -> WithFiles:
    """The work where its files have been put into a folder of their own."""
    folder, scene = Path(mkdtemp(prefix="ffrf-study-")), work.problem.scene
    atexit.register(rmtree, folder, ignore_errors=True)
    names = {str(path): f"{k}{path.suffix}" for k, path in enumerate(scene.read_files())}
    for name, content in zip(names.values(), files, strict=True):
        write_whole(folder / name, content)
    there = replace(work, problem=replace(work.problem, scene=_with_files(scene, folder, names)))
    with suppress(
        ToolkitError
    ):  # what all designs share, before the threads of a worker ask for it; a refusal is each design's own
        _ = there.problem.compiled.primal, there.problem.compiled.full
    return WithFiles(there, files)


def _with_files(scene: Scene, folder: Path, names: dict[str, str]) -> Scene:
    bodies = {
        name: body.model_copy(update={"model": names[str(scene.directory / body.model)]}) if isinstance(body, ModelBody) else body
        for name, body in scene.bodies.items()
    }
    begun = scene.start_file
    solver = scene.solver if begun is None else scene.solver.model_copy(update={"start_file": names[str(begun)]})
    return scene.model_copy(update={"bodies": bodies, "solver": solver, "directory": folder})


def solve_designs(
    work: DesignWork, jobs: Sequence[DesignJob], store: DesignStore, executor: Executor = SERIAL, progress: Progress | None = None
) -> list[DesignOutcome]:
    """Outcomes in the order of the designs; equal ones are solved once, and those that the store has are not solved again.

    Parameters and errors are those of `run_jobs`; to a Dask cluster the files that the scene reads are sent too.
    """
    sent = WithFiles.of(work) if executor.dask else work
    found = run_jobs(sent, {job.key: job for job in jobs}, store, executor, progress)
    return [found[job.key] for job in jobs]


class NoDesignError(ToolkitError, ArithmeticError):
    """Not one design of a study could be solved."""


def refuse_all_failed(found: Sequence[DesignOutcome]) -> None:
    """Raise `NoDesignError` with the reasons, if all designs failed."""
    if any(not each.failed for each in found):
        return
    reasons = Counter(each.reason for each in found).most_common(3)
    raise NoDesignError(
        f"not one of {len(found)} designs could be solved.\n"
        + "\n".join(f"{count} times: {reason}" for reason, count in reasons)
        + "\nMend the scene until `ffrf statics` or `ffrf simulate` solves it, or choose other designs."
    )


def failed_designs(found: Sequence[DesignOutcome], meaning: str, doubt: bool) -> Iterator[Caution]:
    """A caution that some designs could not be solved, with what that means and the most frequent reason."""
    reasons = Counter(each.reason for each in found if each.failed)
    if reasons:
        reason, count = reasons.most_common(1)[0]
        text = f"{sum(reasons.values())} of {len(found)} designs could not be solved{meaning} {count} of them: {reason}"
        yield Caution("failed-designs", text, doubt=doubt)


class Evaluator:
    """Solves designs of a problem, and keeps them.

    Every number follows from the design and from what the same search has solved before it, so that a search which was killed and goes on
    from its store gives the same bits.
    """

    def __init__(self, problem: Problem, store: DesignStore) -> None:
        self.problem = problem
        self.store = store

    def __call__(self, lane: int, design: np.ndarray, warm: bool) -> DesignOutcome:
        """The design, from the store or solved now; `warm` begins statics in the nearest design of the same lane."""
        known = self.store.find((lane, design.tobytes()))
        if known is not None:
            return known
        start = self._nearest(lane, design) if warm and self.problem.kind == "static" else None
        found = solve_design(self.problem, lane, design, start, curvatures=True)
        self.store.keep(found.key, found)
        return found

    def _nearest(self, lane: int, design: np.ndarray) -> DesignOutcome | None:
        """The nearest design of the lane that could be solved, the earlier of two."""
        known = [each for each in self.store.of(lane) if not each.failed]
        distances = [float(np.sum(((each.design - design) / self.problem.scales) ** 2)) for each in known]
        return known[int(np.argmin(distances))] if known else None


MOST_JUDGED_DESIGNS = 4
"""Most designs that are looked at: a judgement of a motion takes some more runs."""


def extremes(found: Iterable[DesignOutcome]) -> list[DesignOutcome]:
    """Designs of the least and the largest values of the responses, the first ones first; not more than are to be looked at."""
    good = [each for each in found if not each.failed]
    if not good:
        return []
    values = np.array([each.values for each in good]).reshape(len(good), -1)
    places = dict.fromkeys(int(k) for column in values.T for k in (np.argmin(column), np.argmax(column)))
    return [good[k] for k in list(places)[:MOST_JUDGED_DESIGNS]]


def cut_off(problem: Problem, found: DesignOutcome, place: tuple[int, int]) -> bool:
    """Whether a response of a design, by the places of case and response, is a load margin whose limit point was not reached."""
    up_to = problem.margin_up_to
    if found.failed or up_to is None or problem.responses[place[1]] != LOAD_MARGIN:
        return False
    return bool(found.values[place] >= up_to)


def margins_cut_off(problem: Problem, found: Sequence[DesignOutcome], statistics: bool, doubt: bool) -> Iterator[Caution]:
    """Load margins of which only the least value is known: right as such, but of no use for statistics."""
    if problem.margin_up_to is None:
        return
    places = [(k, problem.responses.index(LOAD_MARGIN)) for k in range(len(problem.cases))]
    count = sum(any(cut_off(problem, each, place) for place in places) for each in found)
    if count:
        then = "no mean, sigma or quantile follows" if statistics else "their rows hold this number, with gradients of zero"
        yield Caution(
            "margin-cut-off",
            f"in {count} of {len(found)} designs no limit point up to {problem.margin_up_to:g}: {LOAD_MARGIN} is at least that, and "
            f"{then}. It is looked for up to {MARGIN_SEARCH_FACTOR:g} times the limit under constraints.{LOAD_MARGIN}: a "
            "larger limit looks farther.",
            doubt=doubt,
        )


def said_at(problem: Problem, named: Mapping[str, DesignOutcome]) -> Iterator[Caution]:
    """Cautions of the runs at some designs in all cases: what several say is told of the first, with the name of its design."""
    told = set()
    for name, found in named.items():
        for case in problem.cases:
            where = f"{name}, {case}" if case else name
            try:
                warnings = direct(scene_at(problem, case, found.design), [], problem.kind).verdict.warnings
            except ToolkitError as error:
                warnings = (Caution("not-found-again", f"solved again along the path from the unloaded state: {error}"),)
            for each in warnings:
                if each.code not in told:
                    told.add(each.code)
                    yield Caution(each.code, f"{where}: {each.text}", each.doubt)
