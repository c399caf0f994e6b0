"""Sizes of memory: as options give them, in messages, and in pages."""

from __future__ import annotations

import numpy as np

GIGABYTE = 1e9
LARGE_PAGE = 1 << 21
"""Bytes. The first touch of a page costs a processor about a microsecond, of a large one with 512 times the memory some hundred."""


def zeros_in_large_pages(*shape: int) -> np.ndarray:
    """Zeros that begin where a large page does, if they fill more than two: numpy asks for large pages from there on."""
    count = int(np.prod(shape))
    if 8 * count <= 2 * LARGE_PAGE:
        return np.zeros(shape)
    memory = np.zeros(count + LARGE_PAGE // 8)
    first = -memory.ctypes.data % LARGE_PAGE // 8
    return memory[first : first + count].reshape(shape)


def in_gigabytes(count: float) -> str:
    """Text of a number of bytes for messages, in gigabytes."""
    size = count / GIGABYTE
    return f"{size:.0f} GB" if size >= 1 else f"{size:.2g} GB"
