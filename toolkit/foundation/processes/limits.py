"""Limits of a process that reads a file which nobody can trust."""

from __future__ import annotations

import os
from contextlib import suppress

ONE_THREAD = {name: "1" for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")}
"""Environment of such a process: threads take address space, which is limited, and readers need none."""


def limit_process(memory: int, seconds: int) -> None:
    """Limit this process to so many bytes of address space and seconds of processor time, where the system has such limits.

    None of its crashes leaves an image of its memory.
    """
    try:
        import resource
    except ImportError:  # Windows
        return
    limits = {"RLIMIT_AS": (memory,) * 2, "RLIMIT_CPU": (seconds, seconds + 5), "RLIMIT_CORE": (0, 0)}
    for name, limit in limits.items():
        with suppress(AttributeError, OSError, ValueError):  # not on this system, or a stricter one holds already
            resource.setrlimit(getattr(resource, name), limit)


def memory_of_machine() -> int:
    """Bytes of memory of the machine; 0 if it does not say."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return 0
