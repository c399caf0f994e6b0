"""Where names of points cover nothing, nobody takes them for another point's, and lines to them cross no other name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.render.moment import Moment

_DIRECTIONS = np.deg2rad(np.arange(0, 360, 22.5))
_ENOUGH = 0.4  # of a letter's height: more clearance than this is not better
_NEARNESS = 0.1  # clearance that a label gives up to be one length nearer to its point
_CLEARLY = 0.7  # a name is taken for that of its point if this part of its distance to any other is not less
_MISTAKEN = 2.0  # clearance that a label gives up to be one length less too far from its point
_COVERING = 20.0  # how much worse than narrow it is to cover something
_ONE = 0.2  # letters: points nearer to each other are one
_FAR = 1.7  # letters: from here on a line leads from the point to its name
_INSET = 0.2  # letters between a label and the edge of the panel
_SPACING = 0.3  # letters between points that stand for a line, so half of it is no clearance
_FINE = 2  # places per length at which what is drawn is seen
_STEPS = 9  # places at which the line from a point to its name is looked at
_SAME = 4  # decimals up to which places are told apart: round-off decides nothing
Reaches = tuple[float, ...]
_NEAR: Reaches = (0.4, 0.7, 1.1, 1.6, 2.2, 3.2, 4.4)
_NOWHERE = np.zeros((0, 2))


class Name(NamedTuple):
    """Text beside a point, and half of its width and height."""

    text: str
    point: np.ndarray  # (2,)
    half: np.ndarray  # (2,)


class PlacedLabel(NamedTuple):
    """Name in its place: centre of the text, and whether a line has to lead there from its point."""

    name: Name
    place: np.ndarray  # (2,)
    led: bool

    @property
    def line(self) -> np.ndarray:
        """Line (2, 2) from the point nearly to the edge of the name."""
        way = self.place - self.name.point
        inside = float(np.min((self.name.half + 1) / np.maximum(np.abs(way), 1e-12)))
        return np.array([self.name.point, self.place - min(inside, 1.0) * way])


class Panel(NamedTuple):
    """Names in a panel, of which those outside are not shown, and points (m, 2) that should stay visible, densely along lines."""

    names: list[Name]
    obstacles: np.ndarray
    size: np.ndarray  # (2,)

    def shows(self, points: np.ndarray) -> np.ndarray:
        """Whether points (..., 2) are inside the panel."""
        return np.all((points >= 0) & (points <= self.size), axis=-1)

    @property
    def shown(self) -> np.ndarray:
        """Points whose names are shown, (n, 2)."""
        return np.array([name.point for name in self.names if self.shows(name.point)]).reshape(-1, 2)


class Side(NamedTuple):
    """Position of a name beside its point: offset of the name's centre, and whether a line leads there."""

    offset: np.ndarray  # (2,)
    led: bool


def panel_of(names: list[Name], lines: list[np.ndarray], letter: float, size: np.ndarray, spots: np.ndarray = _NOWHERE) -> Panel:
    """Panel of a size with names that keep off polylines (n, 2) and spots (m, 2).

    All lengths are pixels or points of print, counted from the panel's lower left corner.
    """
    every = np.vstack([spots, dense_lines([*lines, *(name.point[None] for name in names)], _SPACING * letter)])
    empty = Panel(names, _NOWHERE, size)
    return empty._replace(obstacles=np.unique(np.round(_FINE * every[empty.shows(every)]), axis=0) / _FINE)


def placed(panel: Panel, sides: list[Side]) -> list[PlacedLabel | None]:
    """Names in their places beside their points; None for a point outside of the panel."""
    return [
        PlacedLabel(name, name.point + side.offset, side.led) if panel.shows(name.point) else None
        for name, side in zip(panel.names, sides, strict=True)
    ]


def sides(panels: Sequence[Panel], letter: float, reaches: Reaches = _NEAR) -> list[Side]:
    """Position of each name beside its point.

    The same names in several panels stand in the same positions in all: where they are best on the mean.

    Parameters
    ----------
    letter : float
        Height of a letter.
    reaches : tuple of float
        Gaps between a point and its label that are tried, in letters.
    """
    found: list[Side] = []
    for number, name in enumerate(panels[0].names):
        around = np.concatenate([_around(name.half, reach * letter) for reach in reaches])
        showing = [panel for panel in panels if panel.shows(panel.names[number].point)]
        free = [_free(panel, around, found, letter) for panel in showing] or [np.zeros(len(around))]
        best = around[int(np.argmax(np.round(np.mean(free, axis=0), _SAME)))]
        led = False
        for panel in showing:
            here = panel.names[number]
            own, other = (float(each[0]) for each in _distances(here.point + best[None], here, panel.shown, letter))
            led |= own > min(_FAR * letter, _CLEARLY * other)
        found.append(Side(best, led))
    return found


def _free(panel: Panel, around: np.ndarray, before: list[Side], letter: float) -> np.ndarray:
    """Quality (m,) of places (m, 2) beside the next name's point, given the places of the names before."""
    name, candidates = panel.names[len(before)], panel.names[len(before)].point + around
    clearances = [_clearance(candidates, name.half, panel.obstacles)]
    others = [each for each in placed(panel._replace(names=panel.names[: len(before)]), before) if each is not None]
    clearances += [_clearance(candidates, name.half + other.name.half, other.place[None]) for other in others]
    clearances += [_clearance(candidates, name.half, _way(other.name.point, other.place)) for other in others]
    ways = np.array([_way(name.point, candidate) for candidate in candidates]).reshape(-1, 2)
    for other in others:  # a line that may lead to the name crosses no other
        clearances.append(_clearance(ways, other.name.half, other.place[None]).reshape(len(candidates), -1).min(axis=1))
    own, apart = _distances(candidates, name, panel.shown, letter)
    clear = np.min(clearances, axis=0)
    free: np.ndarray = (
        np.minimum(clear, _ENOUGH * letter)
        + _COVERING * np.minimum(clear - _SPACING / 2 * letter, 0)
        - _MISTAKEN * np.clip(own - _CLEARLY * apart, 0, letter)  # further off a line leads there
        - 100 * _outside(candidates, name.half + _INSET * letter, panel.size)
        - _NEARNESS * np.hypot(*around.T)
    )
    return free


def _distances(centres: np.ndarray, name: Name, points: np.ndarray, letter: float) -> tuple[np.ndarray, np.ndarray]:
    """Distances of a name at centres (m, 2) to its own point and to the nearest of all other points (n, 2), (m,) each."""
    others = points[np.hypot(*(points - name.point).T) > _ONE * letter]
    return np.maximum(_clearance(centres, name.half, name.point[None]), 0), _clearance(centres, name.half, others)


def dense_lines(lines: Sequence[np.ndarray], spacing: float) -> np.ndarray:
    """Points (n, d) along polylines at most a spacing apart."""
    return np.vstack([_dense(points, spacing) for points in lines]) if lines else _NOWHERE


def _dense(points: np.ndarray, spacing: float) -> np.ndarray:
    """Points along a polyline at most a spacing apart."""
    if len(points) < 2:
        return points
    counts = np.ceil(np.linalg.norm(np.diff(points, axis=0), axis=1) / spacing).astype(int).clip(1)
    steps, within = (
        np.diff(points, axis=0) / counts[:, None],
        np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts),
    )
    return np.vstack([np.repeat(points[:-1], counts, axis=0) + within[:, None] * np.repeat(steps, counts, axis=0), points[-1:]])


def _way(point: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Points on the line from a point to its name."""
    return point + np.linspace(0, 1, _STEPS)[:, None] * (place - point)


def _around(half: np.ndarray, gap: float) -> np.ndarray:
    """Centres (m, 2) of a label whose edge is about `gap` from its point, counted from there, in all directions."""
    return (half + gap) * np.column_stack([np.cos(_DIRECTIONS), np.sin(_DIRECTIONS)])


def _clearance(centres: np.ndarray, half: np.ndarray, obstacles: np.ndarray) -> np.ndarray:
    """Distances of boxes at centres (m, 2) to the nearest obstacle; negative by the depth if one is inside."""
    x, y = (np.abs(obstacles[:, k] - centres[:, k, None]) - half[k] for k in range(2))
    distance = np.hypot(np.maximum(x, 0), np.maximum(y, 0)) + np.minimum(np.maximum(x, y), 0)
    return distance.min(axis=1, initial=np.inf)


def _outside(centres: np.ndarray, half: np.ndarray, size: np.ndarray) -> np.ndarray:
    return np.maximum(np.maximum(half - centres, centres + half - size), 0).sum(axis=1)


_PLACES = np.array([0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8])
"""Parts of a body's length at which its name may stand."""
_FREE, _SEEN = 0.25, 200
"""Distance to others from which on no place is better, in lengths of the body; points in the model size by which lines are seen."""


def body_places(
    moment: Moment, seen: Callable[[np.ndarray], np.ndarray] = lambda points: points, motion: Sequence[Moment] = ()
) -> dict[str, np.ndarray]:
    """Places (d,) for the names of bodies drawn as lines: far from other bodies and links, in the middle if that is as good.

    Parameters
    ----------
    seen : callable
        Points (n, d) -> where they are in the picture, (n, 2), in one scale.
    motion : sequence of Moment
        Those of a motion, in which the place is the same part of the body: the best on the mean.
    """
    every = [each.once("places on bodies", partial(_rated, each, seen)) for each in motion or (moment,)]
    found = {}
    for body in moment.scene.bodies:
        if (piece := moment.longest_piece(body)) is not None:
            best = first_largest(np.mean([rated[body] for rated in every], axis=0))
            found[body] = piece[0] + _PLACES[best] * (piece[1] - piece[0])
    return found


def _rated(moment: Moment, seen: Callable[[np.ndarray], np.ndarray]) -> dict[str, np.ndarray]:
    """Quality of possible places on each body, (n_places,): distance to others in lengths of the body, nearness to its middle."""
    spacing = moment.scene.size / _SEEN
    lines = {body: dense_lines(moment.segments(body), spacing) for body in moment.scene.bodies}
    links = dense_lines([moment.ends(link) for link in moment.links()], spacing)
    found = {}
    for body in lines:
        if (piece := moment.longest_piece(body)) is not None:
            others = np.vstack(
                [each for other, each in [("", links), *lines.items()] if other != body and len(each)] or [piece[:0]]
            )
            ends = seen(piece)
            length = max(float(np.linalg.norm(ends[1] - ends[0])), np.finfo(float).tiny)
            places = ends[0] + _PLACES[:, None] * (ends[1] - ends[0])
            near = np.linalg.norm(places[:, None] - seen(others), axis=2).min(axis=1, initial=_FREE * length)
            found[body] = near / length - _FREE / 4 * np.abs(_PLACES - 0.5)
    return found


class NamesOfMotion:
    """Positions of names for all pictures of a motion, chosen after some of its moments were drawn.

    Parameters
    ----------
    moments : sequence of Moment
        Those that are looked at.
    """

    def __init__(self, moments: Sequence[Moment]) -> None:
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
