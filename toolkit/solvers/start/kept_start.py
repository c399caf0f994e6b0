"""A start in the last state of a run that a results file keeps, and how it depends on the design.

The state is a constant of the file. What moves it is only known where the run has computed its derivatives: by numbers that the scene of
that run did not have it does not move, by all others it has to be told how.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from toolkit.components.bodies.body import Body
from toolkit.components.bodies.model_body import ModelBody
from toolkit.description.end_state import EndState, end_state
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.solvers.start.initial_conditions import ConsistentMotion, closed_start
from toolkit.system.quantities import STEP
from toolkit.system.system import System

READ_ANEW = ("model", "extrapolation")
"""Words of a body that may differ from those of the kept run: its reduced model is compared by its content."""


class _Known(NamedTuple):
    """Record of the run that a scene starts in, by its own account.

    It holds words for messages, units, coordinates, tables of its bodies, and content of its models.
    """

    what: str
    units: str
    coordinates: tuple[str, ...]
    bodies: Mapping[str, Mapping[str, Any]]
    models: Mapping[str, str]
    again: str


def refuse_other_scene(system: System, end: EndState) -> None:
    """Refuse a kept state of other bodies, coordinates or reduced models.

    Raises
    ------
    InputError
        Names what differs.
    """
    again = "Give a file of the same bodies, or run this scene first to make one."
    what = f"solver.start: {end.path.name!r} keeps a run"
    _refuse(system, _Known(what, end.units, end.coordinates, end.bodies, end.models, again))


def refuse_other_run(system: System, known: System) -> None:
    """Refuse the state of a run at hand with other bodies, coordinates or reduced models.

    Raises
    ------
    InputError
        Names what differs.
    """
    scene = known.scene.written
    tables = {name: _words(body) | {"model": getattr(body, "model", None)} for name, body in scene.bodies.items()}
    files = {body.model: _digest(scene.directory / body.model) for body in scene.bodies.values() if isinstance(body, ModelBody)}
    names = known.numbering.names[: known.n_q]
    again = "Give one of the same scene, at any numbers."
    _refuse(system, _Known("start is a run", known.scene.units, names, tables, files, again))


def _refuse(system: System, known: _Known) -> None:
    scene, ours = system.scene, system.numbering.names[: system.n_q]
    if known.units != scene.units:
        raise InputError(f"{known.what} in {known.units}, the scene is in {scene.units}. {known.again}")
    if known.coordinates != ours:
        foreign = next((each for each in known.coordinates if each not in ours), None)
        missing = next((each for each in ours if each not in known.coordinates), None)
        which = f"it has no {missing}" if missing else f"it has the {foreign}" if foreign else "its bodies are in another order"
        raise InputError(f"{known.what} of another scene: {which}. {known.again}")
    for name, body in scene.written.bodies.items():
        there = known.bodies.get(name, {})
        for key, word in _words(body).items():
            if there.get(key) != word:
                raise InputError(
                    f"{known.what} of another scene: bodies.{name}.{key} was {there.get(key)!r} there and is {word!r} here, so that the "
                    f"coordinates of the body mean something else. {known.again}"
                )
        if isinstance(body, ModelBody) and known.models.get(str(there.get("model"))) != _digest(scene.directory / body.model):
            raise InputError(
                f"{known.what} with another reduced model of body {name!r}: {body.model!r} has another content now, and its elastic "
                f"coordinates mean something else. {known.again}"
            )


def _words(body: Body) -> dict[str, object]:
    """Words of a body's table that say what its coordinates mean."""
    return {"type": body.kind, **{key: _plain(value) for key, value in body if key not in READ_ANEW and _is_word(key, value)}}


def _is_word(key: str, value: object) -> bool:
    return (
        isinstance(value, str)
        or (isinstance(value, tuple) and all(isinstance(each, str) for each in value))
        or (key == "axis" and value is not None)
    )


def _plain(value: object) -> object:
    return list(value) if isinstance(value, tuple) else value


def _digest(path: Path) -> str:
    found = path.stat()
    return _digest_of(path, found.st_mtime_ns, found.st_size)


@lru_cache(maxsize=32)
def _digest_of(path: Path, _changed: int, _size: int) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


EQUAL_NUMBERS = 1e-12
"""Relative difference of two numbers that is round-off."""


def kept_state(scene: Scene) -> EndState | None:
    """State that a scene names as its start; None if it names none."""
    return None if scene.start_file is None else end_state(scene.start_file)


def kept_start(system: System, options: RunOptions) -> ConsistentMotion:
    """Coordinates and velocities (n,) that satisfy every joint at t = 0 next to those of the kept run, and derivatives (n, n_x).

    Raises
    ------
    InputError
        The file is that of another scene, the joints are elsewhere, or a design variable has moved the kept run in an unknown way.
    """
    end = kept_state(system.scene)
    assert end is not None
    refuse_other_scene(system, end)
    n_q, q, v = system.n_q, end.q, end.v
    dq, dv = np.zeros((2, system.n, system.n_x))
    for x, variable in enumerate(system.design):
        shares = dict(zip(variable.paths, variable.factors, strict=True))
        dq[:n_q, x], dv[:n_q, x] = _slopes(system.scene, end, f"the design variable {variable.name!r}", shares)
    if not system.compiled:  # a complex step moves the start as the kept run says
        steps = {path: np.imag(number) / STEP for path, number in system.scene.numbers() if np.imag(number)}
        slopes = _slopes(system.scene, end, "the complex step", steps)
        q, v = q + 1j * STEP * slopes[0], v + 1j * STEP * slopes[1]
    return closed_start(system, q, v, dq, dv, options)


def other_numbers(scene: Scene, end: EndState) -> list[str]:
    """Texts on the numbers of a scene that were others in the kept run, but for those of time curves, which begin anew."""
    numbers, found = end.numbers, []
    nominal = scene.model_parameters()
    for path in scene.available_paths():
        here, there = float(np.real(scene.number(path))), numbers.get(path, nominal.get(path))
        if end.has(path) and "curve" not in path.split(".") and there is not None and not _equal(here, there):
            found.append(f"{path} = {there:.6g} there and {here:.6g} here")
    return found


def moves_kept_run(scene: Scene, path: str) -> bool:
    """Whether a number has acted in the run whose last state the scene starts in.

    That state stays while the number moves.
    """
    end = kept_state(scene)
    return end is not None and end.has(path)


def refuse_differences(scene: Scene, paths: Iterable[str]) -> None:
    """Refuse difference quotients by numbers that have moved the kept run.

    Raises
    ------
    InputError
        Names the number.
    """
    moved = next((path for path in paths if moves_kept_run(scene, path)), None)
    if moved is not None:
        raise InputError(
            f"differences by {moved!r} leave out how the start depends on it: solver.start is the state of a run at one value of it. Take "
            'the method "direct", "adjoint" or "complex-step", which know the derivatives that the results file keeps.'
        )


def _slopes(scene: Scene, end: EndState, what: str, shares: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of coordinates and velocities (n_q,) of the kept run along numbers: path -> how fast it grows."""
    acted = {path: share for path, share in shares.items() if end.has(path)}
    for path in acted:
        _refuse_other_value(scene, end, path)
    weights = _weights(end, acted)
    if weights is None:
        raise InputError(
            f"{what} ({', '.join(acted)}) has acted in the run that {end.path.name!r} keeps too, and the file does "
            "not tell how its last state depends on it, so that the gradient would miss that part. Keep that run with derivatives: "
            f"ffrf sensitivity SCENE.toml --method direct --variables {','.join(acted)} --output {end.path.name}."
        )
    return end.dq @ weights, end.dv @ weights


def _weights(end: EndState, acted: Mapping[str, float]) -> np.ndarray | None:
    """Share of each column of the file's derivatives (n_c,) in numbers that grow together; None if they are not there."""
    found = np.zeros(len(end.columns))
    alone = {next(iter(column)): k for k, column in enumerate(end.columns) if len(column) == 1}
    if all(path in alone for path in acted):
        for path, share in acted.items():
            found[alone[path]] = share / end.columns[alone[path]][path]
        return found
    whole = [k for k, column in enumerate(end.columns) if _same(column, acted)]
    found[whole[:1]] = 1.0
    return found if whole else None


def _equal(one: float, other: float) -> bool:
    return abs(one - other) <= EQUAL_NUMBERS * max(abs(one), abs(other))


def _same(column: Mapping[str, float], shares: Mapping[str, float]) -> bool:
    return column.keys() == shares.keys() and all(_equal(column[path], share) for path, share in shares.items())


def _refuse_other_value(scene: Scene, end: EndState, path: str) -> None:
    here = float(np.real(scene.number(path)))
    there = end.numbers.get(path, scene.model_parameters().get(path, here))
    if not _equal(here, there):
        raise InputError(
            f"there is no gradient by {path!r}: it is {here:.9g}, and was {there:.9g} in the run whose last state {end.path.name!r} keeps. "
            "Make that run anew at this value, with derivatives."
        )
