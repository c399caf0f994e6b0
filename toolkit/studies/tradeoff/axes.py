"""The axes that a study can vary, and how a user names them: `step,scheme,rho_inf=0.5/0.8/1`.

An option of the solver becomes an axis by one line in `SOLVER_AXES`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, get_args

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError, meant
from toolkit.foundation.files.toml_file import parse_toml
from toolkit.scene.scene import Scene
from toolkit.studies.tradeoff import frame_axes, skin_axes
from toolkit.studies.tradeoff.setting import Choice

STEP_FACTORS = (4.0, 2.0, 1.0, 1 / 2, 1 / 4, 1 / 8)
"""Default steps, in units of the scene's step."""
LEFT_OUT = ("off", "default")
"""Words for an option that is not given: its feature is off, or its number has the default."""
SOLVER_AXES: dict[str, tuple[Any, ...]] = {
    "step": (),  # `STEP_FACTORS`
    "scheme": (),
    "rho_inf": (0.0, 0.5, 0.8, 1.0),
    "tolerance": (1e-4, 1e-6, 1e-8, 1e-10),
    "formulation": (),
    "newton": (),
    "quasi_static": (False, True),
    "local_error": (None, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6),
    "baumgarte": (None, 10.0, 100.0, 1000.0),
}
"""Option of the solver -> its values by default, besides the scene's own; if none are named, all words that it can be."""
DEFAULT = ("step", "scheme", "newton", "quasi_static", "local_error")
"""Axes that are varied by default."""


def available() -> list[str]:
    """Names of all axes."""
    return [*SOLVER_AXES, *skin_axes.AXES, *frame_axes.AXES]


def read_axes(scene: Scene, text: str | None) -> dict[str, list[Choice]]:
    """Axis -> its choices, from `name,name=value/value,...`; the values by default include the scene's own.

    Raises
    ------
    InputError
        An axis is unknown or named twice, or there is nothing to vary in this scene.
    """
    wanted = DEFAULT if text is None else text.split(",")
    found: dict[str, list[Choice]] = {}
    for part in filter(None, (each.strip() for each in wanted)):
        name, equals, values = (piece.strip() for piece in part.partition("="))
        if name not in available():
            raise InputError(f"--axes: there is no axis {name!r}{meant(name, available())}; available: {', '.join(available())}.")
        if name in found:
            raise InputError(f"--axes: {name!r} is named twice. Give all its values at once, for example {name}=1/2/3.")
        given = [value.strip() for value in values.split("/") if value.strip()]
        if equals and not given:
            raise InputError(f"--axes: {part!r} has no values. Write {name}=VALUE/VALUE, or {name} alone for those by default.")
        found[name] = _choices(scene, name, given)
    if not found:
        raise InputError(f"--axes names nothing; available: {', '.join(available())}.")
    frame_axes.refuse_idle(scene, found)
    return found


def _choices(scene: Scene, name: str, given: Sequence[str]) -> list[Choice]:
    if name in skin_axes.AXES:
        return skin_axes.choices(scene, name, given)
    if name in frame_axes.AXES:
        return frame_axes.choices(scene, name, given)
    maker = {"step": _steps, "baumgarte": _baumgarte}.get(name, _options)
    values = [_value(text) for text in given] if given else None
    return unlike(maker(scene, name, values))


def unlike(choices: list[Choice]) -> list[Choice]:
    """Choices without those that repeat an earlier one."""
    found: list[Choice] = []
    for choice in choices:
        if all((choice.solver, choice.skin) != (other.solver, other.skin) for other in found):
            found.append(choice)
    return found


def _value(text: str) -> Any:
    """A value as TOML has it; bare words are texts, numbers are floats, `off` and `default` are none."""
    if text in LEFT_OUT:
        return None
    try:
        value = parse_toml(f"value = {text}")["value"]
    except ValueError:
        return text
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value


def _options(scene: Scene, name: str, given: Sequence[Any] | None) -> list[Choice]:
    own = getattr(scene.solver, name)
    values = [own, *(SOLVER_AXES[name] or get_args(RunOptions.model_fields[name].annotation))] if given is None else given
    return [Choice(LEFT_OUT[0] if value is None else label(value), {name: value}, own=value == own) for value in values]


def _steps(scene: Scene, _: str, given: Sequence[Any] | None) -> list[Choice]:
    """Choices of the step, from the coarsest that makes at least two steps; times that the scene gives are left out."""
    own, end, given_times = scene.solver.step, scene.solver.end_time, scene.solver.times is not None
    values = [own * factor for factor in STEP_FACTORS if 2 * own * factor <= end or factor <= 1] if given is None else given
    return [Choice(label(value), {"step": value, "times": None}, own=value == own and not given_times) for value in values]


def _baumgarte(scene: Scene, _: str, given: Sequence[Any] | None) -> list[Choice]:
    """Choices of Baumgarte's damping a, with the stiffness sqrt(2) a that belongs to it by default."""
    mine = scene.solver.baumgarte
    values = SOLVER_AXES["baumgarte"] if given is None else given
    tables = [None if a is None else {"damping": a, "stiffness": 2**0.5 * a} if isinstance(a, float) else a for a in values]
    made = [
        Choice(label(a), {"baumgarte": table}, own=(table or {}) == mine.model_dump(exclude_none=True))
        for a, table in zip(values, tables, strict=True)
    ]
    return made if given is not None or any(choice.own for choice in made) else [_own_baumgarte(scene), *made]


def _own_baumgarte(scene: Scene) -> Choice:
    mine = scene.solver.baumgarte.model_dump(exclude_none=True)
    return Choice("the scene's", {"baumgarte": mine}, own=True)


def label(value: Any) -> str:
    """A value as a table shows it, and as `--axes` takes it."""
    if value is None:
        return LEFT_OUT[1]
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else str(value)
