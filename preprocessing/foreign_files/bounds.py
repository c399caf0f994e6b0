"""How much memory and time the reading of a file may take, in proportion to its size."""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass

LARGEST_FILE = 2 * 10**9
"""Bytes; a mesh of ten million nodes has half of it."""
BASE_MEMORY, MEMORY_PER_BYTE = 2**30, 50
"""Bytes of address space: the libraries alone take a third of the first, and a byte of text becomes 5 to 20 of Python's lists."""
BASE_SECONDS, SECONDS_PER_BYTE = 30, 1e-5
"""Processor time; the slowest readers, of text in Python, take 0.5 s for a million bytes."""
PATIENCE = 3
"""Times the processor time after which a reader that waits for something is ended."""


@dataclass(frozen=True)
class Bounds:
    """What one reader may use."""

    memory: int  # bytes of address space
    seconds: int  # of processor time

    @property
    def patience(self) -> int:
        """Seconds on the clock."""
        return PATIENCE * self.seconds

    @classmethod
    def of(cls, size: int) -> Bounds:
        """Those of a file of this many bytes; never more memory than the machine has."""
        memory = BASE_MEMORY + MEMORY_PER_BYTE * size
        return cls(min(memory, _machine()) if _machine() else memory, int(BASE_SECONDS + SECONDS_PER_BYTE * size))

    def impose(self) -> None:
        """Put this process under them, where the system has such limits; none of its crashes leaves an image of its memory."""
        try:
            import resource
        except ImportError:  # Windows
            return
        limits = {"RLIMIT_AS": (self.memory,) * 2, "RLIMIT_CPU": (self.seconds, self.seconds + 5), "RLIMIT_CORE": (0, 0)}
        for name, limit in limits.items():
            with suppress(AttributeError, OSError, ValueError):  # not on this system, or a stricter one holds already
                resource.setrlimit(getattr(resource, name), limit)


def _machine() -> int:
    """Bytes of memory of the machine; 0 if it does not say."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return 0
