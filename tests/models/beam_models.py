"""Reduced models of beams along any polygon, for tests of the runtime against closed forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from preprocessing.builders.frame_recipe import polygon_beam
from tests.models.kept_files import write_once
from toolkit.reduced_model.file import save


def save_beam(path: Path, nodes: np.ndarray, *args, **kwargs) -> Path:
    """Build a beam and write it to a file; arguments as `polygon_beam`, but without rotary inertia, as most closed forms are."""
    kwargs = {"rotary_inertia": False, **kwargs}
    key = path.name, repr((nodes.tolist(), args, kwargs))
    write_once(path.parent, key, lambda own: save(polygon_beam(nodes, *args, **kwargs), own / path.name))
    return path
