"""Check that the state of another run, kept in a results file or at hand, fits this scene: its bodies, coordinates and models."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.errors import InputError
from toolkit.kept_run.end_state import EndState
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


def _words(body: Any) -> dict[str, Any]:
    """Words of a body's table that say what its coordinates mean."""
    return {"type": body.kind, **{key: _plain(value) for key, value in body if key not in READ_ANEW and _is_word(key, value)}}


def _is_word(key: str, value: Any) -> bool:
    return (
        isinstance(value, str)
        or (isinstance(value, tuple) and all(isinstance(each, str) for each in value))
        or (key == "axis" and value is not None)
    )


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def _digest(path: Path) -> str:
    found = path.stat()
    return _digest_of(path, found.st_mtime_ns, found.st_size)


@lru_cache(maxsize=32)
def _digest_of(path: Path, _changed: int, _size: int) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
