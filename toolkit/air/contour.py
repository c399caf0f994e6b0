"""The contour of a section in the air: what it has to be, its chord, and its flap."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.errors import InputError

FEWEST = 10
"""Points of a contour at least."""
TOUCHING = 1e-9
"""Area, in squares of the chord, by which parts of a contour may overlap by round-off, as at a sharp tail."""


def with_flap(contour: np.ndarray, *, chord_fraction: float, angle: float | complex, bend: float = 0.02) -> np.ndarray:
    """Contour whose rear part is turned about a hinge in the middle between both sides.

    The skin bends over a short way instead of having a kink, so that no part of it overlaps another.

    Parameters
    ----------
    contour : shape (n, 2), from the tail over the upper side and the nose back to the tail
    chord_fraction : chord of the flap in chords of the section
    angle : of the flap, in rad, positive down
    bend : length over which the skin bends, in chords

    Returns
    -------
    of shape (n, 2)

    Raises
    ------
    InputError
        The contour is none, the hinge lies outside of it, or the flap turns by a right angle or more.
    """
    nodes = np.asarray(contour)
    refuse(nodes)
    if not bend / 2 < chord_fraction < 1 - bend / 2 or bend <= 0:
        raise InputError(
            f"a flap of {chord_fraction:g} chords that bends over {bend:g} has its hinge outside of the section. Give a fraction between."
        )
    if not -np.pi / 2 < np.real(angle) < np.pi / 2:
        raise InputError(f"a flap turned by {np.real(angle):.4g} rad is none. Give an angle in rad below a right angle.")
    chord, quarter = chord_and_quarter(nodes, nose_of(nodes))
    hinge = quarter[0] + chord * (0.75 - chord_fraction)
    away = nodes - np.stack([hinge, _middle(nodes, hinge)])
    way = away[:, 0] / (bend * chord) + 0.5
    way = np.where(way.real < 0, 0, np.where(way.real > 1, 1, way))
    turn = -angle * way * way * (3 - 2 * way)
    cosine, sine = np.cos(turn), np.sin(turn)
    turned = np.stack([away[:, 0] * cosine - away[:, 1] * sine, away[:, 0] * sine + away[:, 1] * cosine], axis=1)
    return np.asarray(nodes + (turned - away))


def nose_of(nodes: np.ndarray) -> int:
    """Number of the point of a contour that lies farthest in front."""
    return int(np.argmin(nodes[1:-1, 0].real)) + 1


def _middle(nodes: np.ndarray, x: float | complex) -> float | complex:
    """Height in the middle between both sides of a section at x."""
    nose = nose_of(nodes)
    heights = []
    for side in (nodes[nose::-1], nodes[nose:]):
        at = int(np.clip(np.searchsorted(side[:, 0].real, np.real(x)), 1, len(side) - 1))
        (x_0, y_0), (x_1, y_1) = side[at - 1], side[at]
        heights.append(y_0 + (x - x_0) * (y_1 - y_0) / (x_1 - x_0))
    return (heights[0] + heights[1]) / 2


def chord_and_quarter(nodes: np.ndarray, nose: int) -> tuple[np.ndarray, np.ndarray]:
    """Chord along x, and the point behind its first quarter at the height of the tail, of one contour or of many, shape (..., n, 2)."""
    before, front, behind = (nodes[..., nose + k, 0] for k in (-1, 0, 1))
    bend, slope = (before + behind) / 2 - front, (behind - before) / 2
    foremost = front - slope * slope / (4 * bend)
    tail = (nodes[..., 0, :] + nodes[..., -1, :]) / 2
    chord = tail[..., 0] - foremost
    return chord, np.stack([foremost + chord / 4, tail[..., 1]], axis=-1)


def refuse(nodes: np.ndarray) -> None:
    """Raise an InputError for what is no contour of a section."""
    count = len(nodes)
    if nodes.ndim != 2 or nodes.shape[1] != 2 or count < FEWEST:
        raise InputError(
            f"a contour has shape (n, 2) with n of at least {FEWEST}, not {nodes.shape}. Give points from the tail over the upper side."
        )
    if not np.isfinite(nodes).all():
        raise InputError("a contour has points that are no numbers. Leave them out.")
    places = nodes.real
    steps = np.diff(places, axis=0)
    if not (steps**2).sum(axis=1).all():
        at = int(np.flatnonzero((steps**2).sum(axis=1) == 0)[0])
        raise InputError(f"points {at} and {at + 1} of a contour are the same. Leave one out.")
    x, y = places.T
    if (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() <= 0:
        raise InputError("a contour runs from the tail over the lower side. Turn the order of its points round.")
    if (crossing := crossed(places)) is not None:
        raise InputError(
            f"a contour crosses itself: its parts from points {crossing[0]} and {crossing[1]} on meet. Give the outline of one section."
        )


def crossed(places: np.ndarray) -> tuple[int, int] | None:
    """Numbers of the first points of two parts of a contour that cross, or None."""
    first, second = places[:-1], places[1:]

    def side(start: np.ndarray, end: np.ndarray, point: np.ndarray) -> np.ndarray:
        along, away = end - start, point - start
        return np.asarray(along[..., 0] * away[..., 1] - along[..., 1] * away[..., 0])

    a, b, c, d = first[:, None], second[:, None], first[None], second[None]
    least = (TOUCHING * np.ptp(places[:, 0]) ** 2) ** 2
    cross = (side(a, b, c) * side(a, b, d) < -least) & (side(c, d, a) * side(c, d, b) < -least)
    found = np.argwhere(cross)
    return (int(found[0, 0]), int(found[0, 1])) if len(found) else None
