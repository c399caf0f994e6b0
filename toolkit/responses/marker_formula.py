"""Base of responses that are a formula of the motion of markers: a new one states its grips and its formula.

Motion of markers, and the chain rule from a formula of it to a response's partial derivatives.

With the pose y(q) of a marker, its rate w = B v and its acceleration s = B a + b (see `markers.planar` and
`markers.spatial`), a value f(y, w, s) has

    f_q = f_y B + f_w B_v + f_s (B_a + b_q),   f_v = f_w B + 2 f_s B_v,   f_a = f_s B
    f_x = f_y y_x + f_w w_x + f_s s_x

because b = v^T y_qq v is a quadratic form of the rates: b_v = 2 (y_qq v) = 2 B_v.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.responses.response import STATES, Instant, Partials, magnitude
from toolkit.system.solution import MarkerStates, Solution
from toolkit.system.system import System

if TYPE_CHECKING:
    from toolkit.scene.resolution import ResolvedScene


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


class MarkerFormula(Instant):
    """Base of responses that are a formula of the motion of markers; the chain rule to coordinates and design is done here.

    The markers are those of `markers()`: pairs of a body and a point.
    """

    @abstractmethod
    def formula(self, *motions: Motion) -> tuple[np.ndarray, Sequence[Motion]]:
        """Values (k,) from the motion of each marker, and their derivatives (k, p) by each part of that motion.

        One value, or the components of a vector, of which `chosen` takes one or the magnitude. Complex-safe.
        """

    @property
    def chosen(self) -> int | None:
        """Number of the value that is the response; None for the magnitude of all."""
        return 0

    def instants(self, solution: Solution) -> Callable[[int], Partials]:
        """Value and partial derivatives, step by step, by the formula and the chain rule."""
        motion = MarkerMotion.of(solution.system, self.markers())

        def look(step: int) -> Partials:
            return one_of(motion.partials(*self.formula(*motion.at(solution, step))), self.chosen, solution, step)

        return look

    def at(self, solution: Solution, step: int) -> Partials:
        """Value and partial derivatives at a step, by the formula and the chain rule."""
        return self.instants(solution)(step)


class MarkerVector(MarkerFormula):
    """Base of formulas whose values are a vector.

    Attributes
    ----------
    component
        One component, or the magnitude.
    """

    component: Literal["x", "y", "z", "magnitude"] = "magnitude"

    def check(self, scene: ResolvedScene) -> None:
        """Refuse a z component in a planar scene.

        Raises
        ------
        InputError
            A component that the scene does not have.
        """
        super().check(scene)
        refuse_component(self.component, scene, self.kind)

    @property
    def chosen(self) -> int | None:
        """Number of the wanted component; None for the magnitude."""
        return place_of(self.component)


def place_of(component: str) -> int | None:
    """Number of a vector's component; None for the magnitude."""
    return None if component == "magnitude" else "xyz".index(component)


def refuse_component(component: str, scene: ResolvedScene, kind: str) -> None:
    """Refuse a component that vectors of the scene do not have.

    Raises
    ------
    InputError
        Names those that they have.
    """
    known = (*scene.space.axes, "magnitude")
    if component not in known:
        raise InputError(f"a {kind} in a scene of dimension 2 has no component {component!r}; available: {', '.join(known)}.")


def one_of(rows: Partials, place: int | None, solution: Solution, step: int) -> Partials:
    """One of several values (k,) with partials (k, ...), or the magnitude of all, whose direction is that of `magnitude`."""
    slopes = {name: getattr(rows, name) for name in (*STATES, "design") if getattr(rows, name) is not None}
    if place is not None:
        return Partials(rows.value[place], **{name: slope[place] for name, slope in slopes.items()})

    def change() -> np.ndarray:
        total = 0.0 if rows.design is None else rows.design
        return total + sum(np.real(slopes[name]) @ solution.derivative(name)[step] for name in STATES if name in slopes)

    size, direction = magnitude(rows.value, change)
    return Partials(size, **{name: direction @ slope for name, slope in slopes.items()})
