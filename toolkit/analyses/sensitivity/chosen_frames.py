"""A number of floating frames for every body whose scene says `frames = "auto"`.

The error of a body with n frames falls with the square of n. So runs with n_1 < n_2 frames, in which its nodes are at most d apart (those
of a moving body when both shapes are put together best: where it is depends on others), leave

    d / ((n_2 / n_1)^2 - 1) / u

of its largest displacement u with n_2 frames, and as much more with n_1 as the square of their ratio. The first run has one frame, and
the meter of large deformation predicts the second number from it; each run predicts the next one until its own error is small enough.
Where few frames are too few for the square, and tension that stiffens the body needs many, runs can lie close together and be far off:
so the last number is believed where the meter, which is too large rather than too small, finds no more either, or after a run with twice
as many.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from toolkit.analyses.sensitivity.preparation import Kind, frozen, prepare, solve
from toolkit.components.bodies.cuttable_body import ChosenFrames, CuttableBody
from toolkit.description.end_state import end_state
from toolkit.description.run_options import time_grid
from toolkit.foundation.errors import ConvergenceError, CriticalPointError, InputError, SingularSystemError
from toolkit.scene.resolution import branches, fewest_cut, loaded, most_frames
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution, elements_of
from toolkit.validity.bodies.bent_surfaces import geometric_errors
from toolkit.validity.bodies.deformation import has_places, is_moving, largest_displacement, node_places, relative_distance

Frames = int | tuple[int | str, ...]

WANTED_ERROR = 1e-2
"""Default limit of the geometric error."""
LARGEST_FRAME_RATIO = 4
"""Largest ratio of the frames of the second run to those of the first, whose estimate for large rotations is too pessimistic."""
COMPARED_FRAME_RATIO = 2
"""Ratio of numbers of frames from which on a run tells the geometric error of the run before."""


@dataclass(frozen=True)
class _FramedRun:
    """Node positions of one body with a number of frames, and the geometric error that they leave, as far as it is known."""

    number: int
    places: np.ndarray
    displacement: float
    moving: bool
    metered: float  # what the meter finds
    error: float = np.inf


@dataclass(frozen=True)
class _Range:
    """Numbers of frames that a body can have: the first one, and those from `least` to `most`."""

    first: int
    least: int
    most: int
    branches: bool
    elements: str  # what the body calls them

    def near(self, number: int) -> int:
        """Number of several frames in the range that is nearest to a number."""
        return min(max(number, self.least), self.most)


def automatic(scene: Scene) -> list[str]:
    """Names of the bodies whose number of frames is to be chosen."""
    return [name for name, body in scene.bodies.items() if isinstance(body, CuttableBody) and body.frames == "auto"]


Choices = Mapping[str, tuple[int, ChosenFrames]]


def with_chosen_frames(scene: Scene, kind: Kind) -> Scene:
    """The scene with the numbers of frames that an analysis needs, see `chosen_frames`; unchanged if none is to be chosen."""
    return with_choices(scene, chosen_frames(scene, kind))


def chosen_frames(scene: Scene, kind: Kind) -> Choices:
    """Body -> number of frames that an analysis of the scene needs, for the bodies whose number is to be chosen.

    Raises
    ------
    InputError
        A body cannot be cut, or no number reaches its error, because its elements are too large.
    ConvergenceError, SingularSystemError
        The scene cannot be solved with any number.
    """
    kept = _of_kept_run(scene, kind)
    scene = with_choices(scene, kept)
    names = automatic(scene)
    if not names:
        return kept
    ranges = {name: _range_of(scene, name) for name in names}
    wanted = {name: _wanted(scene, name) for name in names}
    numbers, solution = _first_run(scene, kind, ranges)
    runs = {name: [_run_of(solution, name, numbers[name])] for name in names}
    fixed = scene if solution.halved else frozen(scene, solution)
    following = {name: _second(solution, name, numbers[name], ranges[name], wanted[name]) for name in names}
    while following != numbers:
        numbers, before = following, numbers
        found = _tried(fixed, kind, numbers)
        if found is None:
            chosen = {name: _choice(runs[name], wanted[name], kind) for name in names}
            return {**kept, **{name: _unfinished(chosen[name], numbers[name], before[name]) for name in names}}
        solution = found
        for name in names:
            if numbers[name] != before[name]:
                runs[name].append(_judged(_run_of(solution, name, numbers[name]), runs[name][-1]))
        following = {name: _next(name, runs[name], ranges[name], wanted[name]) for name in names}
    for name in names:
        if len(runs[name]) == 1:  # one frame to every element already: nothing finer to compare with
            runs[name][0] = replace(runs[name][0], error=_metered(solution, name, unknown=0.0))
            _refuse_too_coarse(name, runs[name][0], ranges[name], wanted[name])
    return {**kept, **{name: _choice(runs[name], wanted[name], kind) for name in names}}


def _of_kept_run(scene: Scene, kind: Kind) -> Choices:
    """Numbers of frames of the run whose last state a motion starts in: its coordinates belong to these numbers."""
    if scene.start_file is None or kind == "static":
        return {}
    end = end_state(scene.start_file)
    found = {name: end.bodies.get(name, {}).get("frames", 1) for name in automatic(scene)}
    return {
        name: (number, ChosenFrames(_wanted(scene, name), np.nan, (), kind, kept_run=end.path.name))
        for name, number in found.items()
        if isinstance(number, int)
    }


def _wanted(scene: Scene, name: str) -> float:
    body = scene.bodies[name]
    assert isinstance(body, CuttableBody)
    return WANTED_ERROR if body.geometric_error is None else body.geometric_error


def _range_of(scene: Scene, name: str) -> _Range:
    """Range of the numbers of frames of a body.

    One frame comes first, unless nobody knows where the nodes are with it.
    """
    least, most = fewest_cut(scene, name), most_frames(scene, name)
    return _Range(
        1 if has_places(scene, name) else min(least, most), least, most, branches(scene, name), elements_of(loaded(scene), name)
    )


def _first_run(scene: Scene, kind: Kind, ranges: dict[str, _Range]) -> tuple[dict[str, int], Solution]:
    """A run with the first numbers of frames, or with the fewest powers of two that the scene can be solved with."""
    numbers = {name: each.first for name, each in ranges.items()}
    while True:
        try:
            return numbers, solve(prepare(with_frames(scene, numbers)), kind)
        except (ConvergenceError, SingularSystemError) as error:
            if isinstance(error, CriticalPointError) or numbers == {name: each.most for name, each in ranges.items()}:
                raise
        numbers = {name: ranges[name].near(2 * number) for name, number in numbers.items()}


def _tried(scene: Scene, kind: Kind, numbers: dict[str, int]) -> Solution | None:
    """A run with numbers of frames; None if it fails, which tells nothing about those that do not."""
    try:
        return solve(prepare(with_frames(scene, numbers)), kind)
    except (ConvergenceError, SingularSystemError) as error:
        if isinstance(error, CriticalPointError):
            raise
        return None


def _second(solution: Solution, name: str, number: int, can_be: _Range, wanted: float) -> int:
    """Number of frames of the second run, as the meter of large deformation predicts from the first.

    It is twice as large at least, so that the runs can be compared.
    """
    predicted = int(np.ceil(number * np.sqrt(_metered(solution, name, unknown=0.0) / wanted)))
    return can_be.near(max(COMPARED_FRAME_RATIO * number, min(predicted, LARGEST_FRAME_RATIO * number)))


def _metered(solution: Solution, name: str, unknown: float) -> float:
    """Geometric error that the meter of large deformation estimates, relative to the largest displacement."""
    found = geometric_errors(solution).get(name)
    return unknown if found is None else found.relative


def _run_of(solution: Solution, name: str, number: int) -> _FramedRun:
    places, displacement = _at_times_asked_for(solution, node_places(solution, name)), largest_displacement(solution, name)
    return _FramedRun(
        number, places, displacement, is_moving(solution.system.scene, name), _metered(solution, name, unknown=np.inf)
    )


def _at_times_asked_for(solution: Solution, places: np.ndarray) -> np.ndarray:
    """Node positions (n_t, ...) at the times that all runs have, whichever of their steps were halved."""
    if not solution.halved:
        return places
    return places[np.isin(solution.times, time_grid(solution.options or solution.system.scene.solver))]


def _judged(run: _FramedRun, before: _FramedRun) -> _FramedRun:
    """The run with the geometric error that it leaves, from its distance to the run before."""
    apart = relative_distance(run.places, before.places, run.displacement, run.moving)
    return replace(run, error=apart / ((run.number / before.number) ** 2 - 1))


def _next(name: str, runs: list[_FramedRun], can_be: _Range, wanted: float) -> int:
    """Number of frames to go on with; the last one again if it, or the one before, is good enough.

    Of a body that branches every member needs more, so that the number is twice as large at least.
    """
    last = runs[-1]
    if len(runs) < 2 or _suffices(runs, wanted):
        return last.number
    if last.error <= wanted:
        believed = last.metered <= wanted or last.number == can_be.most
        return last.number if believed else can_be.near(COMPARED_FRAME_RATIO * last.number + 1)
    _refuse_too_coarse(name, last, can_be, wanted)
    predicted = int(np.ceil(last.number * np.sqrt(last.error / wanted)))
    return can_be.near(max(predicted, COMPARED_FRAME_RATIO * last.number if can_be.branches else last.number + 1))


def _suffices(runs: list[_FramedRun], wanted: float) -> bool:
    """Whether the last run says that the number of the one before is good enough."""
    before, last = runs[-2:]
    apart = before.number == 1 or last.number % before.number > 0  # else, by symmetry, both can be off alike
    return last.number >= COMPARED_FRAME_RATIO * before.number and apart and _of_before(before, last) <= wanted


def _of_before(before: _FramedRun, last: _FramedRun) -> float:
    """Geometric error of a run, estimated from the next one."""
    return last.error * (last.number / before.number) ** 2


def _refuse_too_coarse(name: str, last: _FramedRun, can_be: _Range, wanted: float) -> None:
    """Refuse an error that even one frame to every element does not reach."""
    most, elements = can_be.most, can_be.elements
    if last.number == most and last.error > wanted:
        factor = np.sqrt(last.error / wanted)
        raise InputError(
            f"bodies.{name}: no number of frames reaches a geometric error of {wanted:g}. One to every {elements[:-1]}, {most} in all, "
            f"leaves about {last.error:.2g} of the largest displacement, because the {elements} themselves turn too far. Build the model "
            f"with some {int(np.ceil(most * factor))} {elements}, or write a larger geometric_error."
        )


def _choice(runs: list[_FramedRun], wanted: float, kind: Kind) -> tuple[int, ChosenFrames]:
    """The last number of frames, or the one before where that is good enough, with the error that it leaves."""
    numbers = tuple(run.number for run in runs)
    if len(runs) > 1 and _suffices(runs, wanted):
        return runs[-2].number, ChosenFrames(wanted, _of_before(*runs[-2:]), numbers, kind, metered=runs[-2].metered)
    return runs[-1].number, ChosenFrames(wanted, runs[-1].error, numbers, kind, metered=runs[-1].metered)


def _unfinished(chosen: tuple[int, ChosenFrames], tried: int, before: int) -> tuple[int, ChosenFrames]:
    """A choice after the run with the number `tried` has failed.

    The error of a number that no other run was compared with is known by the meter alone.
    """
    number, choice = chosen
    if tried == before:
        return number, choice
    return number, choice._replace(error=choice.error if np.isfinite(choice.error) else choice.metered, failed=tried)


def with_choices(scene: Scene, choices: Choices) -> Scene:
    """The scene with numbers of frames that were chosen."""
    if not choices:
        return scene
    plain: dict[str, Any] = dict(with_frames(scene, {name: number for name, (number, _) in choices.items()}).bodies)
    chosen = {name: plain[name].as_chosen(choice) for name, (_, choice) in choices.items()}
    return scene.model_copy(update={"bodies": {**plain, **chosen}})


def with_frames(scene: Scene, frames: Mapping[str, Frames], reduced: bool = False) -> Scene:
    """The scene with other frames in some of its bodies.

    Parts have all shapes of their elements. With `reduced` those of a reduced body keep as many modes each as it has coordinates: more
    than these together, and none that vibrates much faster, so that steps that do for the body do for its parts.
    """
    changed = {name: scene.bodies[name].model_copy(update={"frames": n, "geometric_error": None}) for name, n in frames.items()}
    for name in changed if reduced else ():
        body, model = changed[name], scene.model(scene.bodies[name].model)  # type: ignore[attr-defined]
        if not (model.keeps_all or model.in_pieces) and body.modes_per_frame is None:  # type: ignore[attr-defined]
            changed[name] = body.model_copy(update={"modes_per_frame": model.n_f})
    return scene.model_copy(update={"bodies": {**scene.bodies, **changed}})
