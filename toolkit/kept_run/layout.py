"""Layout of a results file: groups, arrays, and the axes that have to agree."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.files.hdf5 import Content

SCHEMA = "ffrf-results"
SCHEMA_VERSION = 2
READABLE = (1, 2)
"""Versions that can be read: the first kept no verdict."""

STATES = {
    "times": "t",
    "q": "tq",
    "v": "tq",
    "a": "tq",
    "multipliers": "tl",
    "dq": "tqx",
    "dv": "tqx",
    "da": "tqx",
    "dmultipliers": "tlx",
}
"""Arrays of the whole scene and their axes: times, coordinates, multipliers, variables."""

BODY = {
    "stress": "ts",
    "dstress": "tsx",
    "element": "s",
    "end": "s",
    "fibre": "s",
    "shape_error": "tk",
    "dshape_error": "tkx",
    "arc_length": "k",
}
"""Arrays of a flexible body and their axes: times, stress points, nodes with a target, variables."""

NAMES = {"coordinates": "q", "multiplier_names": "l", "design": "x"}
"""Lists of names and the axis that they label."""

TEXTS = ("about", "scene_text")
"""`about` is JSON with everything that is no array; `scene_text` the scene's file as it was."""

UNDEFINED = ("dshape_error",)
"""Arrays that may hold nan: a derivative that does not exist."""


class ResultsFileError(ToolkitError, ValueError):
    """A results file is missing, damaged, foreign or of another schema version."""


def array(content: Content, name: str, axes: str, sizes: dict[str, int]) -> np.ndarray:
    """Read numbers whose axes must have the sizes found so far; sizes of new axes are noted. Raises ValueError if they do not."""
    values = content.array(name)
    if values.dtype.kind == "S" or values.ndim != len(axes):
        raise ValueError(f"{name} is {values.dtype} with {values.ndim} axes instead of numbers with {len(axes)}")
    for axis, size in zip(axes, values.shape, strict=True):
        if sizes.setdefault(axis, size) != size:
            raise ValueError(f"{name} has the shape {values.shape}, which does not fit the other arrays")
    if not np.all(np.isfinite(values)) and name.rpartition("/")[2] not in UNDEFINED:
        raise ValueError(f"{name} holds values that are not finite")
    return values


def names(content: Content, name: str, count: int) -> list[str]:
    """Read a list of names of a known length."""
    values = content.array(name)
    if values.dtype.kind != "S" or values.shape != (count,):
        raise ValueError(f"{name} has {values.shape} entries of {values.dtype} instead of {count} names")
    return [item.decode() for item in values.tolist()]


def text(content: Content, name: str) -> str:
    """Text under a name in a file."""
    value = content.array(name)
    if value.dtype.kind != "S" or value.ndim:
        raise ValueError(f"{name} is {value.dtype} with {value.ndim} axes instead of a text")
    return bytes(value[()]).decode()


def damaged(path: Path, problem: str) -> ResultsFileError:
    """Error for a file that cannot be trusted."""
    return ResultsFileError(f"results file {str(path)!r} is damaged or incomplete: {problem}. Run the scene again with --output.")
