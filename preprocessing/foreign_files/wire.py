"""What a reader hands over: JSON that holds plain arrays, without anything that could be executed."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import BinaryIO, TypeAlias, TypedDict

import numpy as np

Sent: TypeAlias = "str | float | np.ndarray | Sequence[Sent] | Mapping[str, Sent] | None"
"""Texts, numbers, arrays, and lists and records of these."""


class ReaderOutcome(TypedDict, total=False):
    """Outcome of a reader: what it has found, or one of the reasons why it has found nothing."""

    found: Sent
    refused: str  # the reason in words of our own
    reason: str  # why a library found nothing
    lacks: str  # package that is missing
    memory: bool  # whether there was not enough of it


def send(stream: BinaryIO, outcome: ReaderOutcome) -> None:
    """Write an outcome to a stream: the JSON text behind its length, then the arrays.

    Arrays are in NumPy's own format, each of them once.
    """
    arrays: dict[int, tuple[int, np.ndarray]] = {}

    def numbered(value: object) -> dict[str, int]:
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "iufbc":
            raise TypeError(f"it holds {type(value).__name__} instead of numbers")
        return {"array": arrays.setdefault(id(value), (len(arrays), value))[0]}

    text = json.dumps(outcome, default=numbered).encode()
    stream.write(b"%d\n" % len(text) + text)
    for _, array in arrays.values():
        np.lib.format.write_array(_Pipe(stream), array, allow_pickle=False)
    stream.flush()


class _Pipe:
    """Stream that is written to piece by piece; NumPy writes past what it takes for a file, which a pipe cannot do."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream

    def write(self, content: bytes) -> int:
        return self._stream.write(content)


def receive(stream: BinaryIO) -> ReaderOutcome:
    """Outcome that was sent; raises ValueError if it is not whole."""
    size = stream.seek(0, os.SEEK_END)
    stream.seek(0)
    length = stream.readline(20)
    if not length[:-1].isdigit():
        raise ValueError("nothing was sent")
    text = stream.read(int(length))
    arrays = []
    while stream.tell() < size:
        arrays.append(np.lib.format.read_array(stream, allow_pickle=False))
    try:
        return json.loads(text, object_hook=lambda item: arrays[item["array"]] if set(item) == {"array"} else item)
    except IndexError as error:
        raise ValueError("it ends before its last array") from error
