"""A number of floating frames for every body whose scene says `frames = "auto"`.

The error of a body with n frames falls with the square of n. So runs with n_1 < n_2 frames, in which its nodes are at most d apart, leave

    d / ((n_2 / n_1)^2 - 1) / u

of its largest displacement u with n_2 frames, and as much more with n_1 as the square of their ratio. The first run has one frame, and
the meter of large deformation predicts the second number from it; each run predicts the next one until its own error is small enough.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from toolkit.bodies.cut.frame_choice import FrameChoice
from toolkit.bodies.planar.chosen_frames import ChosenFrames
from toolkit.bodies.planar.flexible import Flexible
from toolkit.foundation.errors import ConvergenceError, CriticalPointError, InputError, SingularSystemError
from toolkit.scene.cut_scene import most_frames
from toolkit.scene.scene import Scene
from toolkit.sensitivity.frames.places import largest_displacement, largest_distance, node_places
from toolkit.sensitivity.preparation import Kind, frozen, prepare, solve
from toolkit.system.solution import Solution
from toolkit.validity.bodies.deformation import deformations

Frames = int | tuple[int | str, ...]

WANTED = 1e-2
"""Geometric error by default."""
FIRST = 4
"""The second run has at most so many times the frames of the first: what that tells of large rotations is too pessimistic."""
STRAIGHT = 1e-9
"""Displacement in parts of the size below which a body does not deform, so that one frame is exact."""


@dataclass(frozen=True)
class _Run:
    """Places of the nodes of one body with a number of frames, and what they leave as far as it is known."""

    number: int
    places: np.ndarray
    displacement: float
    error: float = np.inf


def automatic(scene: Scene) -> list[str]:
    """Names of the bodies whose number of frames is to be chosen."""
    return [name for name, body in scene.bodies.items() if isinstance(body, Flexible) and body.frames == "auto"]


Choices = Mapping[str, tuple[int, FrameChoice]]


def with_chosen_frames(scene: Scene, kind: Kind) -> Scene:
    """The scene with the numbers of frames that an analysis of it needs, see `chosen_frames`; itself if none is to be chosen."""
    return with_choices(scene, chosen_frames(scene, kind))


def chosen_frames(scene: Scene, kind: Kind) -> Choices:
    """Body -> number of frames that an analysis of the scene needs; of those bodies alone whose number is to be chosen.

    Raises
    ------
    InputError
        A body cannot be cut, or no number reaches its error, because its elements are too large.
    ConvergenceError, SingularSystemError
        The scene cannot be solved with any number.
    """
    names = automatic(scene)
    if not names:
        return {}
    most = {name: most_frames(scene, name) for name in names}
    wanted = {name: _wanted(scene, name) for name in names}
    numbers, solution = _first_run(scene, kind, most)
    runs = {name: [_run_of(solution, name, numbers[name])] for name in names}
    fixed = frozen(scene, solution)
    following = {name: _second(solution, name, numbers[name], most[name], wanted[name]) for name in names}
    while following != numbers:
        numbers, before = following, numbers
        solution = solve(prepare(with_frames(fixed, numbers)), kind)
        for name in names:
            if numbers[name] != before[name]:
                runs[name].append(_judged(_run_of(solution, name, numbers[name]), runs[name][-1]))
        following = {name: _next(name, runs[name], most[name], wanted[name]) for name in names}
    for name in names:
        if len(runs[name]) == 1:  # one frame to every element already: nothing finer to compare with
            runs[name][0] = replace(runs[name][0], error=_metered(solution, name))
            _refuse_too_coarse(name, runs[name][0], most[name], wanted[name])
    return {name: _choice(runs[name], wanted[name], kind) for name in names}


def _wanted(scene: Scene, name: str) -> float:
    body = scene.bodies[name]
    assert isinstance(body, Flexible)
    return WANTED if body.geometric_error is None else body.geometric_error


def _first_run(scene: Scene, kind: Kind, most: dict[str, int]) -> tuple[dict[str, int], Solution]:
    """With one frame, or with the fewest powers of two that the scene can be solved with."""
    numbers = dict.fromkeys(most, 1)
    while True:
        try:
            return numbers, solve(prepare(with_frames(scene, numbers)), kind)
        except (ConvergenceError, SingularSystemError) as error:
            if isinstance(error, CriticalPointError) or numbers == most:
                raise
        numbers = {name: min(2 * number, most[name]) for name, number in numbers.items()}


def _second(solution: Solution, name: str, number: int, most: int, wanted: float) -> int:
    """By what the meter says of the first run; twice as many at least, so that the runs can be compared."""
    predicted = int(np.ceil(number * np.sqrt(_metered(solution, name) / wanted)))
    return min(max(2 * number, min(predicted, FIRST * number)), most)


def _metered(solution: Solution, name: str) -> float:
    """The error that the meter estimates, in parts of the displacement."""
    found = deformations(solution).get(name)
    return 0.0 if found is None else found.relative


def _run_of(solution: Solution, name: str, number: int) -> _Run:
    return _Run(number, node_places(solution, name), largest_displacement(solution, name))


def _judged(run: _Run, before: _Run) -> _Run:
    """The run with the error that it leaves, by how far it is from the one before."""
    size = np.ptp(run.places, axis=(0, 1)).max()
    if run.displacement <= STRAIGHT * size:
        return replace(run, error=0.0)
    apart = largest_distance(run.places, before.places) / run.displacement
    return replace(run, error=apart / ((run.number / before.number) ** 2 - 1))


def _next(name: str, runs: list[_Run], most: int, wanted: float) -> int:
    """The number to go on with; the last one again if that is good enough."""
    last = runs[-1]
    if len(runs) < 2 or last.error <= wanted:
        return last.number
    _refuse_too_coarse(name, last, most, wanted)
    predicted = int(np.ceil(last.number * np.sqrt(last.error / wanted)))
    return min(max(predicted, last.number + 1), most)


def _refuse_too_coarse(name: str, last: _Run, most: int, wanted: float) -> None:
    """Refuse an error that even one frame to every element does not reach."""
    if last.number == most and last.error > wanted:
        factor = np.sqrt(last.error / wanted)
        raise InputError(
            f"bodies.{name}: no number of frames reaches a geometric error of {wanted:g}. One to every element, {most} in all, leaves "
            f"about {last.error:.2g} of the largest displacement, because the elements themselves turn too far. Build the model with "
            f"some {int(np.ceil(most * factor))} elements, or write a larger geometric_error."
        )


def _choice(runs: list[_Run], wanted: float, kind: Kind) -> tuple[int, FrameChoice]:
    """The first number that is good enough: that of the first run, if the second one says so."""
    numbers = tuple(run.number for run in runs)
    last, error = runs[-1], runs[-1].error
    if len(runs) == 2 and (first := runs[0]).number < last.number:
        of_first = error * (last.number / first.number) ** 2
        if of_first <= wanted:
            return first.number, FrameChoice(wanted, of_first, numbers, kind)
    return last.number, FrameChoice(wanted, error, numbers, kind)


def with_choices(scene: Scene, choices: Choices) -> Scene:
    """The scene with numbers of frames that were chosen."""
    if not choices:
        return scene
    plain = with_frames(scene, {name: number for name, (number, _) in choices.items()}).bodies
    chosen = {
        name: ChosenFrames.model_construct(**{**dict(plain[name]), **plain[name].model_values()}, choice=choice)  # type: ignore[attr-defined]
        for name, (_, choice) in choices.items()
    }
    return scene.model_copy(update={"bodies": {**plain, **chosen}})


def with_frames(scene: Scene, frames: Mapping[str, Frames]) -> Scene:
    """The scene with other frames in some of its bodies."""
    changed = {name: scene.bodies[name].model_copy(update={"frames": n, "geometric_error": None}) for name, n in frames.items()}
    return scene.model_copy(update={"bodies": {**scene.bodies, **changed}})
