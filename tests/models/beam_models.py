"""Reduced models of beams along any polygon, for tests of the runtime against closed forms."""

from __future__ import annotations

from pathlib import Path

from preprocessing.recipes.frame.polygon_beam import polygon_beam
from toolkit.reduced_model.file import save


def save_beam(path: Path, *args, **kwargs) -> Path:
    """Build a beam and write it to a file; arguments as `polygon_beam`."""
    save(polygon_beam(*args, **kwargs), path)
    return path
