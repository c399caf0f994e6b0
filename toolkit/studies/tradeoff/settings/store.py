"""Records on disk, one file per setting: a study that was interrupted goes on where it stopped.

A file's name is the hash of all that its content follows from. What belongs to a scene, a model or a program that has changed since is
never read again; it may be deleted at any time.
"""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path

from pydantic import ValidationError

from toolkit.foundation.files.replaced_file import write_whole
from toolkit.foundation.files.toml_file import read_toml
from toolkit.scene.scene import Scene
from toolkit.sensitivity.certificate.rebuilt_bodies import rebuildable
from toolkit.studies.identity import hashed, program
from toolkit.studies.tradeoff.settings.record import Record


class Store:
    """The records of one folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def find(self, key: str) -> Record | None:
        """The record of a key; None if there is none, or its file is damaged."""
        try:
            record = Record.model_validate_json((self.folder / f"{key}.json").read_bytes())
        except (OSError, ValidationError):
            return None
        return record if record.key == key else None

    def keep(self, record: Record) -> None:
        """Write a record in one stroke."""
        write_whole(self.folder / f"{record.key}.json", record.model_dump_json(indent=1).encode())


def fingerprint(path: Path, scene: Scene, changes: dict[str, str], names: list[str]) -> str:
    """Hash of a scene with all its files, its changes and variables, and of the program that runs it."""
    models = sorted({str(body.model) for body in scene.bodies.values() if hasattr(body, "model")})
    files = [path, *(scene.directory / model for model in models), *skin_files(scene)]
    return hashed([_content(file) for file in files], sorted(changes.items()), names, program())


def skin_files(scene: Scene) -> list[Path]:
    """The skin files that models are built from, and the airfoils that they name."""
    found = []
    for skin in dict.fromkeys(rebuildable(scene).values()):
        airfoil = read_toml(skin, "a skin.toml").get("airfoil", {})
        found += [skin, *(skin.parent / str(airfoil[key]) for key in ("file", "target") if key in airfoil)]
    return found


def _content(path: Path) -> str:
    try:
        return sha256(path.read_bytes()).hexdigest()
    except OSError:
        return "missing"
