"""Reduced models with other keys of their skin file, built once and kept in the study's folder."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from toolkit.foundation.files.replaced_file import write_whole
from toolkit.reduced_model.file import is_reduced_model
from toolkit.scene.scene import Scene
from toolkit.sensitivity.certificate.rebuilt_bodies import build_all, given_values, source
from toolkit.studies.tradeoff.settings.store import hashed


def model_file(folder: Path, identity: str, body: str, keys: dict[str, Any]) -> Path:
    """Where the model of a body with some keys is kept."""
    return folder / f"{hashed(identity, body, keys)}.h5"


def build(scene: Scene, body: str, keys: dict[str, Any], file: Path) -> None:
    """Build a model if it is not there, at the values that the scene gives; beside it what its keys changed in skin.toml.

    Raises
    ------
    InputError
        The preprocessing refuses the skin file with these keys.
    """
    if tables_file(file).is_file() and is_reduced_model(file):
        return
    file.parent.mkdir(parents=True, exist_ok=True)
    mine = file.with_name(f"{file.stem}.{os.getpid()}.h5")  # another process may be building the same one
    wanted = {"file": str(mine.resolve()), "values": given_values(scene, body), "keys": keys}
    try:
        (built,) = build_all(source(scene, body), [wanted])
        mine.replace(file)
    finally:
        mine.unlink(missing_ok=True)
    write_whole(tables_file(file), json.dumps(built["tables"], indent=1).encode())


def tables_file(file: Path) -> Path:
    """Where the changed tables of skin.toml are kept."""
    return file.with_suffix(".json")
