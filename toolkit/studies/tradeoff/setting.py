"""Settings, ways to solve a scene: options of the solver and keys of the skins' files that replace the scene's own."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import prod
from statistics import median
from typing import Any, NamedTuple

from pydantic import ValidationError

from toolkit.description.run_options import RunOptions
from toolkit.description.validation_messages import messages
from toolkit.foundation.errors import InputError, ToolkitError, meant
from toolkit.scene.scene import Scene
from toolkit.studies.store import RunOutcome

EVERY_ELEMENT = "every"
"""In place of a number of frames: one to each element."""
ALL_SHAPES = "all"
"""In place of a number of modes of each part: all of its coordinates."""
MOST_SETTINGS = 2000
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
        There are more than `MOST_SETTINGS`, or a value is none that the solver knows.
    """
    size = prod(map(len, axes.values()))
    if size > MOST_SETTINGS:
        raise InputError(
            f"the grid has {size} settings, at most {MOST_SETTINGS} are run. Name fewer axes, or their values: step=0.1/0.05."
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


@dataclass(frozen=True, kw_only=True)
class SettingOutcome(RunOutcome):
    """A setting that was run; a number that does not exist is nan.

    Attributes
    ----------
    seconds
        Time of the first run with gradients, which no statement rests on.
    units, sizes
        Units of the responses; what a relative change of each variable refers to.
    method
        How the gradients came about.
    coordinates
        Of the run.
    primal, whole
        Times of the repeated runs in s: to the values; to values and gradients.
    """

    units: dict[str, str] = field(default_factory=dict)
    sizes: dict[str, float] = field(default_factory=dict)
    method: str = ""
    coordinates: int = 0
    primal: list[float] = field(default_factory=list)
    whole: list[float] = field(default_factory=list)

    def value(self, response: str) -> float:
        """Value of a response; nan if it does not exist."""
        return self.values.get(response, math.nan)

    def slope(self, response: str, variable: str) -> float:
        """Derivative of a response; nan if it does not exist."""
        return self.gradients.get(response, {}).get(variable, math.nan)

    @property
    def medians(self) -> tuple[float, float]:
        """Medians of the times to the values, and to values and gradients; nan before they are measured."""
        primal, whole = (median(times) if times else math.nan for times in (self.primal, self.whole))
        return primal, whole


DEFAULT_BUDGET = 1e-3
GRADIENT_SHARE = 10.0
"""A gradient's budget by default, in units of that of its response: an optimiser needs its direction, a reader all digits of the value."""
EVERY = "all"


class ErrorQuantity(NamedTuple):
    """What has a budget and an error: a response, or its gradient."""

    response: str
    derived: bool

    def __str__(self) -> str:
        return f"d({self.response})" if self.derived else self.response


class BudgetError(ToolkitError, ArithmeticError):
    """No setting keeps the budget."""


def read_budget(
    responses: Sequence[str], values: Iterable[str], gradients: Iterable[str], differentiated: bool
) -> dict[ErrorQuantity, float]:
    """Quantity -> largest relative error, from `RESPONSE=1e-3` and `all=1e-3`; what is not named has no limit.

    Nothing named means all responses. `d(RESPONSE)` among the values is the gradient, as among the gradients themselves.

    Raises
    ------
    InputError
        A response is unknown, a number is none or not positive, or there is no response to judge.
    """
    if not responses:
        raise InputError("the scene has no response to measure: name some in its table [responses].")
    texts = [_split(text) for text in values]
    derived = [(name[2:-1], limit) for name, limit in texts if name.startswith("d(") and name.endswith(")")]
    plain = [(name, limit) for name, limit in texts if not (name.startswith("d(") and name.endswith(")"))]
    own = _limits(responses, plain or [(EVERY, DEFAULT_BUDGET)])
    named = derived + [_split(text) for text in gradients]
    if named and not differentiated:
        raise InputError(
            "budgets of gradients need design variables: name some with --variables, or in the scene's table [design]."
        )
    slopes = _limits(responses, named) if named else {name: GRADIENT_SHARE * limit for name, limit in own.items()}
    found = {ErrorQuantity(name, False): limit for name, limit in own.items()}
    return found | ({ErrorQuantity(name, True): limit for name, limit in slopes.items()} if differentiated else {})


def _split(text: str) -> tuple[str, float]:
    name, _, number = (part.strip() for part in text.partition("="))
    try:
        limit = float(number)
    except ValueError:
        limit = math.nan
    if not (name and 0 < limit < math.inf):
        raise InputError(
            f"{text!r} is no budget: write RESPONSE=ERROR with a relative error above zero, for example {EVERY}=1e-3."
        )
    return name, limit


def _limits(responses: Sequence[str], named: list[tuple[str, float]]) -> dict[str, float]:
    """`all` first, so that single responses can differ from it."""
    found: dict[str, float] = {}
    for name, limit in sorted(named, key=lambda pair: pair[0] != EVERY or EVERY in responses):
        if name != EVERY and name not in responses:
            raise InputError(
                f"there is no response {name!r} to have a budget{meant(name, responses)}; the scene has "
                f"{', '.join(responses)}, and {EVERY}."
            )
        found |= dict.fromkeys(responses, limit) if name == EVERY and EVERY not in responses else {name: limit}
    return found
