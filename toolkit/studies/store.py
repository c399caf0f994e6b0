"""Outcomes of jobs, fingerprints of all that they follow from, and stores that keep them.

All files are replaced as a whole: a process that is killed loses what was solved in the last moment. That is solved again and gives the
same numbers, because they follow from what the store holds.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import asdict, dataclass, field
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from pydantic import TypeAdapter

import toolkit
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.hdf5 import Content, reading, schema_of, write_array, writing
from toolkit.foundation.files.safe_files import locked, write_whole
from toolkit.scene.scene import Scene

DesignKey = tuple[int, bytes]
"""What a design is kept under: the number of the search that asked for it, and the design to the bit."""
EMPTY = np.zeros(0)
"""Numbers that do not exist."""


@dataclass(frozen=True, kw_only=True)
class JobOutcome:
    """What became of a job.

    Attributes
    ----------
    values, gradients
        Of the responses; empty if the job failed.
    reason
        Why it failed; empty if it did not.
    seconds
        Time that it took; nothing follows from it.
    """

    values: Any
    gradients: Any
    reason: str = ""
    seconds: float = 0.0

    @property
    def failed(self) -> bool:
        """Whether there are no values."""
        return bool(self.reason)


class JobState(NamedTuple):
    """The equilibrium of one case, which that of a design near by is sought from; empty arrays of a motion."""

    q: np.ndarray
    multipliers: np.ndarray


@dataclass(frozen=True, kw_only=True)
class DesignOutcome(JobOutcome):
    """A design of a study that was solved in all cases, or could not be.

    Attributes
    ----------
    lane
        Number of the search that asked for it.
    design
        Values of the variables, (n,).
    values, gradients
        Of all responses in all cases, (cases, responses) and (cases, responses, n); empty if it failed.
    states
        Equilibria of all cases.
    curvatures
        Second derivatives of what the problem calls `curved`, in all cases, (cases, curved, n, n); empty if nothing is.
    """

    lane: int
    design: np.ndarray
    values: np.ndarray = field(default_factory=lambda: EMPTY)
    gradients: np.ndarray = field(default_factory=lambda: EMPTY)
    states: tuple[JobState, ...] = ()
    curvatures: np.ndarray = field(default_factory=lambda: EMPTY)

    @property
    def key(self) -> DesignKey:
        """What it is kept under."""
        return self.lane, self.design.tobytes()


@dataclass(frozen=True, kw_only=True)
class RunOutcome(JobOutcome):
    """A scene that was run, or could not be.

    Attributes
    ----------
    values
        Response -> its value.
    gradients
        Response -> variable -> derivative.
    steps, newton_iterations
        Of the run.
    drift
        Largest opening of a joint, relative to the model size or in rad.
    """

    values: dict[str, float] = field(default_factory=dict)
    gradients: dict[str, dict[str, float]] = field(default_factory=dict)
    steps: int = 0
    newton_iterations: int = 0
    drift: float = 0.0


UNINVOLVED = ("cli", "command_line", "report", "render", "results", "conformance")
"""Parts of the toolkit that no run goes through."""


def hashed(*parts: object) -> str:
    """Hash of anything that JSON can hold; numbers count with all their digits."""
    return sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:32]


@cache
def program() -> str:
    """Hash of all files of the toolkit that a run goes through."""
    root = Path(toolkit.__file__ or "").parent
    files = [path for path in sorted(root.rglob("*.py")) if path.relative_to(root).with_suffix("").parts[0] not in UNINVOLVED]
    return sha256(b"".join(path.read_bytes() for path in files)).hexdigest()


def file_hashes(files: list[Path]) -> list[str]:
    """Hashes of the content of files; "missing" stands for one that cannot be read."""
    return [sha256(path.read_bytes()).hexdigest() if path.is_file() else "missing" for path in files]


def scene_fingerprint(scene: Scene, *parts: object) -> str:
    """Hash of a scene, of the content of its files wherever these lie, of the program, and of what else an outcome follows from."""
    described = repr(scene.model_copy(update={"directory": Path()}))
    return hashed(described, file_hashes(scene.read_files()), parts, program())


SCHEMA, SCHEMA_VERSION = "ffrf-study", 1
Result = TypeVar("Result", bound=RunOutcome)
PAUSE_PER_WRITING = 10
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
        self._next, self._pending = ended + PAUSE_PER_WRITING * (ended - begun), False

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
    states = [tuple(column(f"{name}{k}") for name in JobState._fields) for k in range(cases)]
    rows = iter(range(count))
    for k in range(len(lane)):
        about: dict[str, Any] = {"lane": int(lane[k]), "design": design[k], "seconds": float(wall[k])}
        if failed[k]:
            yield DesignOutcome(**about, reason=reason[k].decode())
            continue
        row = next(rows)
        mine = tuple(JobState(q[row], multipliers[row]) for q, multipliers in states)
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
