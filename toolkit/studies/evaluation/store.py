"""All designs of a study in one file, which is replaced as a whole: whoever is killed loses what was solved in the last moment.

What was lost is solved again and gives the same numbers, because they follow from what the file holds.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.hdf5 import Content, reading, schema_of, write_array, writing
from toolkit.foundation.files.locked_file import locked
from toolkit.studies.evaluation.evaluation import Evaluation, State

SCHEMA, SCHEMA_VERSION = "ffrf-study", 1
SHARE = 10
"""So many times as long as a writing takes nothing is written after it."""


class StudyFileError(InputError):
    """A store is damaged, or belongs to another study."""


class Store:
    """Designs in the order in which they were solved; a run that adds some takes `opened_store`.

    Parameters
    ----------
    path
        The file; None keeps them in memory alone.
    key
        Hash of what the numbers follow from: study, scene, models, program.
    """

    def __init__(self, path: Path | None = None, key: str = "") -> None:
        self.path, self.key = path, key
        self._all: list[Evaluation] = []
        self._by: dict[tuple[int, bytes], Evaluation] = {}
        self._next = 0.0
        self._pending = False
        if path is not None and path.exists():
            self._read(path)
        self.found = len(self._all)
        """Designs that were there already."""

    def __len__(self) -> int:
        return len(self._all)

    def __iter__(self) -> Iterator[Evaluation]:
        return iter(self._all)

    def of(self, lane: int) -> list[Evaluation]:
        """Designs of one search, in the order in which they were solved."""
        return [each for each in self._all if each.lane == lane]

    def find(self, lane: int, design: np.ndarray) -> Evaluation | None:
        """The design of a search, to the bit."""
        return self._by.get((lane, design.tobytes()))

    def keep(self, found: Evaluation) -> None:
        """Add a design; the file is written unless it was a moment ago."""
        self._add(found)
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
            for name, values in _columns(self._all).items():
                write_array(file, name, values)
        ended = time.monotonic()
        self._next, self._pending = ended + SHARE * (ended - begun), False

    def _add(self, found: Evaluation) -> None:
        self._all.append(found)
        self._by[found.lane, found.design.tobytes()] = found

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
            for each in _evaluations(content):
                self._add(each)


@contextmanager
def opened_store(path: Path | None, key: str) -> Iterator[Store]:
    """The store of a run, which no other run works with meanwhile; whatever happens, what is known is written.

    Raises
    ------
    InputError
        Another run works with it, it is damaged, or it belongs to another study.
    """
    with nullcontext() if path is None else locked(path):
        store = Store(path, key)
        try:
            yield store
        finally:
            store.write()


def _damaged(path: Path, reason: str) -> StudyFileError:
    return StudyFileError(f"{str(path)!r} is damaged: {reason}. Delete it, and begin again.")


def _columns(found: list[Evaluation]) -> dict[str, np.ndarray]:
    """Arrays with one row for each design; those of states and values have one for each that did not fail."""
    good = [each for each in found if not each.failed]
    columns = {
        "lane": np.array([each.lane for each in found], np.int64),
        "design": np.array([each.design for each in found]),
        "failed": np.array([each.failed for each in found], np.int64),
        "wall": np.array([each.wall for each in found]),
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


def _evaluations(content: Content) -> Iterator[Evaluation]:
    lane, design, failed, wall = (content.array(name) for name in ("lane", "design", "failed", "wall"))
    reason, none = content.array("reason"), np.zeros(0)
    some = not np.all(failed)
    values, gradients = (content.array(name) if some else none for name in ("values", "gradients"))
    curvatures = content.array("curvatures") if content.has("curvatures") else np.zeros((len(values), 0))
    cases = values.shape[1] if some else 0
    states = [
        tuple(content.array(f"{name}{k}") if content.has(f"{name}{k}") else np.zeros((len(values), 0)) for name in State._fields)
        for k in range(cases if content.has("q0") else 0)
    ]
    row = 0
    for k in range(len(lane)):
        if failed[k]:
            yield Evaluation(int(lane[k]), design[k], reason[k].decode(), none, none, (), float(wall[k]))
            continue
        mine = tuple(State(q[row], multipliers[row]) for q, multipliers in states)
        yield Evaluation(int(lane[k]), design[k], "", values[row], gradients[row], mine, float(wall[k]), curvatures[row])
        row += 1
