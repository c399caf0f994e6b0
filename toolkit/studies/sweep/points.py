"""The designs of a sweep: a grid, scattered points, or the rows of a table."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.listed_names import listed
from toolkit.studies.distributions.sobol_points import scrambled
from toolkit.studies.study.problem import Problem

LEVELS, COUNT, SEED = 5, 64, 0
"""What a study that does not say it takes."""
MOST = 1_000_000
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
    count, seed = options.count or COUNT, options.seed or SEED
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
    given = levels if isinstance(levels, dict) else dict.fromkeys(problem.variables, levels or LEVELS)
    if unknown := [name for name in given if name not in problem.variables]:
        raise InputError(f"sweep.levels: {unknown[0]!r} is no variable of the study; it has {listed(problem.variables)}.")
    counts = [given.get(name, LEVELS) for name in problem.variables]
    _refuse_too_many(math.prod(counts), ' Give fewer levels, or points = "sobol" with a count.')
    axes = [np.linspace(a, b, n) if n > 1 else np.array([(a + b) / 2]) for a, b, n in zip(*problem.bounds, counts, strict=True)]
    return np.array(list(product(*axes)))


def _refuse_too_many(count: int, remedy: str = " Give a smaller count.") -> None:
    if count > MOST:
        raise InputError(f"sweep: {count} designs are more than {MOST}.{remedy}")


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
