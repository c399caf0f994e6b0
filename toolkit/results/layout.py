"""What a results file holds: groups, arrays, and the axes that have to agree."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from toolkit.errors import ToolkitError

SCHEMA = "ffrf-results"
SCHEMA_VERSION = 1

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

_SQUEEZED = 1100
"""Most that HDF5's compression makes of a byte, with a little to spare; an array that claims more was never written."""


class ResultsFileError(ToolkitError, ValueError):
    """A results file is missing, damaged, foreign or of another schema version."""


def array(file: h5py.File, name: str, path: Path, axes: str, sizes: dict[str, int]) -> np.ndarray:
    """Read numbers whose axes must have the sizes found so far; sizes of new axes are noted."""
    data = dataset(file, name, path)
    if data.dtype.kind not in "fiu" or data.ndim != len(axes):
        raise damaged(path, f"{name} is {data.dtype} with {data.ndim} axes instead of numbers with {len(axes)}")
    for axis, size in zip(axes, data.shape, strict=True):
        if sizes.setdefault(axis, size) != size:
            raise damaged(path, f"{name} has the shape {data.shape}, which does not fit the other arrays")
    values = data[()]
    if not np.all(np.isfinite(values)) and name.rpartition("/")[2] not in UNDEFINED:
        raise damaged(path, f"{name} holds values that are not finite")
    return values


def names(file: h5py.File, name: str, path: Path, count: int) -> list[str]:
    """Read a list of names of a known length."""
    data = dataset(file, name, path)
    if data.dtype.kind != "S" or data.shape != (count,):
        raise damaged(path, f"{name} has {data.shape} entries of {data.dtype} instead of {count} names")
    return [item.decode() for item in data[()].tolist()]


def text(file: h5py.File, name: str, path: Path) -> str:
    """Read a text."""
    data = dataset(file, name, path)
    if data.dtype.kind != "S" or data.ndim:
        raise damaged(path, f"{name} is {data.dtype} with {data.ndim} axes instead of a text")
    return bytes(data[()]).decode()


def dataset(file: h5py.File, name: str, path: Path) -> h5py.Dataset:
    """An array of the file that can be as large as it says."""
    found = file.get(name)
    if not isinstance(found, h5py.Dataset):
        raise damaged(path, f"it lacks {name}")
    elsewhere = found.is_virtual or found.external or found.file.filename != file.filename
    if elsewhere or found.nbytes > _SQUEEZED * path.stat().st_size:
        raise damaged(path, f"{name} claims {found.nbytes} bytes, which are not in the file")
    return found


def damaged(path: Path, problem: str) -> ResultsFileError:
    """The error for a file that cannot be trusted."""
    return ResultsFileError(f"results file {str(path)!r} is damaged or incomplete: {problem}. Run the scene again with --output.")


def schema(file: h5py.File) -> str:
    """The attribute `schema` of a file, whether it is of fixed or of variable length."""
    found = file.attrs.get("schema")
    return found.decode("utf-8", "replace") if isinstance(found, bytes) else str(found)


def schema_of(path: Path) -> str | None:
    """Which of the program's HDF5 files it is, by its attribute `schema`; None if it cannot be read as one."""
    try:
        with h5py.File(path, "r") as file:
            return schema(file)
    except (OSError, RuntimeError, ValueError, TypeError):
        return None
