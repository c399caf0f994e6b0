"""The work of solving one design of a study, which is sent once to where designs are solved."""

from __future__ import annotations

import atexit
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import Any

import numpy as np

from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.files.replaced_file import write_whole
from toolkit.scene.scene import Scene
from toolkit.studies.designs.solved_design import solve_design
from toolkit.studies.engine.outcome import DesignKey, DesignOutcome
from toolkit.studies.study.problem import Problem

WITH, WITHOUT = 0, 1
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

    def __reduce__(self) -> tuple[Any, ...]:
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

    def __reduce__(self) -> tuple[Any, ...]:
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
