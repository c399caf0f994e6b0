"""States of the markers, the points of bodies that something grips or looks at."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from toolkit.markers.poses import update_pose_designs, update_poses
from toolkit.system.system import System


class MarkerStates:
    """Markers of a system in one state after the other, with memory and formulas that are looked up once.

    Parameters
    ----------
    system
        Whose markers.
    """

    def __init__(self, system: System) -> None:
        markers = system.plan.markers
        self.found: Any = markers.state(system.dtype)
        """Poses, rates and accelerations of all markers in the last state, with their derivatives."""
        self.system = system
        self._state: np.ndarray = np.zeros((3, system.n), system.dtype)
        scratch: np.ndarray = np.zeros((3, 3), system.dtype)
        given = markers.plane, markers.frames, markers, self.found, *self._state
        self._formulas = [
            system.prepared(update_poses, *given, True, scratch),
            system.prepared(update_pose_designs, *given, scratch),
        ]

    def at(self, q: np.ndarray, v: np.ndarray | float = 0.0, a: np.ndarray | float = 0.0) -> Any:
        """State of all markers at coordinates, rates and accelerations (n_q,); holds until the next call."""
        for own, given in zip(self._state, (q, v, a), strict=True):
            own[: self.system.n_q] = given
        for formula in self._formulas:
            formula()
        return self.found


def marker_states(system: System, q: np.ndarray) -> Any:
    """State of all markers at coordinates (n_q,), at rest."""
    return MarkerStates(system).at(q)


def poses_at(system: System, states: Iterable[np.ndarray]) -> np.ndarray:
    """Poses of all markers at coordinates (n_q,) of several states: (n_t, n_m, p), 3 or 12 numbers each."""
    markers = MarkerStates(system)
    return np.array([np.real(markers.at(q).y).copy() for q in states])
