"""A sweep: its designs, all solved, kept and judged, and its result as tables."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from toolkit.foundation.errors import InputError, listed
from toolkit.foundation.verdict import Verdict
from toolkit.scene.scene import Scene
from toolkit.studies.design_work import (
    WITH_GRADIENTS,
    WITHOUT_GRADIENTS,
    DesignJob,
    DesignWork,
    extremes,
    failed_designs,
    margins_cut_off,
    refuse_all_failed,
    said_at,
    solve_designs,
)
from toolkit.studies.executor import SERIAL, Executor, Progress
from toolkit.studies.orthonormal_basis import scrambled
from toolkit.studies.problem import Problem, problem_of_all
from toolkit.studies.store import DesignOutcome, opened_store
from toolkit.studies.study_file import Study

DEFAULT_LEVELS, DEFAULT_COUNT, DEFAULT_SEED = 5, 64, 0
"""What a study that does not say it takes."""
MOST_DESIGNS = 1_000_000
"""Most designs of a sweep."""


def points_of(problem: Problem) -> np.ndarray:
    """All designs, (count, n).

    Raises
    ------
    InputError
        There are too many; a level belongs to no variable; or the file is invalid.
    """
    options, (low, high) = problem.study.sweep, problem.bounds
    if options.file is not None:
        return read_points(problem.study.directory / options.file, problem)
    if options.kind == "grid":
        return _grid(problem, options.levels)
    count, seed = options.count or DEFAULT_COUNT, options.seed or DEFAULT_SEED
    _refuse_too_many(count)
    random = np.random.default_rng(seed)
    from scipy.stats.qmc import LatinHypercube

    found = (
        LatinHypercube(len(low), rng=random).random(count)
        if options.kind == "latin-hypercube"
        else scrambled(count, len(low), seed)
    )
    return low + found * (high - low)


def _grid(problem: Problem, levels: int | dict[str, int] | None) -> np.ndarray:
    given = levels if isinstance(levels, dict) else dict.fromkeys(problem.variables, levels or DEFAULT_LEVELS)
    if unknown := [name for name in given if name not in problem.variables]:
        raise InputError(f"sweep.levels: {unknown[0]!r} is no variable of the study; it has {listed(problem.variables)}.")
    counts = [given.get(name, DEFAULT_LEVELS) for name in problem.variables]
    _refuse_too_many(math.prod(counts), ' Give fewer levels, or points = "sobol" with a count.')
    axes = [np.linspace(a, b, n) if n > 1 else np.array([(a + b) / 2]) for a, b, n in zip(*problem.bounds, counts, strict=True)]
    return np.array(list(product(*axes)))


def _refuse_too_many(count: int, remedy: str = " Give a smaller count.") -> None:
    if count > MOST_DESIGNS:
        raise InputError(f"sweep: {count} designs are more than {MOST_DESIGNS}.{remedy}")


def read_points(path: Path, problem: Problem) -> np.ndarray:
    """Designs of a CSV file, whose first line names the variables.

    Raises
    ------
    InputError
        The file cannot be read, its columns are not the variables, or a cell is no number within its variable's bounds.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = [(k, row) for k, row in enumerate(csv.reader(file), 1) if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"the designs {str(path)!r} cannot be read ({getattr(error, 'strerror', None) or error}).") from error
    header = [cell.strip() for cell in rows[0][1]] if rows else []
    if sorted(header) != sorted(problem.variables):
        raise InputError(
            f"the first line of {str(path)!r} names {listed(header) if header else 'nothing'}; it has to name each variable of the study "
            f"once, separated by commas: {', '.join(problem.variables)}."
        )
    if len(rows) == 1:
        raise InputError(f"{str(path)!r} holds no designs below its first line. Write one in every line.")
    _refuse_too_many(len(rows) - 1)
    order = [header.index(name) for name in problem.variables]
    return np.array([_row(path, line, row, order, problem) for line, row in rows[1:]])


def _row(path: Path, line: int, row: Sequence[str], order: Sequence[int], problem: Problem) -> list[float]:
    where = f"{path.name}, line {line}"
    if len(row) != len(order):
        raise InputError(f"{where}: {len(row)} cells, where the first line has {len(order)}.")
    found = []
    for name, k, low, high in zip(problem.variables, order, *problem.bounds, strict=True):
        try:
            value = float(row[k])
        except ValueError:
            raise InputError(f"{where}: {name} = {row[k]!r} is no number.") from None
        if not low <= value <= high:
            raise InputError(
                f"{where}: {name} = {value:g} is not between {low:g} and {high:g}. Widen its bounds, or leave the design out."
            )
        found.append(value)
    return found


Cell = int | float | str
NUMBER, FAILURE = "design", "failure"
"""Columns of the table beside those of variables and responses: the number of the design, and why it failed."""


def derivative(label: str, variable: str) -> str:
    """Name of the column of a derivative."""
    return f"d({label})/d({variable})"


def refuse_equal_columns(problem: Problem) -> None:
    """Refuse names of which two would be the same column of the table.

    Raises
    ------
    InputError
        A variable or a response is called like another column.
    """
    labels = {label: problem.responses[j] for label, (_, j) in problem.labels.items()}
    taken = {NUMBER: "the number of the design", FAILURE: "why a design failed"}
    taken |= {label: f"the response {name!r}" for label, name in labels.items() if label not in taken}
    taken |= {derivative(label, name): "a derivative" for label in labels for name in problem.variables}
    for name in problem.variables:
        if name in taken:
            raise InputError(
                f"variables.{name}: {name!r} is the column of a sweep's table that holds {taken[name]}. Give the variable another name."
            )
    for label, name in labels.items():
        if label in (NUMBER, FAILURE):
            raise InputError(
                f"responses.{name}: {name!r} is the column of a sweep's table that holds {taken[label]}. Give the response another name, "
                "or leave it out of sweep.responses."
            )


@dataclass(frozen=True)
class Swept:
    """Values and gradients of a study at many designs.

    Attributes
    ----------
    problem
        The study with its scene.
    designs
        Values of the variables, (designs, n).
    solved
        What came of each design, in their order; equal designs were solved once.
    verdict
        Whether the numbers can be trusted, by the runs at designs of extreme values.
    wall
        Time that the designs took, also before an interruption, in s.
    """

    problem: Problem
    designs: np.ndarray
    solved: tuple[DesignOutcome, ...]
    verdict: Verdict
    wall: float

    @property
    def responses(self) -> dict[str, tuple[int, int]]:
        """Response, with its case before it where cases have names -> index of case and response in the values of a design."""
        return self.problem.labels

    @property
    def units(self) -> dict[str, str]:
        """Response, with its case -> label of its unit."""
        return {label: self.problem.unit_of(self.problem.responses[j]) for label, (_, j) in self.responses.items()}

    @property
    def failed(self) -> int:
        """Number of designs that could not be solved."""
        return sum(each.failed for each in self.solved)

    def values(self, response: str) -> np.ndarray:
        """Values of a response at all designs, (designs,); nan where they failed."""
        place = self.responses[response]
        return np.array([math.nan if each.failed else each.values[place] for each in self.solved])

    def gradients(self, response: str) -> np.ndarray:
        """Derivatives of a response by the variables, (designs, n); nan where designs failed."""
        none = np.full(len(self.problem.variables), math.nan)
        place = self.responses[response]
        return np.array([none if each.failed else each.gradients[place] for each in self.solved])

    @property
    def columns(self) -> dict[str, list[Any]]:
        """Columns of the table: number of the design, variables, why it failed, responses and derivatives."""
        table: dict[str, list[Any]] = {NUMBER: list(range(1, len(self.designs) + 1))}
        table |= {name: self.designs[:, k].tolist() for k, name in enumerate(self.problem.variables)}
        table[FAILURE] = [each.reason for each in self.solved]
        table |= {label: self.values(label).tolist() for label in self.responses}
        if self.problem.study.sweep.gradients:
            for label in self.responses:
                slopes = self.gradients(label)
                table |= {derivative(label, name): slopes[:, k].tolist() for k, name in enumerate(self.problem.variables)}
        return table

    @property
    def said(self) -> str:
        """A sentence with the number of designs, failures and the time."""
        return f"{len(self.designs)} designs, {self.failed} of which could not be solved, in {self.wall:.1f} s."

    def record(self) -> dict[str, Any]:
        """A JSON object with the designs at which responses are least and largest; the table is in the CSV file."""
        low, high = self.problem.bounds
        return {
            "sweep": {
                "points": self.problem.study.sweep.kind,
                "variables": {
                    name: {"least": float(low[k]), "largest": float(high[k])} for k, name in enumerate(self.problem.variables)
                },
                "responses": {
                    label: {
                        "least": self._extreme(label, np.nanargmin),
                        "largest": self._extreme(label, np.nanargmax),
                        "unit": unit,
                    }
                    for label, unit in self.units.items()
                },
            },
            "failures": [
                {"design": k + 1, "variables": self._named(k), "reason": each.reason}
                for k, each in enumerate(self.solved)
                if each.failed
            ],
            "evaluations": len(self.designs),
            "failed": self.failed,
            "wall_s": self.wall,
            **self.verdict.record(),
        }

    def _extreme(self, label: str, where: Callable[[np.ndarray], np.intp]) -> dict[str, Any]:
        values = self.values(label)
        k = int(where(values))
        return {"value": float(values[k]), "design": k + 1, "at": self._named(k)}

    def _named(self, k: int) -> dict[str, float]:
        return dict(zip(self.problem.variables, map(float, self.designs[k]), strict=True))


STORE = "sweep.h5"
"""Name of the store in the folder of a sweep."""


def sweep_problem(study: Study, scene: Scene | None = None) -> Problem:
    """A study whose designs are to be swept, checked; raises `InputError` as `problem_of_all`, and of names that are columns already."""
    problem = problem_of_all(study, scene, study.sweep.responses, "sweep.responses")
    refuse_equal_columns(problem)
    return problem


def run_sweep(
    problem: Problem, folder: Path | None = None, executor: Executor = SERIAL, progress: Progress | None = None
) -> Swept:
    """Solve all designs of a sweep.

    Parameters
    ----------
    problem
        The checked study.
    folder
        Where all designs are kept, and found again after an interruption; None keeps nothing.
    executor
        Where they are solved.
    progress
        Called with the designs solved and the designs in all.

    Raises
    ------
    InputError
        The designs are invalid; or the folder holds another study, or another run works in it.
    NoDesignError
        Not one design could be solved.
    StudyError
        A process or the cluster ended; what was finished is kept.
    """
    designs, wanted = points_of(problem), problem.study.sweep.gradients
    asked = [DesignJob(WITH_GRADIENTS if wanted else WITHOUT_GRADIENTS, each, wanted) for each in designs]
    with opened_store(None if folder is None else folder / STORE, problem.fingerprint) as store:
        found = solve_designs(DesignWork(problem), asked, store, executor, progress)
    refuse_all_failed(found)
    numbers = {id(each): k + 1 for k, each in reversed(list(enumerate(found)))}
    named = {f"design {numbers[id(each)]}": each for each in extremes(found)}
    margins = margins_cut_off(problem, found, statistics=False, doubt=False)
    cautions = [*failed_designs(found, "; their rows say why.", doubt=False), *margins, *said_at(problem, named)]
    return Swept(
        problem, designs, tuple(found), Verdict.of(cautions), sum(each.seconds for each in {id(e): e for e in found}.values())
    )
