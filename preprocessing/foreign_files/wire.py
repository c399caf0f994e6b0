"""What a reader hands over: JSON that holds plain arrays, without anything that could be executed."""

from __future__ import annotations

import json
from io import BytesIO
from typing import Any, BinaryIO

import numpy as np


def send(stream: BinaryIO, found: Any) -> None:
    """Write lists, texts, numbers and arrays: the JSON text behind its length, then the arrays in NumPy's own format."""
    arrays: list[np.ndarray] = []

    def numbered(value: Any) -> dict[str, int]:
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "iufbc":
            raise TypeError(f"it holds {type(value).__name__} instead of numbers")
        arrays.append(value)
        return {"array": len(arrays) - 1}

    text = json.dumps(found, default=numbered).encode()
    stream.write(b"%d\n" % len(text) + text)
    for array in arrays:
        whole = BytesIO()  # numpy cannot write to a pipe
        np.lib.format.write_array(whole, array, allow_pickle=False)
        stream.write(whole.getbuffer())
    stream.flush()


def receive(content: bytes) -> Any:
    """What was sent; raises ValueError if it is not whole."""
    stream = BytesIO(content)
    length = stream.readline(20)
    if not length[:-1].isdigit():
        raise ValueError("nothing was sent")
    text = stream.read(int(length))
    arrays = []
    while stream.tell() < len(content):
        arrays.append(np.lib.format.read_array(stream, allow_pickle=False))
    try:
        return json.loads(text, object_hook=lambda item: arrays[item["array"]] if set(item) == {"array"} else item)
    except IndexError as error:
        raise ValueError("it ends before its last array") from error
