"""The file that a reduced model is built from, a skin.toml, body.toml or frame.toml: which of them it is decides who reads it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from preprocessing.recipes.frame.build_frame import build_frame, frame_hash
from preprocessing.recipes.frame.frame_design import changed_frame
from preprocessing.recipes.frame.frame_file import is_frame, read_frame_file
from preprocessing.recipes.skin.build import build, file_at, input_hash
from preprocessing.recipes.skin.changed_keys import changed_tables
from preprocessing.recipes.skin.geometry import Remark
from preprocessing.recipes.skin.skin_file import read_skin_file
from preprocessing.recipes.skin.skin_tables import Table
from preprocessing.recipes.solids.body_file import is_body, read_body_file
from preprocessing.recipes.solids.changed_body import changed_body
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.toml_file import read_toml
from toolkit.reduced_model.model import ReducedModel


class Source(NamedTuple):
    """What a file that describes a flexible body names, and how it is built."""

    inputs: list[Path]  # the file itself, and those that it names
    file: Any
    hash: Callable[[Mapping[str, Any]], str]  # of all inputs and of changes
    build: Callable[[Remark | None, Mapping[str, float], Mapping[str, Any]], ReducedModel]
    at: Callable[[Mapping[str, float], Mapping[str, Any]], Table]  # the file with other values and keys
    parts: tuple[str, ...]  # groups that a complete reduced model of it has


def source(path: Path) -> Source:
    """The file that describes a flexible body.

    Raises
    ------
    InputError
        It is missing, or none of skin.toml, body.toml and frame.toml.
    """
    content = read_toml(path, "a skin.toml, body.toml or frame.toml")
    if is_frame(content):
        return _frame(path)
    if is_body(content):
        body, solids = read_body_file(path), _solids()
        return Source(
            [path, *solids.body_inputs(path, body)],
            body,
            lambda changes: solids.body_hash(path, body, changes),
            lambda _, values, keys: solids.build_body(path, values, keys),
            lambda values, keys: changed_body(body, values, keys, path),
            ("invariants", "derivatives", "affine", "interfaces", "stress"),
        )
    skin = read_skin_file(path)
    return Source(
        [path, *(path.parent / name for name in (skin.airfoil.file, skin.airfoil.target))],
        skin,
        lambda changes: input_hash(path, skin, changes),
        lambda remark, values, keys: build(path, remark, values, keys),
        lambda values, keys: file_at(path, values, keys),
        ("invariants", "derivatives", "affine", "interfaces", "stress", "shape", "mesh" if skin.dimension == 2 else "surface"),
    )


def _frame(path: Path) -> Source:
    frame = read_frame_file(path)
    return Source(
        [path],
        frame,
        lambda changes: frame_hash(path, changes),
        lambda remark, values, keys: build_frame(path, remark, values, keys),
        lambda values, keys: changed_frame(frame, values, keys, path),
        ("invariants", "derivatives", "affine", "interfaces", "stress", "surface"),
    )


def _solids() -> Any:
    """The preprocessing of solids, loaded where a body needs it: scikit-fem takes a second."""
    try:
        return import_module("preprocessing.recipes.solids.build_body")
    except ImportError as error:
        raise InputError(
            f"meshed bodies need scikit-fem, which cannot be loaded ({error}). Install it with: pip install "
            "'ffrf-toolkit[preprocessing]'."
        ) from error


def tables_changed(described: Source, values: Mapping[str, float], keys: Mapping[str, Any]) -> dict[str, Any]:
    """Tables of the file that other keys change."""
    return changed_tables(described.file, described.at(values, keys)) if keys else {}
