"""Whether reduced models are those of the files that they were built from, as these are now."""

from __future__ import annotations

import hashlib
import os
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.errors import listed
from toolkit.foundation.files.safe_files import read_whole
from toolkit.foundation.verdict import SCENE, Caution, check
from toolkit.reduced_model.model import ReducedModel
from toolkit.scene.scene import Scene

LARGEST_INPUT = 2 * 10**9
"""Bytes of a file from which a model was built; a larger one, or what is no file any more, says nothing."""
MOST = 4
"""Keys that are named."""
GONE = "left out"
"""What stands for a key that one of two texts does not have."""


@check("stale-model", (SCENE,))
def stale_models(scene: Scene) -> list[Caution]:
    """A reduced model is older than what it was built from.

    Limit: any changed number of its files.
    Fix: build it again.

    A doubt for every flexible body whose reduced model is older than the files that it was built from.

    A model holds the SHA-256 of each of these, and the text of the TOML file among them. A file that is not there says nothing: an
    installation that only simulates has the models alone. Nor does a change of comments or of the layout of the TOML file.

    Parameters
    ----------
    scene : the scene that is analysed; its models are read if they have not been

    Returns
    -------
    list of Caution
        With the code "stale-model"; each names the body, the files, what has changed in them as far as that is known, and the command
        that builds the model again. Empty if every model is up to date, or was built from no files.
    """
    bodies: dict[str, list[str]] = {}
    for name, body in scene.bodies.items():
        if isinstance(body, ModelBody):
            bodies.setdefault(body.model, []).append(name)
    found = ((names, scene.model(file)) for file, names in bodies.items())
    return [_caution(names, model, changes) for names, model in found if (changes := list(_changes(model)))]


def _changes(model: ReducedModel) -> Iterator[str]:
    """What has changed since a model was built, in words."""
    for name, stamp in model.inputs.items():
        file = _place(model, name)
        try:
            content = read_whole(file, LARGEST_INPUT)
        except OSError:
            continue
        if hashlib.sha256(content).hexdigest() == stamp:
            continue
        keys = list(_changed_keys(model.source.get(name, ""), content))
        if keys:
            yield f"{name}, where {'; '.join(keys[:MOST])}{' and more' if len(keys) > MOST else ''}"
        elif not _same(model.source.get(name, ""), content):
            yield name


def _place(model: ReducedModel, name: str) -> Path:
    return Path(os.path.normpath((model.inputs_from or Path()) / name))


def _caution(bodies: list[str], model: ReducedModel, changes: list[str]) -> Caution:
    command = [f"ffrf-preprocess {_place(model, source)}" for source in model.source]
    command += [f"--parameter {name}={value!r}" for name, value in model.changes.items()]
    if model.path and not any(model.path.name == Path(source).with_suffix(".h5").name for source in model.source):
        command.append(f"--output {model.path}")
    return stale_models.caution(
        f"the reduced model {model.label} of {listed(bodies)} is older than what it was built from: there are changes in "
        f"{' and in '.join(changes)}. These numbers are those of the old files. Fix: build it again, {' '.join(command)}",
    )


def _changed_keys(before: str, now: bytes) -> Iterator[str]:
    """Keys of two TOML texts that differ, with both values; none if one of them is no such text."""
    old, new = _table(before), _table(now.decode(errors="replace"))
    if old is None or new is None:
        return
    ours, theirs = dict(_flat("", old)), dict(_flat("", new))
    for key in dict.fromkeys([*theirs, *ours]):
        if ours.get(key, GONE) != theirs.get(key, GONE):
            yield f"{key} is {theirs.get(key, GONE)} and was {ours.get(key, GONE)}"


def _same(before: str, now: bytes) -> bool:
    """Whether two TOML texts say the same."""
    old = _table(before)
    return bool(before) and old is not None and old == _table(now.decode(errors="replace"))


def _table(text: str) -> dict[str, Any] | None:
    try:
        return tomllib.loads(text) if text else None
    except tomllib.TOMLDecodeError:
        return None


def _flat(prefix: str, table: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Every value with its key in all tables above it."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _flat(f"{prefix}{key}.", value)
        else:
            yield f"{prefix}{key}", value
