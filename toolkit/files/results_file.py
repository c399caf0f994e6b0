"""The HDF5 file of results: written in one stroke, never trusted when it is read."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from toolkit.description import results_layout as layout
from toolkit.description.end_state import about_of, check_schema
from toolkit.description.results_layout import BODY, NAMES, SCHEMA, SCHEMA_VERSION, STATES, TEXTS, ResultsFileError, damaged
from toolkit.description.run_options import STARTS
from toolkit.files.results import BodyResults, Results, collect
from toolkit.foundation.errors import meant
from toolkit.foundation.files.hdf5 import Content, reading, schema_of, write_array, writing

if TYPE_CHECKING:
    import h5py

    from toolkit.analyses.sensitivity.run import Run


def save_results(run: Results | Run, path: str | Path, text: str = "", changes: Mapping[str, str] | None = None) -> Results:
    """Write the results of a run into one file, under a temporary name until it is complete.

    Parameters
    ----------
    run : what an analysis returned, or results collected before
    text : content of the scene's file, kept for the reader; the scene itself is kept in any case
    changes : path -> value that replaced the file's

    Returns
    -------
    what was written

    Raises
    ------
    ResultsFileError
        The folder does not exist, or the path is that of some other file.
    """
    path = Path(path)
    refuse_foreign(path)
    results = run if isinstance(run, Results) else collect(run, text, changes)
    if (start := results.settings.get("start")) not in (None, *STARTS):
        refuse_own_start(path, Path(results.scene.directory) / start)
    with writing(path) as file:
        file.attrs.update({"schema": np.bytes_(SCHEMA.encode()), "schema_version": SCHEMA_VERSION})
        for name in STATES:
            write_array(file, name, getattr(results, name))
        for body, found in results.bodies.items():
            for name in BODY:
                write_array(file, f"bodies/{body}/{name}", getattr(found, name))
        for name in NAMES:
            write_array(file, f"names/{name}", np.char.encode(np.array(getattr(results, name), "U"), "utf-8"))
        _write_gradients(file, results)
        for name, content in zip(TEXTS, (json.dumps(_about(results, path)), results.scene.text), strict=True):
            write_array(file, name, np.bytes_(content.encode()))
    return replace(results, path=path)


def refuse_foreign(path: Path) -> None:
    """Refuse to write where no results file belongs, before anything long begins."""
    if not path.parent.is_dir():
        raise ResultsFileError(f"there is no folder {str(path.parent)!r} for the results. Make it, or give another path.")
    if path.suffix != ".h5":
        raise ResultsFileError(f"{str(path)!r} does not end in .h5, as the name of a results file must. Add it.")
    if path.exists() and not (path.is_file() and schema_of(path) == SCHEMA):  # a pipe would be waited for
        raise ResultsFileError(f"{str(path)!r} exists and is not a results file; it is left as it is. Give another path.")


def refuse_own_start(path: Path, start: Path | None) -> None:
    """Refuse to write over the results that a run begins from: nobody could repeat the run."""
    if start is not None and path.resolve() == start.resolve():
        raise ResultsFileError(f"{str(path)!r} is the start of this run, which it would replace. Give another path.")


def _write_gradients(file: h5py.File, results: Results) -> None:
    """Responses and gradients as arrays too, for readers in other languages; the program itself reads `about`."""
    write_array(file, "responses/values", np.array(list(results.responses.values()), float))
    gradients = [list(slopes.values()) for slopes in results.gradients.values()]
    write_array(file, "responses/gradients", np.array(gradients, float))
    columns = {"names": results.responses, "units": results.response_units.values(), "variables": results.variables}
    for name, items in columns.items():
        write_array(file, f"responses/{name}", np.char.encode(np.array(list(items), "U"), "utf-8"))


def _about(results: Results, path: Path) -> dict[str, object]:
    """Record of all that is no array; the models' folder is relative to the file, so that a project can be moved."""
    arrays = {*STATES, *NAMES, "bodies", "path", "scene"}
    plain = {item.name: getattr(results, item.name) for item in fields(results) if item.name not in arrays}
    scene = asdict(results.scene) | {"directory": _relative(Path(results.scene.directory), path)}
    del scene["text"]
    return plain | {"scene": scene, "bodies": list(results.bodies)}


def _relative(directory: Path, path: Path) -> str:
    """Folder relative to a file's folder; unchanged if both share no root."""
    try:
        return Path(os.path.relpath(directory, path.parent)).as_posix()
    except ValueError:
        return directory.absolute().as_posix()


def load_results(path: str | Path) -> Results:
    """Read results.

    Raises
    ------
    ResultsFileError
        The file is missing, no HDF5 file, foreign, of another schema version, incomplete, or its arrays do not fit together.
    """
    path = Path(path)
    if not path.exists() and path.suffix != ".h5":
        found = sorted(path.parent.glob("*")) if os.path.isdir(path.parent) else []  # no error of its own for any path
        beside = [str(each) for each in found if each.suffix in (".toml", ".h5")]
        raise ResultsFileError(
            f"there is no file {str(path)!r}{meant(str(path), beside)}. A scene is a .toml file; results, which "
            f"ffrf simulate SCENE.toml --output {path.stem}.h5 keeps, are an .h5 file."
        )
    if not path.exists():
        raise ResultsFileError(
            f"there is no results file {str(path)!r}. Write one with: ffrf simulate SCENE.toml --output {path.name}."
        )
    if path.suffix == ".toml":
        raise ResultsFileError(
            f"{str(path)!r} holds no results, but is a text. Keep those of a scene in a file first: ffrf simulate {path} --output "
            f"{path.stem}.h5."
        )
    with reading(path, partial(damaged, path)) as content:
        check_schema(content.attributes(), path)
        return _read(content, path)


def _read(content: Content, path: Path) -> Results:
    about, sizes = about_of(content), dict[str, int]()
    words: dict[str, Any] = about.model_dump(exclude={"bodies", "scene", "variables"})
    words["variables"] = {name: each.model_dump(exclude_none=True) for name, each in about.variables.items()}
    arrays: dict[str, Any] = {name: layout.array(content, name, axes, sizes) for name, axes in STATES.items()}
    labels: dict[str, Any] = {name: layout.names(content, f"names/{name}", sizes[axis]) for name, axis in NAMES.items()}
    if not sizes["t"] or not set(labels["design"]) <= set(about.variables):
        raise ValueError("it holds no times, or derivatives by unknown variables")
    bodies = {}
    for body in about.bodies:
        own = {axis: size for axis, size in sizes.items() if axis not in "sk"}
        bodies[body] = BodyResults(**{n: layout.array(content, f"bodies/{body}/{n}", axes, own) for n, axes in BODY.items()})
    directory = str(path.parent / about.scene.directory)
    scene = replace(about.scene, text=layout.text(content, "scene_text"), directory=directory)
    return Results(**words, **arrays, **labels, bodies=bodies, scene=scene, path=path)
