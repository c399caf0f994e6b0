"""What a reader hands over: JSON that holds plain arrays, without anything that could be executed."""

from __future__ import annotations

import json
import os
from typing import Any, BinaryIO

import numpy as np


def send(stream: BinaryIO, found: Any) -> None:
    """Write lists, texts, numbers and arrays to a stream: the JSON text behind its length, then the arrays.

    Arrays are in NumPy's own format, each of them once.
    """
    arrays: dict[int, tuple[int, np.ndarray]] = {}

    def numbered(value: Any) -> dict[str, int]:
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "iufbc":
            raise TypeError(f"it holds {type(value).__name__} instead of numbers")
        return {"array": arrays.setdefault(id(value), (len(arrays), value))[0]}

    text = json.dumps(found, default=numbered).encode()
    stream.write(b"%d\n" % len(text) + text)
    for _, array in arrays.values():
        np.lib.format.write_array(_Pipe(stream), array, allow_pickle=False)
    stream.flush()


class _Pipe:
    """Stream that is written to piece by piece; NumPy writes past what it takes for a file, which a pipe cannot do."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream

    def write(self, content: Any) -> int:
        return self._stream.write(content)


def receive(stream: BinaryIO) -> Any:
    """Record that was sent; raises ValueError if it is not whole."""
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
