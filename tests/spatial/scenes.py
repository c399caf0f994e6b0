"""Points and frame models that the tests in space share."""

from __future__ import annotations

from pathlib import Path

from preprocessing import build
from tests.models.kept_files import write_once
from toolkit.description.design import Point
from toolkit.reduced_model.file import save


def at(**places: tuple[float, float, float]) -> dict[str, Point]:
    """Points of a scene by their coordinates."""
    return {name: Point(x=float(x), y=float(y), z=float(z)) for name, (x, y, z) in places.items()}


def save_frame(directory: Path, name: str, text: str) -> Path:
    """Write `name`.toml with the text, and build `name`.h5 beside it; the path of the text."""
    write_once(directory, (name, text), lambda own: _build(own / f"{name}.toml", text))
    return directory / f"{name}.toml"


def _build(path: Path, text: str) -> None:
    path.write_text(text)
    save(build(path), path.with_suffix(".h5"))
