"""In space too: written velocities hold or are refused, the others are found by the joints."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.models.starts import derivatives_agree, started
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import SpatialRigid, SpatialRod
from toolkit.components.joints.distance import SpatialDistance
from toolkit.components.joints.prismatic import Prismatic
from toolkit.components.joints.revolute import SpatialRevolute
from toolkit.components.joints.spherical import Spherical
from toolkit.components.joints.universal import Universal
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene
from toolkit.validity.start_cautions import cautions_of_start, moved_bodies, start_record

EXACT = 1e-12
"""Round-off of a solve, of velocities of order one; for derivatives, judged by a complex step, 1e-10."""
PLACES = {"O": (0.0, 0.0, 0.0), "A": (0.1, 0.5, 0.2), "B": (1.2, 0.2, 0.1)}
AXIS, GUIDE = np.array([0.1, 0.2, 1.0]), np.array([1.0, 0.3, -0.2])
UNIT = AXIS / np.linalg.norm(AXIS)


def slider_crank(solver: dict[str, Any] | None = None, **motion: dict[str, Any]) -> Scene:
    """A crank about an oblique axis, a rod with a ball and a cross, a slider on an oblique guide."""
    cross = ((0.0, 1.0, 0.3), (0.0, -0.3, 1.0))
    return Scene(
        units="m-kg-s",
        dimension=3,
        points={name: Point(x=x, y=y, z=z) for name, (x, y, z) in PLACES.items()},
        bodies={
            "crank": SpatialRod(between=("O", "A"), area=1e-4, density=7800.0, **motion.get("crank", {})),
            "rod": SpatialRod(between=("A", "B"), area=1e-4, density=7800.0, **motion.get("rod", {})),
            "slider": SpatialRigid(mass=0.3, inertia=(1e-3, 1e-3, 1e-3), center="B", **motion.get("slider", {})),
        },
        joints={
            "O": SpatialRevolute(bodies=("crank", "ground"), point="O", axis=tuple(AXIS)),
            "A": Spherical(bodies=("crank", "rod"), point="A"),
            "B": Universal(bodies=("rod", "slider"), point="B", axes_of_cross=cross),
            "guide": Prismatic(bodies=("slider", "ground"), point="B", axis=tuple(GUIDE)),
        },
        solver=RunOptions(**({"end_time": 0.01, "step": 0.001} | (solver or {}))),
    )


def slides(omega: float) -> float:
    """Speed along the guide for a rate of the crank: B keeps its distance from A."""
    A, B = np.array(PLACES["A"]), np.array(PLACES["B"])
    guide = GUIDE / np.linalg.norm(GUIDE)
    return float((B - A) @ np.cross(omega * UNIT, A) / ((B - A) @ guide))


def spin(omega: float) -> tuple[float, float, float]:
    x, y, z = map(float, omega * UNIT)
    return x, y, z


def test_a_crank_starts_with_what_it_is_given_and_the_joints_find_the_rest():
    run = simulate(compile_scene(slider_crank(crank={"angular_velocity": spin(6.0)})))
    record, guide = start_record(run), GUIDE / np.linalg.norm(GUIDE)
    np.testing.assert_allclose(record["crank"]["angular_velocity"]["used"], 6.0 * UNIT, atol=EXACT)
    np.testing.assert_allclose(record["crank"]["velocity"]["used"], np.cross(6.0 * UNIT, PLACES["A"]) / 2, atol=EXACT)
    np.testing.assert_allclose(record["slider"]["velocity"]["used"], slides(6.0) * guide, atol=EXACT)
    np.testing.assert_allclose(record["slider"]["angular_velocity"]["used"], 0, atol=EXACT)
    assert record["crank"]["angular_velocity"]["written"] == pytest.approx(spin(6.0))
    assert record["rod"]["velocity"]["written"] is None


def test_a_body_without_coordinates_starts_without_velocities():
    """It stands before a body that has some."""
    scene = slider_crank(crank={"angular_velocity": spin(6.0)})
    anchor = SpatialRigid(mass=1.0, inertia=(1.0, 1.0, 1.0), center="O", frame="grounded")
    run = simulate(compile_scene(scene.model_copy(update={"bodies": {"anchor": anchor, **scene.bodies}})))
    assert start_record(run)["anchor"] == {}
    assert moved_bodies(run)["anchor"] == (0.0, 0.0)
    assert list(cautions_of_start(run)) == []


def test_velocities_of_several_bodies_that_fit_hold():
    guide = tuple(map(float, slides(6.0) * GUIDE / np.linalg.norm(GUIDE)))
    scene = slider_crank(crank={"angular_velocity": spin(6.0)}, slider={"velocity": guide, "angular_velocity": (0.0, 0.0, 0.0)})
    record = start_record(simulate(compile_scene(scene)))
    np.testing.assert_allclose(record["crank"]["angular_velocity"]["used"], 6.0 * UNIT, atol=EXACT)
    np.testing.assert_allclose(record["slider"]["velocity"]["used"], guide, atol=EXACT)


def test_velocities_that_contradict_are_refused_with_both():
    guide = tuple(map(float, GUIDE))
    with pytest.raises(InputError, match=r"bodies\.slider\.velocity\.0 is written as 1 m/s at the start, but .* allow .* m/s"):
        started(slider_crank(crank={"angular_velocity": spin(6.0)}, slider={"velocity": guide}))
    with pytest.raises(InputError, match=r"crank\.angular_velocity is written as \[1, 0, 0\] rad/s .* allow \[.*\] rad/s"):
        started(slider_crank(crank={"angular_velocity": (1.0, 0.0, 0.0)}))


def test_the_start_is_differentiated():
    """The third number of the angular velocity alone would tilt it against the axis."""
    scene = slider_crank(crank={"angular_velocity": spin(6.0)})
    derivatives_agree(scene, ["points.A.x", "points.B.z", "points.O.y", "bodies.rod.density"])
    with pytest.raises(
        InputError, match=r"'bodies\.crank\.angular_velocity\.2' would make .*angular_velocity contradict the joints"
    ):
        started(scene, ["bodies.crank.angular_velocity.2"])


def pendulum(**motion: Any) -> Scene:
    """A rod on a ball joint at A, with a bar from its end B to Q that is shorter than their distance."""
    return Scene(
        units="m-kg-s",
        dimension=3,
        points={name: Point(x=x, y=y, z=z) for name, (x, y, z) in (PLACES | {"Q": (1.2, 0.6, 0.0)}).items()},
        bodies={"rod": SpatialRod(between=("A", "B"), area=1e-4, density=7800.0, **motion)},
        joints={
            "A": Spherical(bodies=("rod", "ground"), point="A"),
            "bar": SpatialDistance(bodies=("rod", "ground"), points=("B", "Q"), length=0.35),
        },
        solver=RunOptions(end_time=0.01, step=0.001, assemble=True),
    )


def test_a_body_that_assembly_turns_keeps_its_angular_velocity_in_its_own_axes():
    """It spins about its own axis, which the bar allows wherever the rod is; the quaternion's rate as written would not fit it."""
    A, B = np.array(PLACES["A"]), np.array(PLACES["B"])
    scene = pendulum(angular_velocity=tuple(map(float, 2.0 * (B - A) / np.linalg.norm(B - A))))
    run = simulate(compile_scene(scene))
    middle = run.q[0, :3]
    along = (middle - A) / np.linalg.norm(middle - A)
    np.testing.assert_allclose(start_record(run)["rod"]["angular_velocity"]["used"], 2.0 * along, atol=1e-11)  # of the closing
    assert np.abs(along - (B - A) / np.linalg.norm(B - A)).max() > 0.01
    derivatives_agree(scene, ["joints.bar.length"])


def test_by_how_much_assembly_turns_a_body_is_told_and_differentiated():
    scene = pendulum()
    run = simulate(compile_scene(scene))
    (caution,) = cautions_of_start(run)
    shift, turn = moved_bodies(run)["rod"]
    assert (caution.code, caution.doubt) == ("assembled", False)
    assert f"'rod' by {shift:.3g} m and {turn:.3g} rad" in caution.text
    # the middle of the rod, which does not spin, goes along a chord of half its length
    half = np.linalg.norm(np.subtract(PLACES["B"], PLACES["A"])) / 2
    assert shift == pytest.approx(2 * half * np.sin(turn / 2), rel=1e-3)  # it does, by the mass of a round rod, a little
    derivatives_agree(scene, ["joints.bar.length", "points.B.x", "points.Q.z"])
