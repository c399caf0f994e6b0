"""Numbers of floating frames that gradients need, where a scene leaves them to be chosen: more than its values need.

Starting with those for the values, gradients are compared with those of twice as many frames. That predicts the number with which they are
off by no more than the verdict allows; with this they are compared again.
"""

from __future__ import annotations

from collections.abc import Iterable

from toolkit.scene.scene import Scene
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.frames.chosen_frames import Choices
from toolkit.sensitivity.methods import by_method
from toolkit.sensitivity.preparation import Kind
from toolkit.sensitivity.sizes import variable_sizes
from toolkit.validity.bodies.deformation import LIMIT

ROUNDS = 4
"""Predictions; what is off then, by bodies whose number is written, the verdict of the run says."""


def with_frames_for_gradients(scene: Scene, kind: Kind, names: Iterable[str]) -> Scene:
    """The scene with the numbers of frames that an analysis and its gradients by some variables need; itself if none is to be chosen.

    Raises
    ------
    InputError, ConvergenceError, SingularSystemError
        As of `chosen_frames`.
    """
    names = tuple(names)
    return Compiled(scene, names).analysed_by(kind, more_frames if names else None).scene


def more_frames(compiled: Compiled, kind: Kind, choices: Choices) -> Choices:
    """Body -> number of frames for values and gradients, from the numbers for the values of a scene."""
    for _ in range(ROUNDS):
        found = by_method("auto", compiled.chosen(choices), kind)
        errors = found.frame_errors
        if errors is None or errors.failure:
            return choices
        worst = errors.largest(found.gradients, variable_sizes(compiled.scene, found))
        advised = {
            body: number for body, number in errors.advised(worst).items() if body in choices and not choices[body][1].kept_run
        }
        choices = _noted(choices, {body: (choices[body][0], worst) for body in advised})
        if worst <= LIMIT or not advised:
            return choices
        choices = {body: (advised.get(body, number), choice) for body, (number, choice) in choices.items()}
    return choices


def _noted(choices: Choices, tried: dict[str, tuple[int, float]]) -> Choices:
    """Choices that remember what was tried."""
    return {
        body: (number, choice._replace(gradients=(*choice.gradients, tried[body])) if body in tried else choice)
        for body, (number, choice) in choices.items()
    }
