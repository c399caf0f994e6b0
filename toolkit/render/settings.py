"""matplotlib's settings: its own and ours, never those of a file `matplotlibrc` in the current folder, which can start LaTeX."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def drawing_settings(ours: Any) -> Iterator[None]:
    """Context in which figures look the same on every machine."""
    from matplotlib import rc_context, rcdefaults, rcParams

    with rc_context():
        rcdefaults()
        rcParams.update(ours)
        yield
