"""Where names of points cover nothing, and lines to them cross no other name: at the freest of the places round their point."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

_DIRECTIONS = np.deg2rad(np.arange(0, 360, 22.5))
_ENOUGH = 0.4  # of a letter's height: more clearance than this is not better
_NEARNESS = 0.1  # clearance that a label gives up to be one length nearer to its point
_SPACING = 0.3  # letters between points that stand for a line
_FINE = 2  # places per length at which what is drawn is seen
_STEPS = 9  # places at which the line from a point to its name is looked at
_SAME = 4  # decimals up to which places are told apart: round-off decides nothing
Reaches = tuple[float, ...]
_NEAR: Reaches = (0.4, 0.7, 1.1, 1.6, 2.2)
_NOWHERE = np.zeros((0, 2))


class Name(NamedTuple):
    """A text that is to stand beside a point, and half of its width and height."""

    text: str
    point: np.ndarray  # (2,)
    half: np.ndarray  # (2,)


def beside(
    names: list[Name],
    lines: list[np.ndarray],
    letter: float,
    size: np.ndarray,
    spots: np.ndarray = _NOWHERE,
    reaches: Reaches = _NEAR,
) -> list[tuple[Name, np.ndarray]]:
    """Names of the points inside of a panel of a size, with the centres of their places off polylines (n, 2) and spots (m, 2).

    All lengths are pixels or points of print, counted from the panel's lower left corner.
    """

    def inside(points: np.ndarray) -> np.ndarray:
        return np.all((points >= 0) & (points <= size), axis=-1)

    shown = [name for name in names if inside(name.point)]
    every = np.vstack([spots, *(_dense(points, _SPACING * letter) for points in [*lines, *(name.point[None] for name in names)])])
    seen = np.unique(np.round(_FINE * every[inside(every)]), axis=0) / _FINE
    return list(zip(shown, label_places(shown, seen, letter, size, reaches), strict=True))


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
    for name in names:
        candidates = np.concatenate([_around(name, reach * letter) for reach in reaches])
        clearances = [_clearance(candidates, name.half, obstacles)]
        placed = list(zip(places, names, strict=False))
        clearances += [_clearance(candidates, name.half + other.half, at[None]) for at, other in placed]
        clearances += [_clearance(candidates, name.half, _way(other.point, at)) for at, other in placed]
        ways = np.array([_way(name.point, candidate) for candidate in candidates]).reshape(-1, 2)
        for at, other in placed:  # a line that may lead to the name crosses no other
            clearances.append(_clearance(ways, other.half, at[None]).reshape(len(candidates), -1).min(axis=1))
        free = (
            np.minimum(np.min(clearances, axis=0), _ENOUGH * letter)
            - 100 * _outside(candidates, name.half, size)
            - _NEARNESS * np.hypot(*(candidates - name.point).T)
        )
        places.append(candidates[int(np.argmax(np.round(free, _SAME)))])
    return places


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
