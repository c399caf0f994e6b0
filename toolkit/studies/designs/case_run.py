"""The scene of a study solved in one case: what objective and limits ask of it, at any design and point of uncertain numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toolkit.analyses.modes import solve_modes
from toolkit.analyses.statics import solve_statics
from toolkit.foundation.errors import InputError, ToolkitError
from toolkit.responses.vibrations.pencil import pencil_of
from toolkit.responses.vibrations.vibration import Frequency
from toolkit.sensitivity.direct import evaluated, values_alone
from toolkit.sensitivity.methods import by_method
from toolkit.studies.engine.outcome import State
from toolkit.studies.study.problem import Problem
from toolkit.system.solution import Solution
from toolkit.system.system import System

ALIKE = 0.5
"""Assurance above which a mode is the one."""
AGREE = 1e-6
"""Relative difference of a frequency by the two ways in which it is found."""


class LostModeError(ToolkitError, ArithmeticError):
    """No mode of a design is the one that is followed."""


def shapes_of(solution: Solution, count: int) -> np.ndarray:
    """The slowest modes of the scene as it stands, (n_q, count).

    Raises
    ------
    InputError
        There are not so many.
    """
    found = solve_modes(solution)
    if len(found.frequencies) < count:
        raise InputError(f"frequency_{count}: the scene has {len(found.frequencies)} modes. Ask for one of these.")
    return found.shapes[:, :count]


def followed(solution: Solution, shapes: np.ndarray, number: int) -> Frequency:
    """The frequency of the mode of an equilibrium that is most like that of a number among the shapes.

    Raises
    ------
    LostModeError
        None of them is like it any more.
    """
    mass = np.real(pencil_of(solution).mass[: solution.system.n_q, : solution.system.n_q])
    modes, reference = solve_modes(solution), shapes[:, number - 1]
    squares = np.real(np.einsum("ik,ij,jk->k", modes.shapes.conj(), mass, modes.shapes))  # complex are those that flutter
    alike = np.abs(reference.conj() @ mass @ modes.shapes) ** 2 / (squares * np.real(reference.conj() @ mass @ reference))
    k = int(np.argmax(alike))
    remedy = f'ask for frequencies by their order, with a response {{ type = "frequency", number = {number} }}'
    if alike[k] <= ALIKE:
        raise LostModeError(
            f"frequency_{number}: no mode is like the one that has this number where the scene stands. Number {k + 1} is most like it, "
            f"with an assurance of {alike[k]:.2g}, and more than {ALIKE:g} is wanted. Narrow the bounds, or {remedy}."
        )
    found, value = Frequency(number=k + 1), float(modes.frequencies[k])
    if abs(float(np.real(found.value(solution))) - value) > AGREE * abs(value):
        raise LostModeError(
            f"frequency_{number}: modes without stiffness cannot be told from others. Hold what moves freely, or {remedy}."
        )
    return found


class CaseResult(NamedTuple):
    """Values (asked,) and gradients (asked, n) of a case, nan if these were not wanted; the solution; and second derivatives of what the
    problem calls `squares`, (squares, n, n), none if they were not wanted."""

    values: np.ndarray
    gradients: np.ndarray
    solution: Solution
    curvatures: np.ndarray


@dataclass(frozen=True)
class CaseRun:
    """Runs of one case.

    Attributes
    ----------
    problem
        The checked study.
    case
        Name of the case.
    start
        The equilibrium that statics begins in; None begins in the unloaded state.
    gradients
        Whether they are wanted.
    curvatures
        Whether second derivatives of mean squares are wanted too.
    """

    problem: Problem
    case: str
    start: State | None
    gradients: bool
    curvatures: bool = False

    def at(self, design: np.ndarray, point: int = 0) -> CaseResult:
        """What the problem asks for, at a design (n,) and a point of the uncertain numbers: the first is that of all means."""
        problem, points = self.problem, self.problem.points
        own = points.at(point) if points else {}
        there = design + points.shifts[point] if points else design
        compiled = problem.compiled.at({**problem.cases[self.case], **own, **problem.numbers(there)})
        if problem.kind == "transient":
            method = problem.study.search.gradients
            result = (
                by_method(method, compiled, "transient", None, False) if self.gradients else values_alone(compiled, "transient")
            )
        else:
            known = None if self.start is None else resting(compiled.primal.scene.solver.end_time, compiled.full, self.start)
            result = evaluated(solve_statics(compiled.full if self.gradients else compiled.primal, start=known), self.gradients)
        values, none = dict(result.values), np.full(len(design), math.nan)
        rows = {name: np.array([each[x] for x in problem.variables]) for name, each in result.gradients.items()}
        for name, each in frequencies(problem, self.case, result.solution).items():
            values[name], rows[name] = each.evaluate(result.solution)
        slopes = [rows[name] if self.gradients else none for name in problem.asked]
        curved = [each.curvature(result.solution) for each in problem.squares.values()] if self.curvatures else []
        return CaseResult(np.array([values[name] for name in problem.asked]), np.array(slopes), result.solution, np.array(curved))


def frequencies(problem: Problem, case: str, solution: Solution) -> dict[str, Frequency]:
    """Frequencies of an equilibrium that are followed by the shapes of their modes."""
    if problem.modes and case not in problem.shapes:
        here = solve_statics(problem.compiled.at(problem.cases[case]).primal)
        problem.shapes[case] = shapes_of(here, max(problem.modes.values()))
    return {name: followed(solution, problem.shapes[case], number) for name, number in problem.modes.items()}


def resting(time_of: float, system: System, state: State) -> Solution:
    """A kept equilibrium, as statics takes it for a start."""
    q, lam = state.q[None], state.multipliers[None]
    empty = np.zeros((1, len(state.q), 0))
    none = np.zeros_like(q)
    return Solution(
        system, np.array([time_of]), q, none, none, lam, empty, empty, empty, np.zeros((1, len(state.multipliers), 0))
    )
