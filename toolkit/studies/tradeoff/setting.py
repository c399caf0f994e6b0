"""Settings, ways to solve a scene: options of the solver and keys of the skins' files that replace the scene's own."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product
from math import prod
from typing import Any

from pydantic import ValidationError

from toolkit.description.run_options import RunOptions
from toolkit.description.validation_messages import messages
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene

EVERY_ELEMENT = "every"
"""In place of a number of frames: one to each element."""
ALL_SHAPES = "all"
"""In place of a number of modes of each part: all of its coordinates."""
MOST = 2000
"""Most settings of a study."""


@dataclass(frozen=True)
class Choice:
    """One value of one axis: its label, what it replaces in the solver's table, in skin.toml and of the bodies' frames and of their modes,
    and whether the scene has it already.

    A solver's option that is None is left out, so that its default holds.
    """

    label: str
    solver: dict[str, Any] = field(default_factory=dict)
    skin: dict[str, Any] = field(default_factory=dict)
    frames: int | str | None = None
    modes: int | str | None = None
    own: bool = False


@dataclass(frozen=True)
class Setting:
    """A choice on every axis, by the axes' names."""

    choices: dict[str, Choice]

    @property
    def labels(self) -> dict[str, str]:
        """Axis -> label."""
        return {axis: choice.label for axis, choice in self.choices.items()}

    @property
    def solver(self) -> dict[str, Any]:
        """Options of the solver that replace the scene's."""
        return {key: value for choice in self.choices.values() for key, value in choice.solver.items()}

    @property
    def skin(self) -> dict[str, Any]:
        """Keys of the skin's file that replace those that are there; none if the scene's own models serve."""
        return {key: value for choice in self.choices.values() for key, value in choice.skin.items()}

    @property
    def frames(self) -> int | str | None:
        """Floating frames of the bodies that can have several; None if the scene's own serve."""
        return next((choice.frames for choice in self.choices.values() if choice.frames is not None), None)

    @property
    def modes(self) -> int | str | None:
        """Modes that each part of these keeps; None if the scene's own serve."""
        return next((choice.modes for choice in self.choices.values() if choice.modes is not None), None)

    @property
    def own(self) -> bool:
        """Whether this is the scene as it stands."""
        return all(choice.own for choice in self.choices.values())

    def __str__(self) -> str:
        return ", ".join(f"{axis} {label}" for axis, label in self.labels.items())


def options_with(scene: Scene, changes: dict[str, Any]) -> RunOptions:
    """The scene's options with others in their place; None leaves an option out.

    Raises
    ------
    InputError
        A value is invalid.
    """
    table = {**scene.solver.model_dump(exclude_unset=True), **changes}
    given = {key: value for key, value in table.items() if value is not None}
    try:
        return RunOptions.model_validate(given)
    except ValidationError as error:
        raise InputError("\n".join(messages(error, RunOptions, given, "solver", {}))) from error


def with_options(scene: Scene, changes: dict[str, Any]) -> Scene:
    """The scene with other options of the solver, see `options_with`."""
    return scene.model_copy(update={"solver": options_with(scene, changes)})


def grid(scene: Scene, axes: dict[str, list[Choice]]) -> list[Setting]:
    """The settings of a study, each once.

    An adaptive run (`local_error`) chooses its steps itself, below `step`: it is tried with the largest one only.

    Raises
    ------
    InputError
        There are more than `MOST`, or a value is none that the solver knows.
    """
    size = prod(map(len, axes.values()))
    if size > MOST:
        raise InputError(
            f"the grid has {size} settings, at most {MOST} are run. Name fewer axes, or their values: step=0.1/0.05."
        )
    for choice in (choice for choices in axes.values() for choice in choices):
        _check_choice(scene, choice)
    settings = [Setting(dict(zip(axes, each, strict=True))) for each in product(*axes.values())]
    return [setting for setting in settings if not _repeats(setting, axes)]


def _check_choice(scene: Scene, choice: Choice) -> None:
    """Refuse an invalid value before the work begins; what does not go together is found by running it."""
    options_with(scene.model_copy(update={"solver": RunOptions(end_time=scene.solver.end_time)}), choice.solver)


def _repeats(setting: Setting, axes: dict[str, list[Choice]]) -> bool:
    steps = [choice.solver["step"] for choice in axes.get("step", [])]
    return bool(steps) and setting.solver.get("local_error") is not None and setting.solver["step"] < max(steps)
