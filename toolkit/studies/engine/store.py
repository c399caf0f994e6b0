"""Stores of outcomes: many designs of a study in one file, or one file for each long run.

All files are replaced as a whole: a process that is killed loses what was solved in the last moment. That is solved again and gives the
same numbers, because they follow from what the store holds.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import asdict
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
from pydantic import TypeAdapter

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.hdf5 import Content, reading, schema_of, write_array, writing
from toolkit.foundation.files.locked_file import locked
from toolkit.foundation.files.replaced_file import write_whole
from toolkit.studies.engine.outcome import EMPTY, DesignKey, DesignOutcome, RunOutcome, State

SCHEMA, SCHEMA_VERSION = "ffrf-study", 1
Result = TypeVar("Result", bound=RunOutcome)
SHARE = 10
"""So many times as long as a writing takes nothing is written after it."""


class StudyFileError(InputError):
    """A store is damaged, or belongs to another study."""


class DesignStore:
    """Designs of a study in one file, in the order in which they were solved; a run that adds some takes `opened_store`.

    Parameters
    ----------
    path
        The file; None keeps them in memory alone.
    key
        Hash of what the numbers follow from: study, scene, models, program.
    """

    def __init__(self, path: Path | None = None, key: str = "") -> None:
        self.path, self.key = path, key
        self._known: dict[DesignKey, DesignOutcome] = {}
        self._next = 0.0
        self._pending = False
        if path is not None and path.exists():
            self._read(path)
        self.found = len(self._known)
        """Designs that were there already."""

    def __len__(self) -> int:
        return len(self._known)

    def __iter__(self) -> Iterator[DesignOutcome]:
        return iter(self._known.values())

    def of(self, lane: int) -> list[DesignOutcome]:
        """Designs of one search, in the order in which they were solved."""
        return [each for each in self if each.lane == lane]

    def find(self, key: DesignKey) -> DesignOutcome | None:
        """The design of a search, to the bit; None if it is not known."""
        return self._known.get(key)

    def keep(self, key: DesignKey, found: DesignOutcome) -> None:
        """Add a design; the file is written unless it was a moment ago."""
        self._known[key] = found
        self._pending = True
        if time.monotonic() > self._next:
            self.write()

    def write(self) -> None:
        """Put what is known into the file."""
        if self.path is None or not self._pending:
            return
        begun = time.monotonic()
        with writing(self.path) as file:
            file.attrs.update({"schema": np.bytes_(SCHEMA.encode()), "schema_version": SCHEMA_VERSION})
            file.attrs["key"] = np.bytes_(self.key.encode())
            for name, values in _columns(list(self)).items():
                write_array(file, name, values)
        ended = time.monotonic()
        self._next, self._pending = ended + SHARE * (ended - begun), False

    def _read(self, path: Path) -> None:
        if schema_of(path) != SCHEMA:
            raise StudyFileError(
                f"{str(path)!r} is no store of a study, and is left as it is. Give another folder with --output."
            )
        with reading(path, lambda reason: _damaged(path, reason)) as content:
            about = content.attributes()
            if about.get("schema_version") != SCHEMA_VERSION or about.get("key") != self.key:
                raise StudyFileError(
                    f"{str(path)!r} belongs to another study, or to this one before its file, its scene, a model or the program changed. "
                    "Give another folder with --output, or delete the file."
                )
            self._known = {each.key: each for each in _outcomes(content)}


@contextmanager
def opened_store(path: Path | None, key: str) -> Iterator[DesignStore]:
    """The store of a run, which no other run works with meanwhile; whatever happens, what is known is written.

    Raises
    ------
    InputError
        Another run works with it, it is damaged, or it belongs to another study.
    """
    with nullcontext() if path is None else locked(path):
        store = DesignStore(path, key)
        try:
            yield store
        finally:
            store.write()


def _damaged(path: Path, reason: str) -> StudyFileError:
    return StudyFileError(f"{str(path)!r} is damaged: {reason}. Delete it, and begin again.")


def _columns(found: list[DesignOutcome]) -> dict[str, np.ndarray]:
    """Arrays with one row for each design; those of states and values have one for each that did not fail."""
    good = [each for each in found if not each.failed]
    columns = {
        "lane": np.array([each.lane for each in found], np.int64),
        "design": np.array([each.design for each in found]),
        "failed": np.array([each.failed for each in found], np.int64),
        "wall": np.array([each.seconds for each in found]),
        "reason": np.array([each.reason.encode() or b" " for each in found]),
    }
    if good:
        columns["values"] = np.array([each.values for each in good])
        columns["gradients"] = np.array([each.gradients for each in good])
        columns["curvatures"] = np.array([each.curvatures for each in good])
        for place in range(len(good[0].states)):
            columns[f"q{place}"] = np.array([each.states[place].q for each in good])
            columns[f"multipliers{place}"] = np.array([each.states[place].multipliers for each in good])
    return {name: array for name, array in columns.items() if array.size}


def _outcomes(content: Content) -> Iterator[DesignOutcome]:
    lane, design, failed, wall, reason = (content.array(name) for name in ("lane", "design", "failed", "wall", "reason"))
    count = int(np.sum(failed == 0))
    values, gradients = (content.array(name) if count else EMPTY for name in ("values", "gradients"))

    def column(name: str) -> np.ndarray:
        """What only some studies have, with one row for each design that did not fail."""
        return content.array(name) if content.has(name) else np.zeros((count, 0))

    cases, curvatures = values.shape[1] if content.has("q0") else 0, column("curvatures")
    states = [tuple(column(f"{name}{k}") for name in State._fields) for k in range(cases)]
    rows = iter(range(count))
    for k in range(len(lane)):
        about: dict[str, Any] = {"lane": int(lane[k]), "design": design[k], "seconds": float(wall[k])}
        if failed[k]:
            yield DesignOutcome(**about, reason=reason[k].decode())
            continue
        row = next(rows)
        mine = tuple(State(q[row], multipliers[row]) for q, multipliers in states)
        yield DesignOutcome(**about, values=values[row], gradients=gradients[row], states=mine, curvatures=curvatures[row])


class RunFolder(Generic[Result]):
    """Outcomes of long runs in a folder, one JSON file each.

    The name of a file is the fingerprint of all that its outcome follows from. Files of a scene, a model or a program that has changed
    since are never read again; they may be deleted at any time.

    Parameters
    ----------
    folder
        It is made where there is none; None keeps nothing.
    kind
        Class of the outcomes.
    """

    def __init__(self, folder: Path | None, kind: type[Result]) -> None:
        self.folder, self._adapter = folder, TypeAdapter(kind)
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)

    def find(self, key: str) -> Result | None:
        """The outcome of a key; None if there is none, or its file is damaged."""
        if self.folder is None:
            return None
        try:
            return self._adapter.validate_python(json.loads((self.folder / f"{key}.json").read_bytes()))
        except (OSError, ValueError):
            return None

    def keep(self, key: str, found: Result) -> None:
        """Write an outcome in one stroke."""
        if self.folder is not None:
            write_whole(self.folder / f"{key}.json", json.dumps(asdict(found), default=float, indent=1).encode())
