"""Result of a solver: states at all times, their design derivatives, and what the run cost."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from toolkit.components.bodies.cut_body import CutBody
from toolkit.components.bodies.model_body import ModelBody
from toolkit.components.markers.planar import MarkerState
from toolkit.components.markers.poses import update_pose_designs, update_poses
from toolkit.components.markers.spatial import SpatialMarkerState
from toolkit.description.design import BodyPoint
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError, NeedsDirectError
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.system import System


@dataclass(frozen=True)
class LimitPoint:
    """Point of the path where the load factor turns back (fold): the equilibrium beyond it is elsewhere, after a snap-through.

    load_factor : part of the load that is reached there
    coordinate : name of the coordinate that moves most there, in parts of the model size (or rad)
    place : number of the point in the arrays of the path
    """

    load_factor: float
    coordinate: str
    place: int

    @property
    def percent(self) -> str:
        """Load factor in percent, in digits enough to tell it from 100."""
        short = f"{100 * self.load_factor:.6g} %"
        return f"{100 * self.load_factor:.12g} %" if short == "100 %" else short


@dataclass(frozen=True)
class StaticPath:
    """Equilibria in the order in which they were found; the last is the static solution.

    `unstable_crossings` counts the equilibria under the full load that the path met before and that are unstable.
    """

    load_factors: np.ndarray  # (n_p,)
    q: np.ndarray  # (n_p, n_q)
    multipliers: np.ndarray  # (n_p, n_lam)
    limit_points: tuple[LimitPoint, ...] = ()
    unstable_crossings: int = 0

    @property
    def passed_limit(self) -> bool:
        """Whether a snap-through lies between the unloaded state and the last one."""
        return bool(self.limit_points)


@dataclass(frozen=True)
class Solution:
    """States at all times; a static solution has one time. Leading d: total design derivative, design on the last axis.

    Shapes: q, v, a (n_t, n_q), multipliers (n_t, n_lam), dq, dv, da (n_t, n_q, n_x), dmultipliers (n_t, n_lam, n_x).
    `drift` is the largest violation of a joint, `correction` the largest Newton correction that a step was content with, `local_error` the
    largest error that a step is estimated to have made, all relative to the model size (or rad); `load_steps` of a static solution.
    `options` are those of the run; `own_start` says that it did not begin at the scene's start, and `start_moved`
    by how much of the model size (or rad) a given start was moved to close its joints; `run_times` are all times of the run,
    where the solution holds the states of some alone; `path` is the way of a static solution from the unloaded state; `names` are those
    of states that are no times of a run; `halved` are the times at which steps began that Newton could do in halves only;
    `sensitivity_seconds` is the time that its derivatives took, where that was measured. `judge` finds out what speaks against the
    solution, when it is asked for its `verdict`.
    """

    system: System
    times: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    multipliers: np.ndarray
    dq: np.ndarray
    dv: np.ndarray
    da: np.ndarray
    dmultipliers: np.ndarray
    drift: float = 0.0
    correction: float = 0.0
    local_error: float | None = None
    load_steps: int = 0
    options: RunOptions | None = None
    own_start: bool = False
    start_moved: float = 0.0
    run_times: np.ndarray | None = None
    newton_iterations: int = 0
    sensitivity_seconds: float | None = None
    path: StaticPath | None = None
    names: tuple[str, ...] = ()
    halved: tuple[float, ...] = ()
    judge: Callable[[Solution], Verdict] | None = field(default=None, compare=False)

    @classmethod
    def from_padded(cls, system: System, times: np.ndarray, states: tuple[np.ndarray, ...], **report) -> Solution:
        """Solution from arrays q, v, [a; lam] and their derivatives, all padded to n on the second axis."""
        n_q = system.n_q
        q, v, acc, dq, dv, dacc = states
        return cls(
            system, times, q[:, :n_q], v[:, :n_q], acc[:, :n_q], acc[:, n_q:],
            dq[:, :n_q], dv[:, :n_q], dacc[:, :n_q], dacc[:, n_q:], **report,
        )  # fmt: skip

    @cached_property
    def verdict(self) -> Verdict:
        """Whether the solution can be trusted, and why not; found out when it is first asked for."""
        if self.judge is None:
            return Verdict((Caution("not-judged", "nobody has checked these states: they come from no solver of the toolkit."),))
        return self.judge(self)

    @cached_property
    def known(self) -> dict[Hashable, Any]:
        """Store of what others have found out about the solution, each under a key of its own."""
        return {}

    @property
    def warnings(self) -> tuple[Caution, ...]:
        """Cautions that whoever reads the solution has to know, doubts first."""
        return self.verdict.warnings

    @property
    def steps(self) -> int:
        """Number of time steps of the whole run."""
        return len(self.whole_run) - 1

    @property
    def spins(self) -> bool:
        """Whether the solution is the steady state of a scene that spins."""
        return not self.steps and (self.options or self.system.scene.solver).equilibrium == "spinning"

    @property
    def whole_run(self) -> np.ndarray:
        """Times of the whole run, also of those states that the solution does not hold."""
        return self.times if self.run_times is None else self.run_times

    def derivative(self, state: str) -> np.ndarray:
        """Total design derivative of q, v, a or multipliers, (n_t, ..., n_x).

        Raises
        ------
        NeedsDirectError
            The run did not compute it.
        """
        found: np.ndarray = getattr(self, f"d{state}")
        if found.shape[-1] != self.system.n_x:
            raise NeedsDirectError(f"the run computed no derivatives of {state}, which a response whose length is zero needs")
        return found

    def coordinates(self, body: str) -> slice:
        """Places of a body's coordinates on the second axis of q, v, a; of a cut body those of all its parts."""
        first, written = self.system.numbering.first, self.system.scene.bodies.get(body)
        if isinstance(written, CutBody):
            return slice(first[body], first[body] + written.starts[-1])
        later = [start for start in first.values() if start > first[body]]
        return slice(first[body], min(later, default=self.system.n_q))


class MarkerStates:
    """Markers of a system in one state after the other, with memory and formulas that are looked up once.

    Parameters
    ----------
    system
        Whose markers.
    """

    def __init__(self, system: System) -> None:
        markers = system.plan.markers
        self.found: MarkerState | SpatialMarkerState = markers.state(system.dtype)
        """Poses, rates and accelerations of all markers in the last state, with their derivatives."""
        self.system = system
        self._state: np.ndarray = np.zeros((3, system.n), system.dtype)
        scratch: np.ndarray = np.zeros((3, 3), system.dtype)
        given = markers.plane, markers.frames, markers, self.found, *self._state
        self._formulas = [
            system.prepared(update_poses, *given, True, scratch),
            system.prepared(update_pose_designs, *given, scratch),
        ]

    def at(self, q: np.ndarray, v: np.ndarray | float = 0.0, a: np.ndarray | float = 0.0) -> MarkerState | SpatialMarkerState:
        """State of all markers at coordinates, rates and accelerations (n_q,); holds until the next call."""
        for own, given in zip(self._state, (q, v, a), strict=True):
            own[: self.system.n_q] = given
        for formula in self._formulas:
            formula()
        return self.found


def marker_states(system: System, q: np.ndarray) -> MarkerState | SpatialMarkerState:
    """State of all markers at coordinates (n_q,), at rest."""
    return MarkerStates(system).at(q)


def poses_at(system: System, states: Iterable[np.ndarray]) -> np.ndarray:
    """Poses of all markers at coordinates (n_q,) of several states: (n_t, n_m, p), 3 or 12 numbers each."""
    markers = MarkerStates(system)
    return np.array([np.real(markers.at(q).y).copy() for q in states])


def flexible_body(scene: ResolvedScene, body: str) -> ModelBody:
    """Flexible body of that name.

    Raises
    ------
    InputError
        There is no such body, or it is not flexible; lists those that are.
    """
    found = scene.body(body)
    if not isinstance(found, ModelBody):
        flexible = [name for name, each in scene.bodies.items() if isinstance(each, ModelBody)]
        raise InputError(
            f"body {body!r} is not flexible, so it has no stress or shape; flexible bodies: {', '.join(flexible) or 'none'}."
        )
    return found


def deforming(scene: ResolvedScene) -> dict[str, ModelBody]:
    """Flexible bodies that have coordinates; of a cut body its parts."""
    return {
        name: body for name, body in scene.all_bodies().items() if isinstance(body, ModelBody) and not isinstance(body, CutBody)
    }


def elastic_coordinates(solution: Solution, body: str) -> slice | np.ndarray:
    """Places of a body's elastic coordinates on the second axis of q.

    They are a slice, or the numbers of those of all parts of a cut body.
    """
    if isinstance(found := solution.system.scene.bodies.get(body), CutBody):
        return solution.system.numbering.first[body] + found.elastic_places
    whole = solution.coordinates(body)
    return slice(whole.start + flexible_body(solution.system.scene, body).frame_size, whole.stop)


def design_point(scene: ResolvedScene, body: str, *parts: str) -> DesignPoint:
    """The reduced model of a flexible body at the scene's parameter values; `parts` as of `Scene.model`."""
    return flexible_body(scene, body).design_point(scene, *parts)


def is_in_pieces(scene: ResolvedScene, body: str) -> bool:
    """Whether a flexible body, or that which it is part of, is a solid in pieces."""
    return scene.model(flexible_body(scene, body).model).in_pieces


def elements_of(scene: ResolvedScene, body: str) -> str:
    """Word by which a flexible body, or a part of one, calls its elements."""
    return scene.model(flexible_body(scene, body).model).elements_called


def used_interfaces(scene: ResolvedScene, body: str) -> list[str]:
    """Interface points of a flexible body's reduced model that the scene has points at, in order."""
    known = design_point(scene, body, "interfaces").model.interfaces or {}
    mine = {point.interface for point in scene.points.values() if isinstance(point, BodyPoint) and point.body == body}
    return sorted(mine & {*known})


def spins_of(solution: Solution, body: str, instants: slice | np.ndarray = slice(None)) -> np.ndarray:
    """Angular velocity (n_t, 3) of a flexible body's frame at some instants of a run, in the axes of its reduced model."""
    where, found = solution.coordinates(body), flexible_body(solution.system.scene, body)
    return found.spins(np.real(solution.q[instants][:, where]), np.real(solution.v[instants][:, where]))
