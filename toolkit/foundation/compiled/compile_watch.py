"""Watch over the compilation of formulas: how many and for how long, as it happens."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from numba.core import event

KIND = "numba:compile"
"""Event by which numba announces the compilation of a function; one that is loaded from the disk is none."""


class CompileWatch(event.Listener):
    """Counts the functions that were compiled and the time that it took; functions compiled on the way to others count, their time once."""

    def __init__(self, on_first: Callable[[], None] | None = None, on_function: Callable[[int], None] | None = None) -> None:
        self.functions = 0
        self.seconds = 0.0
        self._on_first, self._on_function = on_first, on_function
        self._depth = 0
        self._begun = 0.0
        self._opened = clock.perf_counter()
        self.rest = 0.0
        """Time in s that the block took beyond compilation, once it has ended."""

    def close(self) -> None:
        """Note that the block has ended."""
        self.rest = clock.perf_counter() - self._opened - self.seconds

    def on_start(self, event: event.Event) -> None:
        """Note that a function begins to be compiled."""
        if self._on_first and not self.functions and not self._depth:
            self._on_first()
        if not self._depth:
            self._begun = clock.perf_counter()
        self._depth += 1

    def on_end(self, event: event.Event) -> None:
        """Note that the compilation of a function is done, or has failed."""
        self._depth -= 1
        self.functions += 1
        if self._on_function:
            self._on_function(self.functions)
        if not self._depth:
            self.seconds += clock.perf_counter() - self._begun


@contextmanager
def watched_compilation(
    on_first: Callable[[], None] | None = None, on_function: Callable[[int], None] | None = None
) -> Iterator[CompileWatch]:
    """A watch over everything that is compiled in its block; `on_first` is called before the first function is, `on_function` after each
    with their number."""
    watch = CompileWatch(on_first, on_function)
    event.register(KIND, watch)
    try:
        yield watch
    finally:
        event.unregister(KIND, watch)
        watch.close()
