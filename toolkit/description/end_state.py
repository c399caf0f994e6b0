"""The last state of a kept run, with its design derivatives, and what it is a state of."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path

import numpy as np

from toolkit.description import results_layout as layout
from toolkit.description.description import numbers_below
from toolkit.description.results_layout import READABLE, SCHEMA, STATES, About, ResultsFileError, damaged
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.hdf5 import Content, reading
from toolkit.foundation.value_types import TomlTable

GROUPS = ("points", "bodies", "joints", "loads")
"""Tables of a scene whose numbers can be design variables."""


@dataclass(frozen=True, eq=False)
class EndState:
    """Last state of a run, with its design derivatives and what it is a state of.

    Attributes
    ----------
    path
        The results file.
    q, v
        Coordinates and velocities (n_q,).
    dq, dv
        Their derivatives (n_q, n_c) by the variables that the run had.
    coordinates
        Names of the coordinates.
    columns
        For each of these variables the paths of the numbers that it drives, with its factors.
    units
        Unit system of the scene that was run.
    items
        Group and name of its points, bodies, joints and loads.
    numbers
        Path -> value of all numbers that it has written of them.
    bodies
        The tables of its bodies.
    models
        Path of each reduced model, as the scene writes it -> SHA-256 of its file.
    """

    path: Path
    q: np.ndarray
    v: np.ndarray
    dq: np.ndarray
    dv: np.ndarray
    coordinates: tuple[str, ...]
    columns: tuple[Mapping[str, float], ...]
    units: str
    items: frozenset[tuple[str, str]]
    numbers: Mapping[str, float]
    bodies: Mapping[str, TomlTable]
    models: Mapping[str, str]

    def has(self, path: str) -> bool:
        """Whether the scene that was run had the item that a number at a path belongs to."""
        group, name = path.split(".")[:2]
        return (group, name) in self.items


def end_state(path: Path) -> EndState:
    """Last state of the run in a results file, which is read once as long as it is the same file.

    Raises
    ------
    InputError
        There is no such file.
    ResultsFileError
        It is no results file, is damaged, or of another schema version.
    """
    if not path.is_file():
        raise InputError(
            f"solver.start names the results file {str(path)!r}, which is not there. Paths start from the scene's folder; write one with: "
            f"ffrf simulate SCENE.toml --output {path.name}."
        )
    found = path.stat()
    return _read_before(path, found.st_mtime_ns, found.st_size)


@lru_cache(maxsize=4)
def _read_before(path: Path, _changed: int, _size: int) -> EndState:
    with reading(path, partial(damaged, path)) as content:
        check_schema(content.attributes(), path)
        return _read(content, path)


def check_schema(attributes: Mapping[str, object], path: Path) -> None:
    """Refuse a file that is no results file, or one of another version.

    Raises
    ------
    ResultsFileError
        Names the file and what to do.
    """
    schema, version = attributes.get("schema"), attributes.get("schema_version")
    if schema != SCHEMA:
        raise ResultsFileError(
            f"{str(path)!r} is an HDF5 file but holds no results: its attribute 'schema' is not {SCHEMA!r}. "
            "Give a file written by ffrf simulate, statics or sensitivity with --output."
        )
    if version not in READABLE:
        raise ResultsFileError(
            f"{str(path)!r} has schema version {version}, this program reads {' and '.join(map(str, READABLE))}. "
            "Run the scene again with this version."
        )


def about_of(content: Content) -> About:
    """Record of all that a results file says in words. Raises ValueError if it is not what it should be."""
    return About.model_validate(json.loads(layout.text(content, "about")))


def _read(content: Content, path: Path) -> EndState:
    about, sizes = about_of(content), dict[str, int]()
    groups = _groups(about.scene.table)
    last = {name: layout.array(content, name, STATES[name], sizes)[-1:] for name in ("times", "q", "v", "dq", "dv")}
    if not sizes["t"]:
        raise ValueError("it holds no times")
    design = layout.names(content, "names/design", sizes["x"])
    if not set(design) <= set(about.variables):
        raise ValueError("it holds derivatives by unknown variables")
    states = {name: values[0].copy() for name, values in last.items() if name != "times"}
    for state in states.values():
        state.setflags(write=False)  # it is kept for all that ask for it
    return EndState(
        path,
        **states,
        coordinates=tuple(layout.names(content, "names/coordinates", sizes["q"])),
        columns=tuple(about.variables[name].shares for name in design),
        units=about.units,
        items=frozenset((group, name) for group, items in groups.items() for name in items),
        numbers=_numbers(groups),
        bodies={name: item for name, item in groups["bodies"].items() if isinstance(item, dict)},
        models=about.scene.models,
    )


def _groups(table: TomlTable) -> dict[str, TomlTable]:
    """Tables of a scene that can hold design variables, as far as they can be believed."""
    found = {group: items for group in GROUPS if isinstance(items := table.get(group, {}), dict)}
    if len(found) < len(GROUPS) or not all(isinstance(body, dict) for body in found["bodies"].values()):
        raise ValueError("its scene is none")
    return found


def _numbers(groups: Mapping[str, TomlTable]) -> dict[str, float]:
    found: dict[str, float] = {}
    for group, items in groups.items():
        for name, item in items.items():
            below = dict(zip("xyz", item, strict=False)) if group == "points" and isinstance(item, list) else item
            found |= {path: value for path, value in numbers_below(f"{group}.{name}", below) if isinstance(value, float)}
    return found
