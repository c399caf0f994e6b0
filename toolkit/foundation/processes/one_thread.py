"""Linear algebra of small matrices in one thread: several threads wait for each other longer than they work."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

SINGLE = {"OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Environment of a process whose linear algebra never starts threads; it has to be there before numpy is loaded."""


class _Limit(threading.local):
    """A limit of one thread, which the outermost block of a thread of the program sets and takes back.

    OpenBLAS keeps the limit for each thread of the program.
    """

    inside = 0
    set_by_us: Any = None

    def enter(self) -> None:
        """Enter one more block; the first one limits linear algebra to one thread."""
        if not self.inside and not _is_single():
            self.set_by_us = _controller().limit(limits=1, user_api="blas")
        self.inside += 1

    def leave(self) -> None:
        """Leave one block; the last one takes the limit back."""
        self.inside -= 1
        if not self.inside and self.set_by_us is not None:
            self.set_by_us.restore_original_limits()
            self.set_by_us = None


_LIMIT = _Limit()


@contextmanager
def one_thread() -> Iterator[None]:
    """Context or decorator in which the process's linear algebra (BLAS, LAPACK) has one thread.

    A factorisation of the wing's 140 equations takes 0.2 ms in one thread; in two that share their processors with other programs it was
    seen to take 150 ms. The outer one of nested blocks gives back as many threads as there were.
    """
    _LIMIT.enter()
    try:
        yield
    finally:
        _LIMIT.leave()


def _is_single() -> bool:
    return all(os.environ.get(name) == number for name, number in SINGLE.items())


@cache
def _controller() -> ThreadpoolController:
    """Controller of the threads of all libraries that scipy and numpy have loaded; looking for them takes some 20 ms."""
    import scipy.linalg  # noqa: F401, it brings one of them
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
