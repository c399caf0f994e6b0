"""Beams of a frame that lie on each other, pass through nodes that are not theirs, or cross without a common node.

Two beams on one line count twice in mass and stiffness, which nobody means: this is refused. A node or a beam that touches another beam
without a common node is not connected with it. That may be meant (braces that pass each other), or be forgotten: this is told.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple, Self

import numpy as np

from preprocessing.recipes.frame.frame_tables import BeamTable

SAME_LINE = 1e-4
"""Distance, in lengths of the shorter beam, below which two beams are on one line; coordinates are typed with four digits or more."""
TOUCHING = 1e-3
"""Distance, in lengths of a beam, below which a node or another beam touches it: less than any beam is thick."""
NAMED = 3
"""Number of similar places that are named; the others are counted."""


class Lines(NamedTuple):
    """Middle lines of all beams."""

    beams: Sequence[BeamTable]
    nodes: Mapping[str, np.ndarray]  # name -> place (d,)
    start: np.ndarray  # (n, d)
    along: np.ndarray  # (n, d) from start to end
    length: np.ndarray  # (n,)

    @classmethod
    def of(cls, beams: Sequence[BeamTable], nodes: Mapping[str, np.ndarray]) -> Self:
        """Middle lines of beams between named nodes."""
        start = np.array([nodes[beam.start] for beam in beams])
        along = np.array([nodes[beam.end] for beam in beams]) - start
        return cls(beams, nodes, start, along, np.linalg.norm(along, axis=1))

    def name(self, k: int) -> str:
        """Words for a beam: its key and its nodes."""
        return f"beams.{k} (from {self.beams[k].start} to {self.beams[k].end})"

    def connected(self, k: int, m: int) -> bool:
        """Whether two beams have a node in common."""
        return bool({self.beams[k].start, self.beams[k].end} & {self.beams[m].start, self.beams[m].end})


def doubled(beams: Sequence[BeamTable], nodes: Mapping[str, np.ndarray]) -> Iterator[str]:
    """Complaints about beams that lie on each other, whole or in part."""
    lines = Lines.of(beams, nodes)
    for k in range(len(beams)):
        shared = _shared_length(lines, k)
        for m in map(int, np.flatnonzero(shared > TOUCHING * np.minimum(lines.length[k], lines.length[:k]))):
            yield _twice(lines, k, m, float(shared[m]))


def loose_contacts(beams: Sequence[BeamTable], nodes: Mapping[str, np.ndarray]) -> list[str]:
    """Warnings of contacts without a common node: nodes at one place, nodes on beams, beams that cross."""
    lines = Lines.of(beams, nodes)
    found = {
        "nodes are at one place without being connected": (_nodes_at_one_place(lines), "If they are one node, give it one name."),
        "nodes lie on beams without being connected": (
            _nodes_on_beams(lines),
            "If they are joined, let two beams meet at the node.",
        ),
        "beams cross without being connected": (_crossings(lines), "If they are joined, put a node there where all of them end."),
    }
    listed = {what: ([*places], remedy) for what, (places, remedy) in found.items()}
    return [f"{what}: {_listed(places)}. {remedy}" for what, (places, remedy) in listed.items() if places]


def _shared_length(lines: Lines, k: int) -> np.ndarray:
    """Length (k,) on which each of the beams before it lies on beam k; zero unless they are on one line."""
    length = lines.length[k]
    direction = lines.along[k] / length
    ends = np.stack([lines.start[:k], lines.start[:k] + lines.along[:k]]) - lines.start[k]
    places = ends @ direction
    off = ends - places[..., None] * direction
    low, high = np.maximum(places.min(axis=0), 0.0), np.minimum(places.max(axis=0), length)
    extent = np.where(places[1] == places[0], 1.0, places[1] - places[0])
    parts = [(place - places[0]) / extent for place in (low, high)]
    distances = [np.linalg.norm(off[0] + part[:, None] * (off[1] - off[0]), axis=1) for part in parts]
    on_one_line = np.maximum(*distances) <= SAME_LINE * np.minimum(length, lines.length[:k])
    return np.where(on_one_line, high - low, 0.0)


def _twice(lines: Lines, k: int, m: int, shared: float) -> str:
    """Complaint about two beams that lie on each other."""
    one, two = lines.beams[k], lines.beams[m]
    if {one.start, one.end} == {two.start, two.end}:
        return (
            f"beams.{k}: between {one.start} and {one.end} there is a beam already, beams.{m}, and both would count in mass and "
            "stiffness; leave one out, and give the other a larger section if the member is stronger"
        )
    return (
        f"beams.{k}: {lines.name(k)} and {lines.name(m)} lie on each other over a length of {shared:g}, where both would count in mass "
        "and stiffness; leave one out, or let each end where the other begins"
    )


def _nodes_at_one_place(lines: Lines) -> Iterator[str]:
    """Pairs of nodes that are nearer to each other than any beam is long."""
    names, places = list(lines.nodes), np.array(list(lines.nodes.values()))
    near = TOUCHING * lines.length.min()
    for k, name in enumerate(names):
        for m in np.flatnonzero(np.linalg.norm(places[:k] - places[k], axis=1) <= near):
            yield f"{names[m]} and {name} at {_told(places[k])}"


def _nodes_on_beams(lines: Lines) -> Iterator[str]:
    """Nodes between the ends of beams that they are no ends of."""
    for name, place in lines.nodes.items():
        part = np.sum((place - lines.start) * lines.along, axis=1) / lines.length**2
        off = np.linalg.norm(place - lines.start - part[:, None] * lines.along, axis=1)
        for k in map(int, np.flatnonzero((off <= TOUCHING * lines.length) & _between_ends(part))):
            if name not in (lines.beams[k].start, lines.beams[k].end):
                yield f"{name} on {lines.name(k)}"


def _crossings(lines: Lines) -> Iterator[str]:
    """Pairs of beams whose lines meet between the ends of both."""
    for k in range(len(lines.beams)):
        on_one, on_two, off = _nearest(lines, k)
        near = off <= TOUCHING * np.minimum(lines.length[k], lines.length[:k])
        for m in map(int, np.flatnonzero(near & _between_ends(on_one) & _between_ends(on_two))):
            if not lines.connected(k, m):
                yield f"{lines.name(m)} and {lines.name(k)} at {_told(lines.start[k] + on_one[m] * lines.along[k])}"


def _nearest(lines: Lines, k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nearest points of beam k and each beam before it, as parts of their lengths, and their distance; (k,) each."""
    one, two = lines.along[k], lines.along[:k]
    gap = lines.start[:k] - lines.start[k]
    mixed, squares = two @ one, lines.length[:k] ** 2
    determinant = lines.length[k] ** 2 * squares - mixed**2
    parallel = determinant <= SAME_LINE**2 * lines.length[k] ** 2 * squares
    safe = np.where(parallel, 1.0, determinant)
    on_one = np.where(parallel, -1.0, (squares * (gap @ one) - mixed * np.sum(gap * two, axis=1)) / safe)
    on_two = (on_one * mixed - np.sum(gap * two, axis=1)) / squares
    off = np.linalg.norm(gap + on_two[:, None] * two - on_one[:, None] * one, axis=1)
    return on_one, on_two, off


def _between_ends(part: np.ndarray) -> np.ndarray:
    return (part > TOUCHING) & (part < 1 - TOUCHING)


def _listed(found: Sequence[str]) -> str:
    more = f", and {len(found) - NAMED} more" if len(found) > NAMED else ""
    return ", ".join(found[:NAMED]) + more


def _told(place: np.ndarray) -> str:
    return f"({', '.join(f'{x:g}' for x in place)})"
