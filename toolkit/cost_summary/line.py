"""One line of the cost summary."""

from __future__ import annotations

from typing import NamedTuple


class Line(NamedTuple):
    """A line of the summary: how much of something is kept and dropped, in the unit of its section, and why."""

    what: str
    kept: int
    dropped: int = 0
    why: str = ""
