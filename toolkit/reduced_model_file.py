"""The HDF5 file of a reduced model: written in one stroke, read part by part, never trusted."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from toolkit.errors import ModelFileError
from toolkit.reduced_model import InterfacePoint, Invariants, Mesh, Polynomial, ReducedModel, Shape, StressPoints
from toolkit.reduced_model_check import check
from toolkit.replaced_file import replaced

SCHEMA = "ffrf-reduced-model"
SCHEMA_VERSION = 1
SIGNATURE = b"\x89HDF\r\n\x1a\n"  # first bytes of every HDF5 file
MAPS = ("nominal", "nominal_units", "writers")
"""Groups that hold their content as attributes."""

PARTS: dict[str, Any] = {
    "invariants": Invariants,
    "derivatives": "arrays",
    "affine": Polynomial,
    "interfaces": InterfacePoint,
    "stress": StressPoints,
    "shape": Shape,
    "mesh": Mesh,
}
"""Groups of the file; those that hold several named objects are `derivatives`, `affine` and `interfaces`."""
_NAMED = ("derivatives", "affine", "interfaces")


def load(path: str | Path, parts: Collection[str] = tuple(PARTS)) -> ReducedModel:
    """Read a reduced model, only the named parts of it (`invariants` always).

    Raises
    ------
    ModelFileError
        The file is missing, no HDF5 file, foreign, of another schema version, incomplete, its parts disagree, or its numbers are
        not physical.
    """
    path = Path(path)
    _check_signature(path)
    try:
        with h5py.File(path, "r") as file:
            _check_schema(file, path)
            content = {name: _read_part(file, name, path) for name in PARTS if name in parts or name == "invariants"}
            attributes: dict[str, Any] = {
                f.name: _plain(file.attrs[f.name]) for f in fields(ReducedModel) if f.name in file.attrs
            }
            missing = [f.name for f in fields(ReducedModel)[:8] if f.name not in (*attributes, *(set(MAPS) & set(file)))]
            if missing:
                raise ModelFileError(f"{str(path)!r} lacks {', '.join(missing)}. Build it again with ffrf-preprocess.")
            maps: dict[str, Any] = {name: {k: _plain(v) for k, v in file[name].attrs.items()} for name in MAPS}
        model = ReducedModel(**attributes, **maps, **content, path=path)
        check(model, path)
    except ModelFileError:
        raise
    except (OSError, KeyError, RuntimeError, ValueError, TypeError, AttributeError, OverflowError) as error:
        raise ModelFileError(
            f"{str(path)!r} cannot be read as a reduced model: it is damaged or incomplete. Build it again with ffrf-preprocess."
        ) from error
    return model


def is_reduced_model(path: str | Path) -> bool:
    """Whether a file calls itself a reduced model, of whatever schema version and even if parts of it are missing."""
    try:
        with h5py.File(path, "r") as file:
            return bool(file.attrs.get("schema") == SCHEMA)
    except (OSError, RuntimeError, ValueError):
        return False


def _check_signature(path: Path) -> None:
    """Say plainly what HDF5 would report in the words of its developers."""
    try:
        with path.open("rb") as file:
            start = file.read(len(SIGNATURE))
    except (FileNotFoundError, ValueError):  # ValueError: a zero byte in the name
        raise ModelFileError(
            f"there is no reduced model {str(path)!r}. Mend the path; a missing model is built with ffrf-preprocess."
        ) from None
    except OSError as error:
        raise ModelFileError(
            f"{str(path)!r} cannot be read ({error.strerror}). Give a reduced model, a file written by ffrf-preprocess."
        ) from error
    if start != SIGNATURE:
        raise ModelFileError(
            f"{str(path)!r} is not an HDF5 file and so not a reduced model. Give a file written by ffrf-preprocess."
        )


def _check_schema(file: h5py.File, path: Path) -> None:
    schema, version = file.attrs.get("schema"), file.attrs.get("schema_version")
    if schema != SCHEMA:
        raise ModelFileError(
            f"{str(path)!r} is an HDF5 file but not a reduced model: its attribute 'schema' is {schema!r}, not {SCHEMA!r}. "
            "Give a file written by ffrf-preprocess."
        )
    if version != SCHEMA_VERSION:
        raise ModelFileError(
            f"{str(path)!r} has schema version {version}, this program reads version {SCHEMA_VERSION}. "
            "Build it again with the ffrf-preprocess of this version."
        )


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _write(group: h5py.Group, name: str, value: Any) -> None:
    if value is None:
        return
    if isinstance(value, (str, int, float)):
        group.attrs[name] = value
    elif isinstance(value, np.ndarray):
        options = {"compression": "gzip", "shuffle": True} if value.size > 64 else {}
        group.create_dataset(name, data=value, **options)
    else:
        below = group.create_group(name, track_order=True)
        items = value.items() if isinstance(value, Mapping) else ((f.name, getattr(value, f.name)) for f in fields(value))
        for key, item in items:
            _write(below, key, item)


def _read_part(file: h5py.File, name: str, path: Path) -> Any:
    if name not in file:
        if name == "invariants":
            raise ModelFileError(f"{str(path)!r} has no group 'invariants'. Build it again with ffrf-preprocess.")
        return None
    kind, group = PARTS[name], file[name]
    if name in _NAMED:
        return {key: _read_object(kind, group[key], path) for key in group}
    return _read_object(kind, group, path)


def _read_object(kind: Any, group: h5py.Group, path: Path) -> Any:
    names = list(group) if kind == "arrays" else [f.name for f in fields(kind)]
    arrays = {}
    for name in names:
        if name not in group:
            raise ModelFileError(
                f"{str(path)!r}: group {group.name!r} lacks the dataset {name!r}. Build it again with ffrf-preprocess."
            )
        arrays[name] = np.asarray(group[name][()])
    return arrays if kind == "arrays" else kind(**arrays)


def save(model: ReducedModel, path: str | Path) -> None:
    """Write the file under a temporary name, then rename it: an interrupted run leaves the old file or none."""
    path = Path(path)
    check(model, path)
    with replaced(path) as temporary, h5py.File(temporary, "w") as file:
        file.attrs.update({"schema": SCHEMA, "schema_version": SCHEMA_VERSION})
        for item in fields(model):
            if item.name != "path":
                _write(file, item.name, getattr(model, item.name))
