"""All combinations of the choices on all axes."""

from __future__ import annotations

from itertools import product

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.studies.tradeoff.settings.setting import Choice, Setting, options_with

MOST = 2000


def grid(scene: Scene, axes: dict[str, list[Choice]]) -> list[Setting]:
    """The settings of a study, each once.

    An adaptive run (`local_error`) chooses its steps itself, below `step`: it is tried with the largest one only.

    Raises
    ------
    InputError
        There are more than `MOST`, or a value is none that the solver knows.
    """
    size = 1
    for choices in axes.values():
        size *= len(choices)
    if size > MOST:
        raise InputError(
            f"the grid has {size} settings, at most {MOST} are run. Name fewer axes, or their values: step=0.1/0.05."
        )
    for choice in (choice for choices in axes.values() for choice in choices):
        check_choice(scene, choice)
    settings = [Setting(dict(zip(axes, each, strict=True))) for each in product(*axes.values())]
    return [setting for setting in settings if not _repeats(setting, axes)]


def check_choice(scene: Scene, choice: Choice) -> None:
    """Refuse a value that cannot be meant before the work begins; what does not go together is found by running it."""
    options_with(scene.model_copy(update={"solver": RunOptions(end_time=scene.solver.end_time)}), choice.solver)


def _repeats(setting: Setting, axes: dict[str, list[Choice]]) -> bool:
    steps = [choice.solver["step"] for choice in axes.get("step", [])]
    return bool(steps) and setting.solver.get("local_error") is not None and setting.solver["step"] < max(steps)
