"""The skin: the portion of a contour from F round the nose to G, its stations, and their places on a target shape.

Contours, and so all arc lengths, may carry a complex step in a parameter of the shape; what is checked are the real parts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from preprocessing.airfoil.arc_length_spline import Number, norm
from preprocessing.airfoil.contour import Contour
from toolkit.foundation.errors import InputError

SPACINGS = ("equal", "curvature")


@dataclass(frozen=True, eq=False)
class Skin:
    """Portion of a contour from F (arc length `start` of the contour) to G (`end`); its own arc length s counts from F."""

    contour: Contour
    start: Number
    end: Number

    def __post_init__(self) -> None:
        start, end, length = self.start.real, self.end.real, self.contour.length.real
        for name, s in (("F", start), ("G", end)):
            if not 0 <= s <= length:
                raise InputError(f"{name} at arc length {s:g} is off the contour, which runs from 0 to {length:g}.")
        if start >= end:
            upper = [s < self.contour.leading_edge for s in (start, end)]
            if upper[0] == upper[1]:
                remedy = f"Both lie on the {'upper' if upper[0] else 'lower'} side; put F on the upper side, G on the lower."
            else:
                remedy = "Exchange F and G: F belongs to the upper side, G to the lower."
            raise InputError(
                f"F (arc length {start:g}) does not come before G ({end:g}) along the loop trailing edge, upper side, "
                f"leading edge, lower side. {remedy}"
            )

    @property
    def length(self) -> Number:
        """Length of the skin."""
        return self.end - self.start

    def position(self, s) -> np.ndarray:
        """Points (..., 2) at arc lengths s (...) from F."""
        return self.contour.position(self.start + self._on_skin(s))

    def tangent_angle(self, s) -> np.ndarray:
        """Continuous tangent angle (...) at arc lengths s (...) from F."""
        return self.contour.tangent_angle(self.start + self._on_skin(s))

    def curvature(self, s) -> np.ndarray:
        """Signed curvature (...) at arc lengths s (...) from F."""
        return self.contour.curvature(self.start + self._on_skin(s))

    def stations(self, n_elements: int, spacing: str = "equal", grading: float = 1.0) -> np.ndarray:
        """Arc lengths (n_elements + 1,) of the nodes, from 0 at F to the length at G.

        "equal" spaces them evenly, "curvature" with node density 1 + grading sqrt(|kappa| L), where kappa is the
        curvature and L the length of the skin; `grading` has no unit, 0 gives equal spacing.

        Raises
        ------
        InputError
            Number, spacing or grading is invalid; or the contour carries a complex step, and the nodes depend on its
            curvature, which is not differentiated.
        """
        if n_elements != int(n_elements) or n_elements < 1:
            raise InputError(f"number of elements {n_elements!r} must be a whole number of at least 1.")
        if spacing not in SPACINGS:
            raise InputError(f"spacing {spacing!r} is unknown; available: {', '.join(SPACINGS)}.")
        if not (np.isfinite(grading) and grading >= 0):
            raise InputError(f"grading {grading!r} must be zero or positive, for example 1.0.")
        even = np.linspace(0.0, self.length, int(n_elements) + 1)
        if spacing == "equal":
            return even
        if self.contour.is_complex:
            raise InputError(
                'nodes spaced by "curvature" have no derivative by the shape. Use spacing = "equal", or leave the shape out of the '
                "parameters that derivatives are wanted by."
            )
        length = self.length.real
        s = np.linspace(0.0, length, 100 * len(self.contour.curve.point_s) + 1)
        density = 1 + grading * np.sqrt(np.abs(self.curvature(s)) * length)
        count = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2)])
        return np.interp(even.real / length, count / count[-1], s)

    def locate(
        self,
        *,
        arc_length: float | None = None,
        x: float | None = None,
        side: str | None = None,
        node: int | None = None,
        stations: np.ndarray | None = None,
    ) -> Number:
        """Arc length from F of a point named by its arc length, by x and side, or by a node of `stations`.

        Raises
        ------
        InputError
            None or several of the three ways, or a point off the skin (the message states what is admissible).
        """
        if sum(way is not None for way in (arc_length, x, node)) != 1:
            raise InputError("name a point of the skin in exactly one way: arc_length, x with side, or node with stations.")
        if arc_length is not None:
            return self._on_skin(arc_length).item()
        if x is not None:
            if side is None:
                raise InputError(f"x = {x:g} needs side='upper' or side='lower'.")
            return self._on_skin(self.contour.at_x(x, side) - self.start, f"x = {x:g} on the {side} side, ").item()
        if node is None or stations is None or not 0 <= node < len(stations):
            given = "no stations were given" if stations is None else f"nodes count from 0 (F) to {len(stations) - 1} (G)"
            raise InputError(f"node {node} is not on the skin: {given}.")
        return self._on_skin(stations[node]).item()

    def target_positions(self, target: Contour, s: np.ndarray) -> np.ndarray:
        """Points (..., 2) of the target shape that belong to the skin's points at arc lengths s (...) from F.

        The skin keeps its length and F its place, so material point s lies at the same arc length from F on the
        target. G slides: cutting the target at the abscissa of G would be wrong.

        Raises
        ------
        InputError
            The target does not pass through F, or ends before the skin does.
        """
        s = self._on_skin(s)
        place = self.contour.position(self.start)
        start = target.nearest(place)
        _refuse_misfit(target, start, place, float(np.max(np.real(s))), 1e-4 * self.contour.length.real)
        return target.position(start + s)

    def _on_skin(self, s, what: str = "") -> np.ndarray:
        """Arc length s with round-off at the ends removed; refused if it is off the skin."""
        s = np.asarray(s) + 0.0
        real, length = np.real(s), self.length.real
        outside = ~((real >= -1e-9 * length) & (real <= (1 + 1e-9) * length))
        if np.any(outside):
            raise InputError(
                f"{what}arc length {real[outside].flat[0]:g} from F is off the skin; admissible: 0 (F) to {length:g} (G)."
            )
        return np.where(real < 0, 0.0, np.where(real > length, self.length, s))


def _refuse_misfit(target: Contour, start: Number, place: np.ndarray, reach: float, tolerance: float) -> None:
    """Refuse a target that misses F, at `place`, or ends before the skin of length `reach` does."""
    x, y = np.real(place)
    miss = float(norm(np.real(target.position(start) - place)))
    if miss > tolerance:
        raise InputError(
            f"the target shape passes F ({x:g}, {y:g}) at a distance of {miss:g}. Both shapes need the same frame and chord: do not "
            'normalise or scale the target on its own, and give a shape mode at F of = "both".'
        )
    left = target.length.real - start.real
    if reach > left:
        raise InputError(
            f"the target shape ends at arc length {left:g} from F, before the skin's {reach:g}. Complete its lower side."
        )
