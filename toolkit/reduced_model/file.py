"""The HDF5 file of a reduced model: written in one stroke, read part by part, never trusted."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import numpy as np

from toolkit.foundation.errors import ModelFileError
from toolkit.foundation.files.hdf5 import SIGNATURE, Content, reading, schema_of, text_of, write_array, writing
from toolkit.foundation.files.safe_files import meant_path, read_start
from toolkit.reduced_model.check import check
from toolkit.reduced_model.composition import Attributes
from toolkit.reduced_model.dependence import Derivatives, SparsePolynomial
from toolkit.reduced_model.model import InterfacePoint, Invariants, Mesh, Outline, ReducedModel, Shape, StressPoints
from toolkit.reduced_model.parts import (
    BeamSections,
    Elements,
    Interior,
    LeftOutShapes,
    PieceLoads,
    Pieces,
    SpatialElements,
    SpatialInvariants,
    Spin,
    Surface,
    SurfaceLoad,
)
from toolkit.reduced_model.shapes import Part

if TYPE_CHECKING:
    import h5py

P = TypeVar("P", bound=Part)
Group: TypeAlias = Part | dict[str, Part] | None
"""What a group of the file holds: an object, objects by name, or nothing."""

SCHEMA = "ffrf-reduced-model"
SCHEMA_VERSION = 3
WITHOUT_SECTIONS = 2
"""The version before, which is the same but for the sections of beams; files of bodies without beams are read as they are."""
ATTRIBUTES = ("dimension", "units", "reference_condition", "basis", "input_hash")
MAPS = ("nominal", "nominal_units", "writers")
"""Groups that hold their content as attributes."""
ORIGIN = ("inputs", "source", "changes")
"""The same, which a model has that was built from files."""
JUDGED = ("stress_errors", "stress_error_at", "face_errors")
"""The same, which a model has whose mesh was judged, or the faces between its pieces."""
OPTIONAL = (*ORIGIN, *JUDGED, "left_out", "composition")

_WHOLE = "factor power term entry parameter element end fibre modulus connectivity edges triangles lines held"
WHOLE = frozenset(_WHOLE.split())
"""Arrays of numbers of something, and of powers."""

PARTS: dict[str, Any] = {
    "invariants": Invariants,
    "derivatives": Derivatives,
    "affine": SparsePolynomial,
    "interfaces": InterfacePoint,
    "stress": StressPoints,
    "shape": Shape,
    "mesh": Mesh,
    "outline": Outline,
    "interior": Interior,
    "elements": Elements,
    "element_derivatives": Derivatives,
    "element_affine": SparsePolynomial,
    "sections": BeamSections,
    "section_derivatives": Derivatives,
    "section_affine": SparsePolynomial,
    "surface": Surface,
    "surface_loads": SurfaceLoad,
    "spin": Spin,
    "left_out_shapes": LeftOutShapes,
    "pieces": Pieces,
    "piece_loads": PieceLoads,
    "richer_invariants": Invariants,
    "richer_derivatives": Derivatives,
    "richer_affine": SparsePolynomial,
    "richer_interfaces": InterfacePoint,
    "richer_shape": Shape,
    "richer_spin": Spin,
    "richer_surface_loads": SurfaceLoad,
}
"""Groups of the file; those in `NAMED` hold several named objects."""
SPATIAL_PARTS: dict[str, Any] = {
    "invariants": SpatialInvariants,
    "elements": SpatialElements,
    "richer_invariants": SpatialInvariants,
}
"""Classes of the parts in space, where they differ from those in the plane."""
_NAMED = "derivatives affine interfaces surface_loads element_derivatives element_affine piece_loads section_derivatives section_affine"
NAMED = (*_NAMED.split(), "richer_derivatives", "richer_affine", "richer_interfaces", "richer_surface_loads")


def load(path: str | Path, parts: Collection[str] = tuple(PARTS), known: ReducedModel | None = None) -> ReducedModel:
    """Read a reduced model, only the named parts of it (`invariants` always).

    Parameters
    ----------
    known : what was read of the same file before; its parts are kept and not read again, unless the file is another one now

    Raises
    ------
    ModelFileError
        The file is missing, no HDF5 file, foreign, of another schema version, incomplete, its parts disagree, or its numbers are
        not physical.
    """
    path = Path(path)
    _check_signature(path)
    with reading(path, partial(_damaged, path), foreign=True) as content:
        attributes: dict[str, Any] = content.attributes()
        _check_schema(attributes, content, path)
        head = _head(content, attributes)
        if known and any(getattr(known, name) != value for name, value in head.items()):
            known = None
        before = known.bytes_read if known else {}
        found = {name: getattr(known, name) for name in before}
        wanted = [name for name in PARTS if name not in found and name in ("invariants", *parts)]
        found |= {name: _read_part(content, name, head["dimension"]) for name in wanted}
        found = _complete(str(attributes.get("contents", "")), found)
        plain = content.plain
        read = before | {name: content.bytes_read.get(name, 0) for name in wanted}
    model = ReducedModel(**head, **found, inputs_from=path.parent, path=path, bytes_read=read, plain=plain)
    check(model, path, before)
    return model


def _head(content: Content, attributes: Attributes) -> dict[str, Any]:
    """All that a file holds as attributes; `attributes` are those of its root."""
    if lacking := [name for name in ATTRIBUTES if name not in attributes]:
        raise ValueError(f"it lacks {', '.join(lacking)}")
    head: dict[str, Any] = {name: attributes[name] for name in ATTRIBUTES} | {name: content.attributes(name) for name in MAPS}
    head["dimension"] = _whole(head["dimension"])
    head["nominal"] = _numbered(head["nominal"], attributes.get("parameters"), content.in_order("nominal"))
    units = head["nominal_units"]
    head["nominal_units"] = {name: units[name] for name in [*head["nominal"], *units] if name in units}
    return head | {name: content.attributes(name) for name in OPTIONAL if content.has(name)}


def stored_bytes(path: str | Path) -> dict[str, int]:
    """Bytes that the arrays of each group take in the file, without reading them.

    Raises
    ------
    ModelFileError
        The file is missing or damaged.
    """
    path = Path(path)
    _check_signature(path)
    with reading(path, partial(_damaged, path), foreign=True) as content:
        return {name: content.stored_bytes(name) for name in PARTS if content.has(name)}


def _contents(model: Mapping[str, Any]) -> list[str]:
    """Names of all named objects; without one of them a model would seem not to depend on a parameter."""
    return [f"{part}/{name}" for part in NAMED for name in model.get(part) or {}]


def _complete(contents: str, found: Mapping[str, Any]) -> dict[str, Any]:
    """Parts that were found, with their named objects in the order of the list of contents.

    Raises
    ------
    ValueError
        An object is missing, or is not listed.
    """
    listed = [name for name in contents.splitlines() if found.get(name.split("/")[0]) is not None]
    if lacking := sorted(set(listed) ^ set(_contents(found))):
        raise ValueError(f"its list of contents and its groups differ by {', '.join(lacking)}")
    order = {
        part: [name.partition("/")[2] for name in listed if name.startswith(f"{part}/")] for part in NAMED if found.get(part)
    }
    others = {part: names for part, names in order.items() if names != [*found[part]]}  # what is in order stays the same object
    return dict(found) | {part: {name: found[part][name] for name in names} for part, names in others.items()}


def _numbered(nominal: Attributes, listed: str | int | float | None, in_order: bool) -> Attributes:
    """Parameters in the order by which polynomials and derivatives number them: as listed in the file, or else as written."""
    if listed is None and (in_order or len(nominal) < 2):
        return nominal
    if listed is None:
        raise ValueError(
            "it does not say in which order its parameters count: write their names, one a line, as the attribute parameters of the root"
        )
    names = [name for name in str(listed).split("\n") if name]
    if sorted(names) != sorted(nominal):
        differing = sorted(set(names) ^ set(nominal)) or ["names that are there twice"]
        raise ValueError(f"its list of parameters and nominal/ differ by {', '.join(differing)}")
    return {name: nominal[name] for name in names}


def _whole(value: str | int | float) -> str | int | float:
    """Whole number as an int, also where a program writes all its numbers as floating-point ones; anything else as it is."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def is_reduced_model(path: str | Path) -> bool:
    """Whether a file calls itself a reduced model, of whatever schema version and even if parts of it are missing."""
    return schema_of(Path(path)) == SCHEMA


def described_by(path: str | Path) -> list[str]:
    """File that describes the body of a reduced model, relative to the model's folder; empty if the model does not name it."""
    path = Path(path)
    try:
        with reading(path, partial(_damaged, path), foreign=True) as content:
            found = {name: content.attributes(name) if content.has(name) else {} for name in ORIGIN}
    except ModelFileError:
        return []
    texts = {Path(name).name for name in found["source"]}
    return [name for name in found["inputs"] if Path(name).name in texts]


def hash_of(path: str | Path) -> str:
    """Hash of the inputs of a reduced model; empty if it has none."""
    return text_of(Path(path), "input_hash") or ""


def _damaged(path: Path, reason: str) -> ModelFileError:
    return ModelFileError(
        f"{str(path)!r} cannot be read as a reduced model: it is damaged or incomplete ({reason}). Build it again with "
        "ffrf-preprocess."
    )


def _check_signature(path: Path) -> None:
    """Refuse a file that is missing, cannot be read, or is no HDF5 file, before HDF5 reports it in its own words."""
    try:
        start = read_start(path, len(SIGNATURE))
    except FileNotFoundError as error:
        raise ModelFileError(
            f"there is no reduced model {str(path)!r}{meant_path(path, error)}. Fix the path; a missing model is built with "
            "ffrf-preprocess."
        ) from None
    except OSError as error:
        raise ModelFileError(
            f"{str(path)!r} cannot be read ({error.strerror}). Give a reduced model, a file written by ffrf-preprocess."
        ) from error
    if start != SIGNATURE:
        raise ModelFileError(
            f"{str(path)!r} is not an HDF5 file and so not a reduced model. Give a file written by ffrf-preprocess."
        )


def _check_schema(attributes: Attributes, content: Content, path: Path) -> None:
    schema, version = attributes.get("schema"), attributes.get("schema_version")
    if schema != SCHEMA:
        raise ModelFileError(
            f"{str(path)!r} is an HDF5 file but not a reduced model: its attribute 'schema' is not {SCHEMA!r}. "
            "Give a file written by ffrf-preprocess."
        )
    if version == WITHOUT_SECTIONS and not (content.has("mesh") or (content.has("elements") and not content.has("pieces"))):
        return
    if version != SCHEMA_VERSION:
        lacks = ": it does not hold the sections of its beams" if version == WITHOUT_SECTIONS else ""
        raise ModelFileError(
            f"{str(path)!r} has schema version {version}, this program reads version {SCHEMA_VERSION}{lacks}. "
            "Build it again with the ffrf-preprocess of this version."
        )


def _write(group: h5py.Group, name: str, value: Group | np.ndarray | Attributes | str | float) -> None:
    if value is None:
        return
    if isinstance(value, (str, int, float)):
        group.attrs[name] = np.bytes_(value.encode()) if isinstance(value, str) else value
    elif isinstance(value, np.ndarray):
        write_array(group, name, value)
    else:
        below = group.create_group(name, track_order=True)
        items = value.items() if isinstance(value, Mapping) else ((f.name, getattr(value, f.name)) for f in fields(value))
        for key, item in items:
            _write(below, key, item)


def _read_part(content: Content, name: str, dimension: int) -> Group:
    if name != "invariants" and not content.has(name):
        return None
    kind = SPATIAL_PARTS.get(name, PARTS[name]) if dimension == 3 else PARTS[name]
    if name in NAMED:
        return {key: _read_object(kind, content, f"{name}/{key}") for key in content.group(name)}
    return _read_object(kind, content, name)


def _read_object(kind: type[P], content: Content, group: str) -> P:
    return kind(**{f.name: _array(content, group, f.name) for f in fields(kind)})


def _array(content: Content, group: str, name: str) -> np.ndarray:
    """Array of a group; counts and numbers become whole, also where a program writes them as floating-point numbers."""
    values = content.array(f"{group}/{name}")
    if content.plain and name in WHOLE and values.dtype.kind == "f":
        if not np.array_equal(values, np.rint(values)):
            raise ValueError(f"{group}/{name} holds numbers that are no whole ones")
        return values.astype(np.int64)
    return values


def save(model: ReducedModel, path: str | Path) -> None:
    """Write a reduced model into a file in one stroke: an interrupted run leaves the old file or none."""
    path = Path(path)
    model = _seen_from(path.parent, model)
    check(model, path)
    with writing(path) as file:
        file.attrs.update({"schema": np.bytes_(SCHEMA.encode()), "schema_version": SCHEMA_VERSION})
        file.attrs["parameters"] = np.bytes_("\n".join(model.nominal).encode())
        file.attrs["contents"] = np.bytes_("\n".join(_contents(vars(model))).encode())
        for item in fields(model):
            if item.compare and not (item.name in OPTIONAL and not getattr(model, item.name)):
                _write(file, item.name, getattr(model, item.name))


def _seen_from(folder: Path, model: ReducedModel) -> ReducedModel:
    """Model with the names of its inputs relative to a folder; unchanged where no path leads from there to them."""
    if model.inputs_from is None or model.inputs_from.resolve() == folder.resolve():
        return model
    origin = model.inputs_from.resolve()
    try:
        names = {name: Path(os.path.relpath(origin / name, folder.resolve())).as_posix() for name in model.inputs}
    except ValueError:  # another drive
        return model
    renamed: dict[str, Any] = {name: {names[k]: v for k, v in getattr(model, name).items()} for name in ("inputs", "source")}
    return replace(model, **renamed, inputs_from=folder)
