"""Names of points, written where they cover nothing: at the freest of the places round their point."""

from __future__ import annotations

import numpy as np

from toolkit.render.panel import Pane, Panel

_DIRECTIONS = np.deg2rad(np.arange(0, 360, 22.5))
_ENOUGH = 0.25  # of a letter's height: more clearance than this is not better
_NEARNESS = 0.1  # clearance that a label gives up to be one pixel nearer to its point
_SPACING = 6.0  # pixels between points that stand for a line
Reaches = tuple[float, ...]
_NEAR: Reaches = (0.4, 0.7, 1.1, 1.6)
_NOWHERE = np.zeros((0, 2))


def write_names(panel: Panel, named: list[tuple[np.ndarray, str]], lines: list[np.ndarray]) -> None:
    """Write the names of the points that the panel shows beside them, off the polylines (n, 2)."""
    write_beside(panel, [(panel.pixel(point), name) for point, name in named], [panel.pixel(points) for points in lines])


def write_beside(
    pane: Pane,
    named: list[tuple[np.ndarray, str]],
    lines: list[np.ndarray],
    spots: np.ndarray = _NOWHERE,
    reaches: Reaches = _NEAR,
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Write names beside points that lie in the panel, off polylines (n, 2) and other spots (m, 2), all in pixels of the panel.

    Returns every point with the place of its name.
    """
    size = np.array(pane.place[2:])

    def inside(points: np.ndarray) -> np.ndarray:
        return np.all((points >= 0) & (points <= size), axis=-1)

    shown = [(point, name) for point, name in named if inside(point)]
    if not shown:
        return []
    every = np.vstack([spots, *(_dense(points, _SPACING) for points in [*lines, *(point[None] for point, _ in named)])])
    texts, points = [name for _, name in shown], np.array([point for point, _ in shown])
    places = label_places(points, texts, every[inside(every)], pane.letter, size, reaches)
    for text, place in zip(texts, places, strict=True):
        pane.write(text, place)
    return list(zip(points, places, strict=True))


def _dense(points: np.ndarray, spacing: float) -> np.ndarray:
    """Points along a polyline at most a spacing apart."""
    if len(points) < 2:
        return points
    counts = np.ceil(np.hypot(*np.diff(points, axis=0).T) / spacing).astype(int).clip(1)
    pairs = zip(points[:-1], points[1:], counts, strict=True)
    return np.vstack([*(np.linspace(start, end, n, endpoint=False) for start, end, n in pairs), points[-1:]])


def label_places(
    points: np.ndarray, texts: list[str], obstacles: np.ndarray, letter: float, size: np.ndarray, reaches: Reaches = _NEAR
) -> np.ndarray:
    """Centres of labels for points (n, 2), all in pixels, shape (n, 2).

    Parameters
    ----------
    obstacles : (m, 2)
        Points that should stay visible, densely along lines.
    letter : float
        Height of a letter; a text is taken to be 0.6 times as wide per letter.
    size : (2,)
        Of the panel; labels stay inside.
    reaches : tuple of float
        Gaps between a point and its label that are tried, in letters.
    """
    places: list[np.ndarray] = []
    boxes: list[np.ndarray] = []
    for point, text in zip(points, texts, strict=True):
        half = np.array([0.3 * len(text) + 0.1, 0.5]) * letter
        candidates = [candidate for reach in reaches for candidate in _around(point, half, reach * letter)]
        free = [
            min(_clearance(candidate, half, obstacles), _box_clearance(candidate, half, places, boxes), _ENOUGH * letter)
            - 100 * _outside(candidate, half, size)
            - _NEARNESS * np.hypot(*(candidate - point))
            for candidate in candidates
        ]
        places.append(candidates[int(np.argmax(free))])
        boxes.append(half)
    return np.array(places).reshape(-1, 2)


def _around(point: np.ndarray, half: np.ndarray, gap: float) -> list[np.ndarray]:
    """Centres of a box of half sizes `half` whose edge is about `gap` from the point, in all directions."""
    return [point + (half + gap) * np.array([np.cos(angle), np.sin(angle)]) for angle in _DIRECTIONS]


def _clearance(centre: np.ndarray, half: np.ndarray, obstacles: np.ndarray) -> float:
    """Distance from a box to the nearest obstacle; negative by the depth if one is inside."""
    outside = np.abs(obstacles - centre) - half
    distance = np.hypot(*np.maximum(outside, 0).T) + np.minimum(outside.max(axis=1), 0)
    return float(distance.min(initial=np.inf))


def _box_clearance(centre: np.ndarray, half: np.ndarray, places: list[np.ndarray], boxes: list[np.ndarray]) -> float:
    pairs = zip(places, boxes, strict=True)
    return min((_clearance(centre, half + other, place[None]) for place, other in pairs), default=np.inf)


def _outside(centre: np.ndarray, half: np.ndarray, size: np.ndarray) -> float:
    return float(np.maximum(np.maximum(half - centre, centre + half - size), 0).sum())
