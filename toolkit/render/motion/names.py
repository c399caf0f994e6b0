"""Names over a motion: the same in every picture of it, and on the same side of their points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from toolkit.render.label_places import Panel, Side


class NamesOfMotion:
    """Positions of names for all pictures of a motion, chosen after some of its moments were drawn.

    Parameters
    ----------
    moments : sequence of Moment
        Those that are looked at.
    """

    def __init__(self, moments: Sequence[Any]) -> None:
        self.moments = moments
        self._seen: dict[int, list[Panel]] = {}
        self._sides: dict[int, list[Side]] = {}

    def sides(self, number: int, panel: Panel, choose: Callable[[Sequence[Panel]], list[Side]]) -> list[Side]:
        """Positions of the names of a numbered panel, chosen by `choose` from its states at the moments that were looked at."""
        if number in self._sides:
            return self._sides[number]
        seen = self._seen.setdefault(number, [])
        seen.append(panel)
        if len(seen) == len(self.moments):
            self._sides[number] = choose(seen)
        return choose([panel])
