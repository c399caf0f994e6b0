"""Angle of a body against another, which counts turns, and angles in space that are known up to whole turns only."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Self

import numpy as np
from pydantic import model_validator

from toolkit.components.joints.kernels.laws import angle_of
from toolkit.components.markers.component import Place, on_both
from toolkit.description.description import Quantity, Triple
from toolkit.foundation.errors import InputError
from toolkit.foundation.kernel import plain
from toolkit.foundation.kinematics.orientation import axes_along
from toolkit.foundation.near_ties import spread
from toolkit.foundation.verdict import Caution
from toolkit.responses.marker_formula import MarkerMotion, Motion, one_of
from toolkit.responses.motion import Rotation
from toolkit.responses.over_time import OverTime
from toolkit.responses.response import Instant, Partials, refuse_axis
from toolkit.system.solution import Solution

if TYPE_CHECKING:
    from toolkit.scene.resolution import ResolvedScene


class RelativeAngle(Instant):
    """Angle of the first body against the second since the undeformed configuration, with all turns; in space about an axis.

    In space the axis turns with the second body; with its rotation matrix A_b, that of the first body A_a and n_1, n_2 normal to the axis,
    u_i = A_b n_i and w_i = A_a n_i,

        angle = atan2(u_2 . w_1 - u_1 . w_2, u_1 . w_1 + u_2 . w_2) + 2 pi turns

    In the plane the angle has all turns, also those of a kept run that it starts from. In space they are counted from the start of the run:
    from step to step the angle changes by what its rate at both ends says, to the nearest
    turn. An equilibrium has no turns.

    Attributes
    ----------
    bodies
        The body that turns, and the one that it turns against; one may be the ground.
    point
        Point that both share, or the point on each; where a body deforms, its points turn differently.
    axis
        Axis, of a spatial scene alone, of any length.
    """

    kind = "relative-angle"
    quantity = "angle"

    bodies: tuple[str, str]
    point: Place
    axis: Annotated[Triple | None, Quantity("none")] = None

    @model_validator(mode="after")
    def _two_places(self) -> Self:
        first, second = on_both(self.point)
        if self.bodies[0] == self.bodies[1] and first == second:
            raise ValueError(
                f"point {first!r} of {self.bodies[0]!r} has no angle against itself; name two bodies, or two points of one"
            )
        return self

    def markers(self) -> tuple[tuple[str, str], ...]:
        """Pairs of body and point: the point on each body."""
        return tuple(zip(self.bodies, on_both(self.point), strict=True))

    def check(self, scene: ResolvedScene) -> None:
        """Refuse an axis in the plane, and its absence in space.

        Raises
        ------
        InputError
            It is missing there, or given in the plane.
        """
        super().check(scene)
        refuse_axis(self.axis, scene, "relative angle")

    def at(self, solution: Solution, step: int) -> Partials:
        """Relative angle with its whole turns at a step, and its partial derivatives."""
        return self.instants(solution)(step)

    def instants(self, solution: Solution) -> Callable[[int], Partials]:
        """Relative angle with its whole turns, step by step; turns are counted once for all steps."""
        motion, turns = MarkerMotion.of(solution.system, self.markers()), list[float]()

        def look(step: int) -> Partials:
            if self.axis is not None and not turns:
                turns.extend(self._turns(solution, motion))
            values, slopes = self._formula(*motion.at(solution, step))
            found = one_of(motion.partials(values, slopes), 0, solution, step)
            return found if self.axis is None else found._replace(value=found.value + turns[step])

        return look

    def _formula(self, a: Motion, b: Motion) -> tuple[np.ndarray, Sequence[Motion]]:
        """Relative angle without whole turns, and its derivatives by both motions."""
        if self.axis is None:
            side = np.eye(3)[2:]
            return a.y[2:] - b.y[2:], [Motion(y=side), Motion(y=-side)]
        (c, s), slopes = self._cosine_and_sine(a, b)
        by = [(c * slope.y[1] - s * slope.y[0]) / (c * c + s * s) for slope in slopes]
        return np.array([plain(angle_of)(s, c)]), [Motion(y=each[None]) for each in by]

    def _cosine_and_sine(self, a: Motion, b: Motion) -> tuple[np.ndarray, Sequence[Motion]]:
        """Sums u_1 . w_1 + u_2 . w_2 and u_2 . w_1 - u_1 . w_2, and their derivatives by both motions."""
        n_1, n_2 = _normals(self.axis)
        w_1, w_2, u_1, u_2 = n_1 @ a.y, n_2 @ a.y, n_1 @ b.y, n_2 @ b.y
        by_a = np.array([u_1 @ n_1 + u_2 @ n_2, u_2 @ n_1 - u_1 @ n_2])
        by_b = np.array([w_1 @ n_1 + w_2 @ n_2, w_1 @ n_2 - w_2 @ n_1])
        return by_a @ a.y, [Motion(y=by_a), Motion(y=by_b)]

    def _turns(self, solution: Solution, motion: MarkerMotion) -> np.ndarray:
        """Angle of the whole turns completed at every step, 2 pi times their number, (n_t,)."""
        if solution.whole_run[0] != solution.times[0]:
            raise InputError(
                "turns are counted from the start of a run, whose first states are not kept. Raise solver.memory, so that all are."
            )
        angles, rates = np.zeros((2, len(solution.times)))
        for step in range(len(angles)):
            motions = motion.at(solution, step)
            value, slopes = self._formula(*motions)
            angles[step] = np.real(value[0])
            rates[step] = np.real(sum(slope.y[0] @ each.rate for slope, each in zip(slopes, motions, strict=True)))
        expected = np.diff(solution.times) * (rates[1:] + rates[:-1]) / 2
        jumps = np.round((expected - np.diff(angles)) / (2 * np.pi))
        found: np.ndarray = 2 * np.pi * np.append(0, np.cumsum(jumps))
        return found


@lru_cache
def _normals(axis: Triple | None) -> tuple[np.ndarray, ...]:
    """Matrices (3, 12) that give A n_1 and A n_2 from a pose."""
    axes = axes_along(axis)
    return tuple(np.kron(np.append(0, axes[:, k]), np.eye(3)) for k in range(2))


MOST_INSTANTS = 500
"""Instants, evenly spread over the motion."""


def folded_rotations(solution: Solution) -> Iterator[Caution]:
    """Caution for every spatial rotation that jumps from one half turn to the other during a motion.

    It is a remark; for means, integrals and extremes over time, which no whole turn can be added to, it is a doubt.
    """
    for name, response in solution.system.scene.responses.items():
        whole = isinstance(response, OverTime)
        looked = response.source if isinstance(response, OverTime) else response
        if isinstance(looked, Rotation) and looked.axis is not None:
            look = looked.instants(solution)
            angles = np.array([float(np.real(look(step).value)) for step in spread(len(solution.times) - 1, MOST_INSTANTS)])
            if np.any(np.abs(np.diff(angles)) > np.pi):
                what = f"the rotation that {name} is made of" if whole else name
                yield Caution(
                    "rotation-folded",
                    f"{what} passed half a turn: in space it is an angle in (-pi, pi], without the turns that are done. "
                    "The response relative-angle counts them.",
                    doubt=whole,
                )


def folded_equilibria(solution: Solution) -> Iterator[Caution]:
    """Remark for every angle of a spatial equilibrium that passed half a turn on its path: whole turns are not in its value."""
    path = solution.path
    asked = solution.system.scene.responses if path is not None and len(path.q) > 1 else {}
    angles = {f: each for f, each in asked.items() if isinstance(each, Rotation | RelativeAngle) and each.axis is not None}
    if path is None or not angles:
        return
    still = np.zeros_like(path.q)
    along = replace(solution, times=np.arange(len(path.q)), q=path.q, v=still, a=still, multipliers=path.multipliers)
    for name, response in angles.items():
        look = response.instants(along)
        here = float(np.real(response.instants(solution)(0).value))
        turned = np.unwrap([float(np.real(look(step).value)) for step in range(len(path.q))])[-1]
        if abs(turned - here) > np.pi:
            yield Caution(
                "rotation-folded",
                f"{name} = {here:.5g} passed half a turn on the way from the unloaded state: in an equilibrium it is an angle in "
                f"(-pi, pi], without whole turns. With those of the way it is {turned:.5g} rad.",
                doubt=False,
            )
