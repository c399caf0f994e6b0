"""Whether the state that a results file keeps is one of this scene: of its bodies, its coordinates and its reduced models."""

from __future__ import annotations

import hashlib
from functools import lru_cache
from pathlib import Path
from typing import Any

from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.errors import InputError
from toolkit.kept_run.end_state import EndState
from toolkit.scene.cut_scene import written
from toolkit.system.system import System

READ_ANEW = ("model", "extrapolation")
"""Words of a body that may differ from those of the kept run: its reduced model is compared by its content."""


def refuse_other_scene(system: System, end: EndState) -> None:
    """Refuse a state of other bodies, coordinates or reduced models.

    Raises
    ------
    InputError
        Names what differs.
    """
    scene, name = system.scene, end.path.name
    again = "Give a file of the same bodies, or run this scene first to make one."
    if end.units != scene.units:
        raise InputError(f"solver.start: {name!r} is in {end.units}, the scene in {scene.units}. {again}")
    ours = system.numbering.names[: system.n_q]
    if end.coordinates != ours:
        foreign = next((each for each in end.coordinates if each not in ours), None)
        missing = next((each for each in ours if each not in end.coordinates), None)
        which = f"it has no {missing}" if missing else f"it has the {foreign}" if foreign else "its bodies are in another order"
        raise InputError(f"solver.start: {name!r} keeps a run of another scene: {which}. {again}")
    for body_name, body in written(scene).bodies.items():
        there = end.bodies.get(body_name, {})
        here = {"type": body.kind, **{key: _plain(value) for key, value in body if key not in READ_ANEW and _is_word(key, value)}}
        for key, word in here.items():
            if there.get(key) != word:
                raise InputError(
                    f"solver.start: {name!r} keeps a run of another scene: bodies.{body_name}.{key} was {there.get(key)!r} there and is "
                    f"{word!r} here, so that the coordinates of the body mean something else. {again}"
                )
        if isinstance(body, ModelBody) and end.models.get(str(there.get("model"))) != _digest(scene.directory / body.model):
            raise InputError(
                f"solver.start: {name!r} keeps a run with another reduced model of body {body_name!r}: {body.model!r} has another "
                f"content now, and its elastic coordinates mean something else. {again}"
            )


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
