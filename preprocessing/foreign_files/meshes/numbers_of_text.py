"""Numbers of a text, of which each word has to be one."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from preprocessing.foreign_files.meshes.wrong_file import wrong_file

NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
LARGEST_WHOLE = 2**53
"""Whole numbers below it are exact as doubles."""


def numbers_of_text(path: Path, text: bytes, line: int, remedy: str) -> np.ndarray:
    """All numbers of a text that begins in a line of a file.

    Raises
    ------
    InputError
        A word is no number.
    """
    if not text.strip():
        return np.zeros(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # numpy warns of what it cannot read, and stops there
        try:
            return np.fromstring(text, sep=" ")
        except (DeprecationWarning, ValueError):
            pass
    raise wrong_file(path, "a word is no number", remedy, line + _first_wrong(text) if line else 0)


def whole_numbers(path: Path, numbers: np.ndarray, remedy: str, line: int = 0) -> np.ndarray:
    """Numbers that have to be whole, as integers.

    Raises
    ------
    InputError
        One is not, or is too large to be exact.
    """
    if not np.all((numbers == np.floor(numbers)) & (np.abs(numbers) < LARGEST_WHOLE)):
        raise wrong_file(path, "it has other numbers than whole ones for counts, numbers or types", remedy, line)
    return numbers.astype(np.int64)


def _first_wrong(text: bytes) -> int:
    """Lines before the first one that does not consist of numbers."""
    for k, line in enumerate(text.split(b"\n")):
        if not all(NUMBER.fullmatch(word) for word in line.split()):
            return k
    return 0


def alike_rows(
    values: np.ndarray, at: int, columns: tuple[int, ...], width_of: Callable[[np.ndarray], int]
) -> Iterator[np.ndarray | None]:
    """Numbers from one place on as tables of rows, of which each says how many numbers it has.

    A table ends where one of the given columns changes; `width_of` tells the width of a row from its first numbers up to the last of
    these columns. None, and then nothing more, where a row is not whole.
    """
    first = max(columns) + 1
    while at < len(values):
        head = values[at : at + first]
        width = width_of(head) if len(head) == first else 0
        if not first <= width <= len(values) - at:
            yield None
            return
        n, most = 1, 4
        while most:
            ahead = values[at + n * width : at + (n + most) * width]
            rows = ahead[: len(ahead) // width * width].reshape(-1, width)
            alike = np.all(rows[:, columns] == head[list(columns)], axis=1)
            here = len(alike) if alike.all() else int(alike.argmin())
            n, most = n + here, 2 * most if here == most else 0
        yield values[at : at + n * width].reshape(n, width)
        at += n * width
