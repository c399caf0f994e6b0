"""Indicators of how far two designs are apart: their numbers, their answers, and the sizes of their states and joint forces.

All of it is at hand after a run, while to judge a run costs several more. What a check measures is a smooth function of these numbers, of
a power that is seldom above the fourth: the growth of an element that turns goes with the second power of a deflection.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from toolkit.foundation.errors import ToolkitError
from toolkit.responses.over_time.missed_peaks import peaks
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.sensitivity.errors.step_error import LENIENT
from toolkit.sensitivity.run import UNIMPORTANT, Run
from toolkit.sensitivity.sizes import response_scales, typical_size, variable_sizes
from toolkit.system.flexible_bodies import deforming, elastic_coordinates
from toolkit.system.solution import Solution

OF_A_SCENE = 0.1
"""Part of the model size that changes of positions are compared with, where these are nearer to the origin."""
BETWEEN = 0.05
"""Error of the vertices of parabolas, as a part of a step."""
DIGITS = 9
"""Decimal digits that distances are rounded to, so that round-off does not decide which of two equal ones is larger."""
NOTHING = 1e-6
"""Part of the largest velocity, or joint force, of a scene below which another one is taken for zero."""


class Indicators(NamedTuple):
    """Numbers of one design and of its run, by which designs are compared.

    Attributes
    ----------
    numbers
        What changes from one design to the next, (n,).
    least
        What a change is compared with where the number itself is smaller than this, (n,).
    kind
        What has to be the same in designs that are near each other: the number of steps, whether all of them went well, and at which ones
        there are peaks.
    """

    numbers: np.ndarray
    least: np.ndarray
    kind: tuple[object, ...] = ()


def distances(one: Indicators, numbers: np.ndarray, least: np.ndarray) -> np.ndarray:
    """Distances of a design from others, (n_d,): the largest change of a number, as a part of the larger one of both.

    Parameters
    ----------
    one
        The design.
    numbers, least
        As of `Indicators`, of n_d others, (n_d, n).
    """
    scale = np.maximum(np.maximum(abs(numbers), abs(one.numbers)), np.maximum(least, one.least))
    change = abs(numbers - one.numbers)
    parts = np.divide(change, scale, out=np.zeros_like(change), where=change != 0)
    found = np.nan_to_num(parts, nan=np.inf).max(axis=1, initial=0.0)  # what does not exist is near nothing
    return np.round(found, DIGITS)


def written_numbers(scene: Scene, designs: Sequence[Mapping[str, float]]) -> list[Indicators]:
    """Numbers that designs are written as: all that any of them gives; where one gives none, the scene's own."""
    names = [name for name in dict.fromkeys(name for each in designs for name in each) if _is_known(scene, name)]
    own = {name: scene.value_of(name) for name in names}
    size = loaded(scene).size
    least = np.array([OF_A_SCENE * size if scene.paths_of(name)[0].startswith("points.") else 0.0 for name in names])
    return [Indicators(np.array([_real(each.get(name, own[name])) for name in names]), least) for each in designs]


def _is_known(scene: Scene, name: Any) -> bool:
    """Whether a name leads to a finite number of the scene; a design that gives another one fails."""
    try:
        return isinstance(name, str) and np.isfinite(scene.value_of(name))
    except ToolkitError:
        return False


def _real(number: Any) -> float:
    """A number of a design as a float; nan if it is none, with which the design fails."""
    try:
        return float(number)
    except (TypeError, ValueError, OverflowError):
        return np.nan


def joined(parts: Sequence[Indicators]) -> Indicators:
    """Several indicators of one design, joined to one."""
    numbers, least = (np.concatenate(each) for each in zip(*(part[:2] for part in parts), strict=True))
    return Indicators(numbers, least, tuple(word for part in parts for word in part.kind))


def indicators(result: Run) -> Indicators:
    """Indicators of a run: its answers, the sizes of its states, and what must be equal in designs near to it."""
    solution = result.solution
    found = joined([_of_answers(result), *_of_states(solution)])
    options = solution.options or solution.system.scene.solver
    went_well = solution.correction <= options.tolerance, not solution.halved
    kind = len(found.numbers), solution.steps, result.method, *went_well
    return found._replace(kind=(*kind, *_peaks(solution)) if result.gradients else kind)


def _peaks(solution: Solution) -> Iterator[float]:
    """Steps at which peaks over time are, and on which side of them by more than a quarter of a step.

    The derivative of a peak is that at its step. Of steps half as long another one is nearer from a quarter of a step on, so that what
    they tell of derivatives jumps there; a peak that lies close to that is like no other one.
    """
    if solution.run_times is None and solution.steps:
        for step, later in peaks(solution):
            yield step
            yield later if abs(abs(later) - 0.25) < BETWEEN else np.sign(later) * (abs(later) > 0.25)


def sizes_of_variables(result: Run) -> dict[str, float]:
    """Sizes of the variables as by `variable_sizes`, without looking at the answers where that is not needed."""
    scene, variables = result.solution.system.scene, list(result.solution.system.design)
    if variables and all(each.value != 0 or each.path.startswith("points.") for each in variables):
        return {each.name: typical_size(scene, each) for each in variables}
    return variable_sizes(scene, result)


def _of_answers(result: Run) -> Indicators:
    """Indicators of the responses: their values, and their gradients relative to the largest of each."""
    values = np.array(list(result.values.values()), dtype=float)
    if not result.gradients:
        return Indicators(values, np.zeros(len(values)))
    sizes = sizes_of_variables(result)
    scales = response_scales(result, sizes)
    slopes = np.array([[result.gradients[f][x] * size for x, size in sizes.items()] for f in result.values])
    most = LENIENT * abs(slopes).max(axis=1, initial=0.0, keepdims=True)
    least = np.array([UNIMPORTANT * scales[f] for f in result.values])
    return Indicators(np.append(values, slopes), np.append(least, np.broadcast_to(most, slopes.shape)))


def _of_states(solution: Solution) -> list[Indicators]:
    """Indicators of the states: largest and mean deformations, velocities, accelerations, joint forces, and the step's error."""
    system = solution.system
    starts = sorted({*system.numbering.first.values(), system.n_q})
    bodies = [slice(*each) for each in pairwise(starts)]
    rows = sorted({*(row - system.n_q for row in system.numbering.row.values()), solution.multipliers.shape[1]})
    joints = [slice(*each) for each in pairwise(rows)]
    bent = [elastic_coordinates(solution, body) for body in deforming(system.scene)]
    error = np.full((1, 1), solution.local_error or 0.0)
    of_time = (solution.q, bent), (solution.v, bodies), (solution.a, bodies), (solution.multipliers, joints), (error, [slice(1)])
    return [_sizes_over_time(np.real(states) ** 2, places) for states, places in of_time]


def _sizes_over_time(squares: np.ndarray, places: Sequence[slice | np.ndarray]) -> Indicators:
    """Largest and mean norm over time of some columns of states, from the squares of these, (n_t, n)."""
    over_time = np.array([[each.max(initial=0.0), each.mean()] for each in (squares[:, where].sum(axis=1) for where in places)])
    found = np.sqrt(over_time).ravel()
    return Indicators(found, np.full(len(found), NOTHING * found.max(initial=0.0)))
