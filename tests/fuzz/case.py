"""One hostile case: files in a folder, a command that is run there, and what came of it."""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

Outcome = Literal["result", "own error", "traceback", "crash", "hang", "no words", "damaged"]
RIGHT = ("result", "own error")
Cases = Callable[[np.random.Generator], Iterator["Case"]]
"""A kind of cases: without end, the same for the same seed."""


@dataclass(frozen=True)
class Case:
    """A command is run in a folder of its own, after `write` has put its files there."""

    name: str
    arguments: tuple[str, ...]  # the first one is `ffrf` or `ffrf-preprocess`
    write: Callable[[Path], None]
    replaces: tuple[str, ...] = ()  # files that a command that ends well may replace


@dataclass(frozen=True)
class Ended:
    """How the command ended."""

    code: int | None  # negative: a signal; None: it was ended after its time
    said: str  # on both channels


def judged(case: Case, ended: Ended, before: dict[str, str], after: dict[str, str]) -> tuple[Outcome, str]:
    """What came of it, and a word on what is wrong."""
    if ended.code is None:
        return "hang", ""
    if ended.code < 0:
        return "crash", f"signal {-ended.code}"
    if "Traceback (most recent call last)" in ended.said or ended.code not in (0, 1, 2):
        return "traceback", " ".join(ended.said.split()[-30:])
    if ended.code and len(ended.said.strip()) < 10:
        return "no words", ended.said
    if changed := sorted(damage(case, ended, before, after)):
        return "damaged", f"{ended.code} {changed[:5]}"
    return ("own error" if ended.code else "result"), ""


def damage(case: Case, ended: Ended, before: dict[str, str], after: dict[str, str]) -> Iterator[str]:
    """Files that should not be there, or are no longer what they were."""
    allowed = set(case.replaces) if ended.code == 0 else set()
    yield from (name for name in before if after.get(name) != before[name] and name not in allowed)
    new = set(after) - set(before)
    yield from new if ended.code else (name for name in new if ".tmp" in Path(name).name)


def snapshot(folder: Path) -> dict[str, str]:
    """Everything in a folder: kind, mode and content of each."""
    found = {}
    for root, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = Path(root) / name
            state = path.lstat()
            content = f"{stat.S_IFMT(state.st_mode):o} {state.st_mode & 0o777:o}"
            if stat.S_ISREG(state.st_mode):
                content += f" {state.st_size}"
                if state.st_size < 10_000_000:
                    content += hashlib.sha256(path.read_bytes()).hexdigest()
            found[str(path.relative_to(folder))] = content
    return found


def identity(case: Case, files: dict[str, str]) -> str:
    """Two cases are distinct if their commands or files are."""
    return hashlib.sha256(repr((case.arguments, sorted(files.items()))).encode("utf-8", "surrogateescape")).hexdigest()
