"""Joints that turn about an axis hold as firmly at every angle, a right angle among them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ffrf
from ffrf import space
from toolkit.foundation.kinematics.orientation import quaternion_of
from toolkit.system.redundant_joints import joint_terms
from toolkit.system.system import compile_scene

BRACKET = Path(__file__).parents[2] / "models" / "spatial_bracket" / "scene.toml"
AXIS = np.array([0.3, -0.2, 1.0]) / np.sqrt(1.13)


@pytest.mark.parametrize("kind", [space.Revolute, space.Cylindrical])
@pytest.mark.parametrize("degrees", [0, 30, 89.9, 90, 135, 180, 270])
def test_the_constraints_are_as_independent_as_at_the_start(kind, degrees):
    """By symmetry about the axis the singular values of the Jacobian do not depend on the angle at all."""
    wheel = space.Rigid(mass=1.0, inertia=(1.0, 1.0, 1.0), center="O")
    hinge = kind(bodies=("wheel", "ground"), point="O", axis=tuple(AXIS))
    points = {"O": space.Point(x=0.1, y=0.2, z=0.3)}
    scene = ffrf.Scene(units="m-kg-s", dimension=3, points=points, bodies={"wheel": wheel}, joints={"hinge": hinge})
    system = compile_scene(scene)

    def sizes(angle: float) -> np.ndarray:
        q = system.start()[0].copy()
        q[3:7] = quaternion_of(angle * AXIS)
        jacobian = system.matrix(joint_terms(system, q, 0 * q).I_acc).toarray()[
            system.n_q : system.n_q + len(hinge.rows), : system.n_q
        ]
        return np.linalg.svd(jacobian, compute_uv=False)

    np.testing.assert_allclose(sizes(np.radians(degrees)), sizes(0.0), rtol=1e-12)


def test_a_crank_rests_at_a_right_angle_as_it_does_beside_it():
    """The crank of the bracket is led to 90 degrees at 20 ms: the equilibrium there lies between its neighbours, to second order."""
    before, at, after = (
        ffrf.compile(ffrf.read_scene(BRACKET, {"solver.end_time": time})).statics().values["stress"]
        for time in (0.0199, 0.02, 0.0201)
    )
    assert at == pytest.approx((before + after) / 2, rel=1e-4)  # the stress bends by 2e-5 over this part of a turn
