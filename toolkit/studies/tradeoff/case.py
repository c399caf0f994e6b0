"""What all settings of a study have in common: the scene, the folder of what is kept, and reduced models built with other keys."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from toolkit.foundation.files.replaced_file import write_whole
from toolkit.foundation.files.toml_file import read_toml
from toolkit.reduced_model.file import is_reduced_model
from toolkit.scene.scene import Scene
from toolkit.scene_file.reader import read_scene
from toolkit.sensitivity.certificate.rebuilt_bodies import build_all, given_values, rebuildable, source, with_model
from toolkit.studies.engine.fingerprint import file_hashes, hashed, scene_fingerprint
from toolkit.studies.tradeoff.frame_axes import framed
from toolkit.studies.tradeoff.setting import Setting, with_options


@dataclass(frozen=True)
class Case:
    """What all settings of a study have in common; small enough to be sent to another process.

    Attributes
    ----------
    path, changes
        The scene's file, and values that replace those in it.
    names
        Design variables; none if no gradients are wanted.
    folder
        Where outcomes and models are kept.
    identity
        `fingerprint` of all this.
    """

    path: Path
    changes: dict[str, str]
    names: tuple[str, ...]
    folder: Path
    identity: str

    def scene(self) -> Scene:
        """The scene as it stands."""
        return read_scene(self.path, self.changes)

    @property
    def models(self) -> Path:
        """Folder of reduced models that were built with other keys."""
        return self.folder / "models"

    def key(self, setting: Setting) -> str:
        """Hash of everything that a setting's outcome follows from."""
        return hashed(self.identity, setting.solver, setting.skin, setting.frames, setting.modes)

    def model_file(self, body: str, keys: dict[str, Any]) -> Path:
        """Where the model of a body with some keys is kept."""
        return self.models / f"{hashed(self.identity, body, keys)}.h5"

    def scene_of(self, setting: Setting) -> Scene:
        """The scene solved by a setting, whose models have been built."""
        scene = with_options(self.scene(), setting.solver)
        for body in model_bodies(scene, setting):
            scene = with_model(scene, body, self.model_file(body, setting.skin).resolve())
        return framed(scene, setting.frames, setting.modes)

    def build_models(self, setting: Setting) -> None:
        """Build all models of a setting that are not there.

        Raises
        ------
        InputError
            The preprocessing refuses a skin file with the setting's keys.
        """
        scene = self.scene()
        for body in model_bodies(scene, setting):
            _build(scene, body, setting.skin, self.model_file(body, setting.skin))


def fingerprint(scene: Scene, names: list[str]) -> str:
    """Hash of a scene with all its files, its variables, and of the program that runs it."""
    return scene_fingerprint(scene, names, file_hashes(_skin_files(scene)))


def _skin_files(scene: Scene) -> list[Path]:
    """The skin files that models are built from, and the airfoils that they name."""
    found = []
    for skin in dict.fromkeys(rebuildable(scene).values()):
        airfoil = read_toml(skin, "a skin.toml").get("airfoil", {})
        found += [skin, *(skin.parent / str(airfoil[key]) for key in ("file", "target") if key in airfoil)]
    return found


def model_bodies(scene: Scene, setting: Setting) -> list[str]:
    """Bodies whose models a setting builds with other keys."""
    return list(rebuildable(scene)) if setting.skin else []


def tables_file(model: Path) -> Path:
    """Where the tables of skin.toml that a model's keys changed are kept."""
    return model.with_suffix(".json")


def _build(scene: Scene, body: str, keys: dict[str, Any], file: Path) -> None:
    """Build a model if it is not there, at the values that the scene gives; beside it what its keys changed in skin.toml."""
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
