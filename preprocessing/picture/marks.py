"""The places that the picture of a body marks, with numbers, and where these numbers stand so that none lies on another."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple

MOST_OF_A_KIND = 12
"""Interface points, masses and groups that a picture marks; its list tells how many more there are."""
DIGIT, HEIGHT = 6.5, 13.0
"""Size in pixels, at 100 dots per inch, of a digit of a number and of its frame."""
BESIDE = 6.0
"""Pixels from a marked place to the frame of its number."""


class Mark(NamedTuple):
    """Marked place of a body."""

    name: str
    kind: str  # a key of `LOOKS`
    position: Sequence[float]
    nodes: int | None


class Look(NamedTuple):
    """Appearance of a kind of places."""

    words: str
    marker: str
    color: str
    filled: bool
    size: float


LOOKS = {
    "point": Look("interface point", "o", "#c0392b", True, 60.0),
    "clamp": Look("clamp", "s", "#1b1b1b", True, 52.0),
    "mass": Look("mass", "D", "#8e44ad", True, 46.0),
    "centre": Look("centre of mass", "P", "#1e8449", True, 70.0),
    "group": Look("group", "^", "#1f5fa8", False, 110.0),
}
"""Kind of a marked place -> how it looks; the last ones are drawn first."""


class Label(NamedTuple):
    """Numbers that stand at one place of the picture, in pixels."""

    numbers: list[int]
    place: tuple[float, float]

    @property
    def text(self) -> str:
        """Text of the numbers, for example "1, 3, 5-9"."""
        rows: list[list[int]] = []
        for number in self.numbers:
            rows = [*rows[:-1], [*rows[-1], number]] if rows and number == rows[-1][-1] + 1 else [*rows, [number]]
        return ", ".join(f"{row[0]}-{row[-1]}" if len(row) > 2 else ", ".join(map(str, row)) for row in rows)

    @property
    def width(self) -> float:
        """Width of the label's frame, in pixels."""
        return DIGIT * len(self.text) + HEIGHT

    def within(self, right: float) -> Label:
        """Label moved to the left where it would reach beyond a place."""
        return self._replace(place=(min(self.place[0], right - self.width), self.place[1]))

    def meets(self, other: Label) -> bool:
        """Whether the frames of two labels overlap."""
        (x, y), (u, v) = self.place, other.place
        return (x - u < other.width if x > u else u - x < self.width) and abs(y - v) < HEIGHT + 2


def marks_of(summary: Mapping[str, Any]) -> list[Mark]:
    """Marks of interface points, clamp, masses, centre and groups, in the order of their numbers."""
    return [*_marks(summary)]


def _marks(summary: Mapping[str, Any]) -> Iterator[Mark]:
    for name, each in _first(summary["interface_points"].items()):
        yield Mark(name, "point", each["position"], each["nodes"])
    if summary["clamp"]:
        yield Mark("", "clamp", summary["clamp"]["position"], summary["clamp"]["nodes"])
    for each in _first(summary["masses"]):
        yield Mark(f"of {each['mass']:.6g} {summary['units']['mass']}", "mass", each["position"], each["nodes"])
    yield Mark("", "centre", summary["centre"], None)
    for name, each in _first(_placed_groups(summary)):
        yield Mark(name, "group", each["position"], each["nodes"])


def _first(each: Iterable[Any]) -> list[Any]:
    return list(each)[:MOST_OF_A_KIND]


def _placed_groups(summary: Mapping[str, Any]) -> list[tuple[str, Any]]:
    return [(name, each) for name, each in summary["groups"].items() if each["position"] is not None]


def not_marked(summary: Mapping[str, Any]) -> Iterator[str]:
    """Words on how many more places of a kind there are than the list has room for."""
    numbers = {
        "interface points": len(summary["interface_points"]),
        "masses": len(summary["masses"]) + summary["not_listed"].get("masses", 0),
        "groups": len(_placed_groups(summary)) + summary["not_listed"].get("groups", 0),
    }
    yield from (f"and {n - MOST_OF_A_KIND} more {words}" for words, n in numbers.items() if n > MOST_OF_A_KIND)


def labels_at(places: Sequence[tuple[float, float]], right: float) -> list[Label]:
    """The numbers of all marks at their places in pixels, none beyond `right`; those that would overlap share one frame."""
    found = [Label([k + 1], (x + BESIDE, y + BESIDE)).within(right) for k, (x, y) in enumerate(places)]
    while (pair := _overlapping(found)) is not None:
        first, second = pair
        joined = Label(sorted(found[first].numbers + found[second].numbers), found[first].place).within(right)
        found = [joined if k == first else each for k, each in enumerate(found) if k != second]
    return found


def _overlapping(labels: Sequence[Label]) -> tuple[int, int] | None:
    return next(((i, j) for i, j in combinations(range(len(labels)), 2) if labels[i].meets(labels[j])), None)
