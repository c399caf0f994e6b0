"""Where the points of bodies are that something grips or looks at."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.markers.poses import update_pose_designs, update_poses
from toolkit.system.system import System


def marker_states(system: System, q: np.ndarray) -> Any:
    """All markers at coordinates (n_q,), at rest."""
    markers, state = system.plan.markers, system.plan.markers.state(system.dtype)
    rest: np.ndarray = np.zeros(system.n, system.dtype)
    scratch: np.ndarray = np.zeros((3, 3), system.dtype)
    padded = np.concatenate([q, rest[system.n_q :]])
    for function in (update_poses, update_pose_designs):
        system.run(function, markers.plane, markers.frames, markers, state, padded, rest, rest, scratch)
    return state
