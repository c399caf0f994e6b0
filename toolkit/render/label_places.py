"""Where names of points cover nothing, nobody takes them for another point's, and lines to them cross no other name."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

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
    """A text that is to stand beside a point, and half of its width and height."""

    text: str
    point: np.ndarray  # (2,)
    half: np.ndarray  # (2,)


class Placed(NamedTuple):
    """A name, the centre of its place, and whether a line has to lead there from its point."""

    name: Name
    place: np.ndarray  # (2,)
    led: bool

    @property
    def line(self) -> np.ndarray:
        """From the point nearly to the edge of the name, (2, 2)."""
        way = self.place - self.name.point
        inside = float(np.min((self.name.half + 1) / np.maximum(np.abs(way), 1e-12)))
        return np.array([self.name.point, self.place - min(inside, 1.0) * way])


def beside(
    names: list[Name],
    lines: list[np.ndarray],
    letter: float,
    size: np.ndarray,
    spots: np.ndarray = _NOWHERE,
    reaches: Reaches = _NEAR,
) -> list[Placed | None]:
    """Names in places off polylines (n, 2) and spots (m, 2) inside of a panel of a size; None for a point outside of it.

    All lengths are pixels or points of print, counted from the panel's lower left corner.
    """

    def inside(points: np.ndarray) -> np.ndarray:
        return np.all((points >= 0) & (points <= size), axis=-1)

    shown = [name for name in names if inside(name.point)]
    every = np.vstack([spots, *(_dense(points, _SPACING * letter) for points in [*lines, *(name.point[None] for name in names)])])
    seen = np.unique(np.round(_FINE * every[inside(every)]), axis=0) / _FINE
    places, points = (
        iter(label_places(shown, seen, letter, size, reaches)),
        np.array([name.point for name in shown]).reshape(-1, 2),
    )
    found: list[Placed | None] = []
    for name in names:
        if not inside(name.point):
            found.append(None)
            continue
        place = next(places)
        own, other = (float(each[0]) for each in _distances(place[None], name, points, letter))
        found.append(Placed(name, place, own > min(_FAR * letter, _CLEARLY * other)))
    return found


def label_places(
    names: list[Name], obstacles: np.ndarray, letter: float, size: np.ndarray, reaches: Reaches = _NEAR
) -> list[np.ndarray]:
    """Centres (2,) of labels.

    Parameters
    ----------
    obstacles : (m, 2)
        Points that should stay visible, densely along lines.
    letter : float
        Height of a letter.
    size : (2,)
        Of the panel; labels stay inside.
    reaches : tuple of float
        Gaps between a point and its label that are tried, in letters.
    """
    places: list[np.ndarray] = []
    points = np.array([name.point for name in names]).reshape(-1, 2)
    for name in names:
        candidates = np.concatenate([_around(name, reach * letter) for reach in reaches])
        clearances = [_clearance(candidates, name.half, obstacles)]
        placed = list(zip(places, names, strict=False))
        clearances += [_clearance(candidates, name.half + other.half, at[None]) for at, other in placed]
        clearances += [_clearance(candidates, name.half, _way(other.point, at)) for at, other in placed]
        ways = np.array([_way(name.point, candidate) for candidate in candidates]).reshape(-1, 2)
        for at, other in placed:  # a line that may lead to the name crosses no other
            clearances.append(_clearance(ways, other.half, at[None]).reshape(len(candidates), -1).min(axis=1))
        own, others = _distances(candidates, name, points, letter)
        clear = np.min(clearances, axis=0)
        free = (
            np.minimum(clear, _ENOUGH * letter)
            + _COVERING * np.minimum(clear - _SPACING / 2 * letter, 0)
            - _MISTAKEN * np.clip(own - _CLEARLY * others, 0, letter)  # further off a line leads there
            - 100 * _outside(candidates, name.half + _INSET * letter, size)
            - _NEARNESS * np.hypot(*(candidates - name.point).T)
        )
        places.append(candidates[int(np.argmax(np.round(free, _SAME)))])
    return places


def _distances(centres: np.ndarray, name: Name, points: np.ndarray, letter: float) -> tuple[np.ndarray, np.ndarray]:
    """Distances of a name at centres (m, 2) to its own point and to the nearest of all other points (n, 2), (m,) each."""
    others = points[np.hypot(*(points - name.point).T) > _ONE * letter]
    return np.maximum(_clearance(centres, name.half, name.point[None]), 0), _clearance(centres, name.half, others)


def _dense(points: np.ndarray, spacing: float) -> np.ndarray:
    """Points along a polyline at most a spacing apart."""
    if len(points) < 2:
        return points
    counts = np.ceil(np.hypot(*np.diff(points, axis=0).T) / spacing).astype(int).clip(1)
    steps, within = (
        np.diff(points, axis=0) / counts[:, None],
        np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts),
    )
    return np.vstack([np.repeat(points[:-1], counts, axis=0) + within[:, None] * np.repeat(steps, counts, axis=0), points[-1:]])


def _way(point: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Points on the line from a point to its name."""
    return point + np.linspace(0, 1, _STEPS)[:, None] * (place - point)


def _around(name: Name, gap: float) -> np.ndarray:
    """Centres (m, 2) of a label whose edge is about `gap` from its point, in all directions."""
    return name.point + (name.half + gap) * np.column_stack([np.cos(_DIRECTIONS), np.sin(_DIRECTIONS)])


def _clearance(centres: np.ndarray, half: np.ndarray, obstacles: np.ndarray) -> np.ndarray:
    """Distances of boxes at centres (m, 2) to the nearest obstacle; negative by the depth if one is inside."""
    x, y = (np.abs(obstacles[:, k] - centres[:, k, None]) - half[k] for k in range(2))
    distance = np.hypot(np.maximum(x, 0), np.maximum(y, 0)) + np.minimum(np.maximum(x, y), 0)
    return distance.min(axis=1, initial=np.inf)


def _outside(centres: np.ndarray, half: np.ndarray, size: np.ndarray) -> np.ndarray:
    return np.maximum(np.maximum(half - centres, centres + half - size), 0).sum(axis=1)
