"""Base of responses that are a formula of the motion of markers: a new one states its grips and its formula."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.responses.instant import Instant, magnitude
from toolkit.responses.kinematics.marker_motion import MarkerMotion, Motion
from toolkit.responses.response import STATES, Partials
from toolkit.system.solution import Solution


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

    def check(self, scene: Any) -> None:
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


def refuse_component(component: str, scene: Any, kind: str) -> None:
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
