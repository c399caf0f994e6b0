"""How much memory and time the reading of a file may take, in proportion to its size."""

from __future__ import annotations

from dataclasses import dataclass

from toolkit.foundation.processes.limits import limit_process, memory_of_machine

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
    """Limits of memory and time for one reader."""

    memory: int  # bytes of address space
    seconds: int  # of processor time

    @property
    def patience(self) -> int:
        """Longest time in seconds on the clock."""
        return PATIENCE * self.seconds

    @classmethod
    def of(cls, size: int) -> Bounds:
        """Limits for a file of this many bytes; never more memory than the machine has."""
        memory = BASE_MEMORY + MEMORY_PER_BYTE * size
        return cls(min(memory, memory_of_machine() or memory), int(BASE_SECONDS + SECONDS_PER_BYTE * size))

    def impose(self) -> None:
        """Put this process under them, where the system has such limits."""
        limit_process(self.memory, self.seconds)
