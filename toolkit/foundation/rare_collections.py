"""Work that makes millions of objects, none of them garbage before it is done."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

OBJECTS_PER_COLLECTION = 500_000
"""New objects after which Python looks for garbage again: some hundred megabytes."""


@contextmanager
def rare_collections() -> Iterator[None]:
    """Context in which Python looks for garbage rarely.

    Measured, an eighth of a command, and of the time to compile the step loop, goes into that.
    """
    before = gc.get_threshold()
    gc.set_threshold(OBJECTS_PER_COLLECTION, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


@contextmanager
def last_work() -> Iterator[None]:
    """Context for the last work of a process, as `rare_collections`.

    Python does not look through all that is left when it ends, a quarter of a warm command.
    """
    with rare_collections():
        try:
            yield
        finally:
            gc.freeze()
