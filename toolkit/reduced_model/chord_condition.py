"""The reference condition of a body whose frame goes through two of its interface points, as a reduced model writes it down."""

from __future__ import annotations

from typing import NamedTuple

_BEGIN = "chord: the first point stays in its place in the frame and the second on the line through both, of "
_BETWEEN = "/"
"""No name of an interface point has it."""


class Chord(NamedTuple):
    """Two interface points that the frame of a body goes through."""

    first: str
    second: str

    @property
    def condition(self) -> str:
        """Reference condition of the chord in words."""
        return f"{_BEGIN}{self.first}{_BETWEEN}{self.second}"


def chord_of(reference_condition: str) -> Chord | None:
    """Interface points of a chord from its reference condition; None of any other reference condition."""
    if not reference_condition.startswith(_BEGIN):
        return None
    first, _, second = reference_condition.removeprefix(_BEGIN).partition(_BETWEEN)
    return Chord(first, second)
