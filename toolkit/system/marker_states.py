"""Where the points of bodies are that something grips or looks at."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.equations.equations import allocate_work
from toolkit.markers.poses import update_pose_designs, update_poses
from toolkit.system.system import System


def marker_states(system: System, q: np.ndarray) -> Any:
    """All markers at coordinates (n_q,), at rest."""
    work, markers = allocate_work(system.plan, system.dtype), system.plan.markers
    rest: np.ndarray = np.zeros(system.n, system.dtype)
    padded = np.concatenate([q, rest[system.n_q :]])
    for function in (update_poses, update_pose_designs):
        system.run(function, markers.plane, markers.frames, markers, work.markers, padded, rest, rest, work.scratch)
    return work.markers
