"""Where along a body its name stands: where nobody takes it for that of another body."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.render.label_places import dense_lines
from toolkit.render.moment import Moment

_PLACES = np.array([0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8])
"""Parts of a body's length at which its name may stand."""
_FREE, _SEEN = 0.25, 200
"""Distance to others from which on no place is better, in lengths of the body; points in the scene's size by which lines are seen."""


def body_places(moment: Moment, seen: Callable[[np.ndarray], np.ndarray] = lambda points: points) -> dict[str, np.ndarray]:
    """Bodies that lines stand for -> a place (d,) on each, far from other bodies and from links, in its middle if that is as good.

    Parameters
    ----------
    seen : callable
        Points (n, d) -> where they are in the picture, (n, 2), in one scale.
    """
    spacing = moment.scene.size / _SEEN
    lines = {body: dense_lines(moment.segments(body), spacing) for body in moment.scene.bodies}
    links = dense_lines([moment.ends(link) for link in moment.links()], spacing)
    found = {}
    for body in lines:
        if (piece := moment.longest_piece(body)) is not None:
            others = np.vstack(
                [each for other, each in [("", links), *lines.items()] if other != body and len(each)] or [piece[:0]]
            )
            places = piece[0] + _PLACES[:, None] * (piece[1] - piece[0])
            found[body] = places[_best(seen(places), seen(others), float(np.linalg.norm(np.diff(seen(piece), axis=0))))]
    return found


def _best(places: np.ndarray, others: np.ndarray, length: float) -> int:
    """Number of the place (n, 2) from which points (m, 2) are far, on a body of a length."""
    near = np.linalg.norm(places[:, None] - others, axis=2).min(axis=1, initial=_FREE * length)
    return first_largest(near - _FREE / 4 * length * np.abs(_PLACES - 0.5))
