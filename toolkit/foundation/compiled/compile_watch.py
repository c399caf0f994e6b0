"""Watch over the compilation of formulas: how many and for how long, as it happens."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING

from toolkit.foundation.compiled.public_parts import PUBLIC_ONLY

if TYPE_CHECKING:
    from toolkit.foundation.compiled.numba_parts import event as numba_event


class CompileWatch:
    """Counts the functions that were compiled and the time that it took; functions compiled on the way to others count, their time once.

    Only private parts of numba announce them: without these nothing is counted.
    """

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

    def notify(self, event: numba_event.Event) -> None:
        """Note that a function begins to be compiled, or that this is done or has failed."""
        self._begin() if event.is_start else self._end()

    def _begin(self) -> None:
        if self._on_first and not self.functions and not self._depth:
            self._on_first()
        if not self._depth:
            self._begun = clock.perf_counter()
        self._depth += 1

    def _end(self) -> None:
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
    with ExitStack() as open_until_then:
        open_until_then.callback(watch.close)
        if not PUBLIC_ONLY:
            from toolkit.foundation.compiled.numba_parts import announced

            open_until_then.enter_context(announced(watch))
        yield watch
