"""Where along a body its name stands: where nobody takes it for that of another body."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.render.label_places import dense_lines
from toolkit.render.moment import Moment

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
