"""From frame.toml to the reduced model."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from preprocessing.input.at_key import at_key
from preprocessing.input.input_files import origin
from preprocessing.recipes.frame.frame_design import changed_frame, frame_elements, frame_space
from preprocessing.recipes.frame.frame_file import read_frame_file
from preprocessing.recipes.skin.build import WRITER_VERSION
from preprocessing.recipes.skin.geometry import Remark
from preprocessing.reduction.reduced import reduce
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.file import SCHEMA_VERSION
from toolkit.reduced_model.model import ReducedModel

STOCKY = 1.5
"""Width of a rectangle in parts of its thickness below which the polynomial for its torsion is off by more than 1.3 %."""


def build_frame(
    path: str | Path,
    remark: Remark | None = None,
    values: Mapping[str, float] | None = None,
    keys: Mapping[str, Any] | None = None,
) -> ReducedModel:
    """Build the reduced model that frame.toml describes.

    Parameters
    ----------
    path : str or Path
        frame.toml.
    remark : callable
        Called with every section whose torsion is only roughly known, in words.
    values : parameter -> value
        Another design than that of the file, see `frame_design`.
    keys : key -> value
        Other keys than those of the file, for example {"basis": {...}}.

    Raises
    ------
    InputError
        The file is missing or cannot be meant; the message names the key.
    """
    path, values, keys = Path(path), values or {}, keys or {}
    file = changed_frame(read_frame_file(path), values, keys, path)
    space, clamp = frame_space(file), file.clamp or []
    for name, section in file.sections.items():
        sides = sorted([section.thickness or 0.0, section.width or 0.0])
        if remark is not None and section.kind == "rectangle" and sides[1] < STOCKY * sides[0]:
            remark(
                f"{path.name}: the torsion constant of the stocky rectangle {name} is up to 12 % too low. State it as a general section."
            )
    with at_key(path, "basis"):
        clamped = [list(file.nodes).index(node) for node in clamp]
        found = reduce(space, file.basis.choice(), clamped, ("the node " if len(clamp) == 1 else "the nodes ") + ", ".join(clamp))
    return ReducedModel(
        **found.fields(file.units),
        input_hash=frame_hash(path, {**values, **keys}),
        **origin(path, [], values),
        writers={"ffrf-toolkit": WRITER_VERSION, "numpy": np.__version__},
        surface=frame_elements(file, space.values).surface(found.basis.z, space.values),
    )


def frame_hash(path: Path, changes: Mapping[str, Any] | None = None) -> str:
    """SHA-256 of all that the result depends on: frame.toml, changes, schema and writer version.

    Raises
    ------
    InputError
        The file cannot be read.
    """
    digest = hashlib.sha256(f"frame, schema {SCHEMA_VERSION}, writer {WRITER_VERSION}".encode())
    try:
        digest.update(path.read_bytes())
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be read ({error.strerror}). Mend the path.") from error
    if changes:
        digest.update(repr(sorted(changes.items())).encode())
    return digest.hexdigest()
