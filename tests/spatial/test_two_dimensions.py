"""Planar and spatial scenes in one process: each runs with the loop compiled for it."""

from __future__ import annotations

import numpy as np

from tests.spatial.scenes import at
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import Rigid, SpatialRigid
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene


def test_plane_space_plane_space():
    body = {"body": Rigid(mass=1.0, inertia=1.0, center="C", velocity=(1.0, 0.0, 0.0))}
    flat = Scene(units="m-kg-s", points={"C": Point(x=0.0, y=0.0)}, bodies=body)
    body = {"body": SpatialRigid(mass=1.0, inertia=(1.0, 1.0, 1.0), center="C", velocity=(1.0, 0.0, 0.0))}
    spatial = Scene(units="m-kg-s", dimension=3, points=at(C=(0, 0, 0)), bodies=body)
    for scene in (flat, spatial, flat, spatial):
        run = simulate(compile_scene(scene), RunOptions(end_time=1.0, step=0.5))
        np.testing.assert_allclose(run.q[:, 0], [0, 0.5, 1.0], atol=1e-14)  # round-off
