"""Starts of a motion, and their derivatives against complex steps through all that finds them, in the plane and in space."""

from __future__ import annotations

import numpy as np

from toolkit.scene.scene import Scene
from toolkit.solvers.start.initial_conditions import State, consistent_start
from toolkit.system.system import System, compile_scene

LEVELS = np.array([1.0, 0.0, 0.0])


def started(scene: Scene, design: list[str] | None = None) -> tuple[System, State]:
    system = compile_scene(scene, design)
    return system, consistent_start(system, LEVELS)


def derivatives_agree(scene: Scene, design: list[str]) -> None:
    """dq_0, dv_0 and [da_0; dlam_0] against a complex step through the whole start."""
    state = started(scene, design)[1]
    for x, path in enumerate(design):
        stepped = started(scene.with_number(path, scene.number(path) + 1e-30j))[1]
        for name in ("q", "v", "acc"):
            exact = np.imag(getattr(stepped, name)) / 1e-30
            ours = getattr(state, f"d{name}")[:, x]
            np.testing.assert_allclose(ours, exact, rtol=0, atol=1e-10 * max(1.0, np.abs(exact).max()), err_msg=f"{path} {name}")
