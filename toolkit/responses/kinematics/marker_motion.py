"""Motion of markers, and the chain rule from a formula of it to a response's partial derivatives.

With the pose y(q) of a marker, its rate w = B v and its acceleration s = B a + b (see `markers.planar` and
`markers.spatial`), a value f(y, w, s) has

    f_q = f_y B + f_w B_v + f_s (B_a + b_q),   f_v = f_w B + 2 f_s B_v,   f_a = f_s B
    f_x = f_y y_x + f_w w_x + f_s s_x

because b = v^T y_qq v is a quadratic form of the rates: b_v = 2 (y_qq v) = 2 B_v.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from toolkit.responses.response import Partials
from toolkit.system.marker_states import MarkerStates
from toolkit.system.solution import Solution
from toolkit.system.system import System


class Motion(NamedTuple):
    """Pose of a marker, its rate and acceleration, each (p,): 3 numbers in the plane, the position and three axes in space, 12.

    Derivatives of k values by them are (k, p); None stands for zero.
    """

    y: Any = None
    rate: Any = None
    acceleration: Any = None


@dataclass(frozen=True)
class MarkerMotion:
    """Motion of some markers of a system, with work memory for one state at a time."""

    system: System
    markers: tuple[int, ...]
    states: MarkerStates

    @classmethod
    def of(cls, system: System, grips: Sequence[tuple[str, ...]]) -> MarkerMotion:
        """Motion of the markers that bodies have at points."""
        return cls(system, tuple(map(system.numbering.marker, grips)), MarkerStates(system))

    def at(self, solution: Solution, step: int) -> list[Motion]:
        """Motion of each marker at one step; `partials` then belongs to that step."""
        found = self.states.at(solution.q[step], solution.v[step], solution.a[step])
        return [
            Motion(found.y[m].copy(), found.rate[m].copy(), found.acceleration[m] + found.centripetal[m]) for m in self.markers
        ]

    def partials(self, values: np.ndarray, slopes: Sequence[Motion], design: np.ndarray | float = 0.0) -> Partials:
        """Partials of k values (k,) from their derivatives by the motion of each marker: (k, n_q), and (k, n_x) by the design.

        `design` (k, n_x) is what the values depend on it besides.
        """
        system, markers, state = self.system, self.system.plan.markers, self.states.found
        by: np.ndarray = np.zeros((3, len(values), system.n_q), system.dtype)
        by_x = np.zeros((len(values), system.n_x)) + design
        for m, slope in zip(self.markers, slopes, strict=True):
            columns = slice(markers.start[m], markers.start[m + 1])
            designs = slice(markers.design_start[m], markers.design_start[m + 1])
            at, variables = markers.coordinate[columns], markers.design_variable[designs]
            B, B_v = state.B[columns], state.B_v[columns]
            if slope.y is not None:
                by[0][:, at] += slope.y @ B.T
                by_x[:, variables] += np.real(slope.y @ state.y_x[designs].T)
            if slope.rate is not None:
                by[0][:, at] += slope.rate @ B_v.T
                by[1][:, at] += slope.rate @ B.T
                by_x[:, variables] += np.real(slope.rate @ state.rate_x[designs].T)
            if slope.acceleration is not None:
                by[0][:, at] += slope.acceleration @ (state.B_a[columns] + state.b_q[columns]).T
                by[1][:, at] += 2 * slope.acceleration @ B_v.T
                by[2][:, at] += slope.acceleration @ B.T
                by_x[:, variables] += np.real(
                    slope.acceleration @ (state.acceleration_x[designs] + state.centripetal_x[designs]).T
                )
        moved = [any(getattr(slope, name) is not None for slope in slopes) for name in ("rate", "acceleration")]
        return Partials(
            values, q=by[0], v=by[1] if any(moved) else None, a=by[2] if moved[1] else None, design=by_x
        )  # fmt: skip
