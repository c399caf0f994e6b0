"""Bushings: closed forms, and energy and momenta from the states alone, with rotations by another library."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import ffrf
from ffrf import plane, space
from tests.models.directions import along, derivative_along, felt_direction
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.transient import simulate
from toolkit.description.run_options import RunOptions
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene

STIFFNESS, TURNING = np.array([400.0, 150.0, 900.0]), np.array([6.0, 11.0, 3.0])
MASS, INERTIA = np.array([1.3, 0.8]), np.array([0.05, 0.02])
PLACES = np.array([[0.0, 0.1, -0.1], [0.5, -0.2, 0.3]])
POINT = np.array([0.2, 0.05, 0.1])


def points(**places: np.ndarray) -> dict:
    return {name: plane.Point(**dict(zip("xyz", map(float, place), strict=False))) for name, place in places.items()}


def flying(dimension: int, **damping) -> ffrf.Scene:
    """Two free bodies that fly apart and turn, tied by a bushing aside of both centres."""
    axes = dimension
    bodies: dict = {}
    for k, (name, center) in enumerate((("one", "P"), ("two", "Q"))):
        push = tuple((1 - 2 * k) * np.array([0.1, 0.2, -0.15]) / MASS[k] + np.array([0.3, -0.2, 0.1]))
        if axes == 2:
            bodies[name] = plane.Rigid(mass=MASS[k], inertia=INERTIA[k], center=center, velocity=(*push[:2], 2.0 - 3 * k))
        else:
            spin = (0.4 - k, 0.5, 0.3 * k)
            inertia = (float(INERTIA[k]),) * 3
            bodies[name] = space.Rigid(mass=MASS[k], inertia=inertia, center=center, velocity=push, angular_velocity=spin)
    turning = 7.0 if axes == 2 else tuple(TURNING)
    kind = plane.Bushing if axes == 2 else space.Bushing
    numbers = {"stiffness": tuple(STIFFNESS[:axes]), "rotational_stiffness": turning, **damping}
    return ffrf.Scene(
        units="m-kg-s",
        dimension=dimension,
        points=points(P=PLACES[0][:axes], Q=PLACES[1][:axes], B=POINT[:axes]),
        bodies=bodies,
        loads={"bushing": kind(bodies=("one", "two"), point="B", **numbers)},
    )


def run(scene: ffrf.Scene, step: float, end_time: float = 0.5) -> Solution:
    return simulate(compile_scene(scene), RunOptions(end_time=end_time, step=step, rho_inf=1.0))


def balance_in_plane(found: Solution) -> np.ndarray:
    """Energy, momentum and angular momentum about the origin, (n_t, 4)."""
    q, v = found.q.reshape(-1, 2, 3), found.v.reshape(-1, 2, 3)
    turned = np.exp(1j * q[:, :, 2])
    places = q[:, :, 0] + 1j * q[:, :, 1] + turned * ((POINT[0] - PLACES[:, 0]) + 1j * (POINT[1] - PLACES[:, 1]))
    offset = (places[:, 0] - places[:, 1]) * np.conj(turned[:, 0])
    stored = STIFFNESS[0] * offset.real**2 + STIFFNESS[1] * offset.imag**2 + 7.0 * (q[:, 0, 2] - q[:, 1, 2]) ** 2
    energy = ((v[:, :, :2] ** 2).sum(axis=2) @ MASS + v[:, :, 2] ** 2 @ INERTIA + stored) / 2
    momentum = np.einsum("k,tkc->tc", MASS, v[:, :, :2])
    spin = (q[:, :, 0] * v[:, :, 1] - q[:, :, 1] * v[:, :, 0]) @ MASS + v[:, :, 2] @ INERTIA
    return np.column_stack([energy, momentum, spin])


def balance_in_space(found: Solution) -> np.ndarray:
    """Energy, momentum and angular momentum about the origin, (n_t, 7); rotations by scipy, whose quaternions end with the real part."""
    q, v = found.q.reshape(-1, 2, 7), found.v.reshape(-1, 2, 7)
    turned = [Rotation.from_quat(q[:, k][:, [4, 5, 6, 3]]) for k in range(2)]
    places = [q[:, k, :3] + turned[k].apply(POINT - PLACES[k]) for k in range(2)]
    rates = [_spin(q[:, k, 3:], v[:, k, 3:]) for k in range(2)]
    offset = turned[0].inv().apply(places[0] - places[1])
    vector = (turned[1].inv() * turned[0]).as_rotvec()
    angle = np.linalg.norm(vector, axis=1, keepdims=True)
    chord = vector * np.sinc(angle / 2 / np.pi)  # 2 sin(angle / 2) along the axis
    energy = (offset**2 @ STIFFNESS + chord**2 @ TURNING) / 2
    momentum, angular = np.zeros((2, len(q), 3))
    for k in range(2):
        energy = energy + MASS[k] * (v[:, k, :3] ** 2).sum(axis=1) / 2 + INERTIA[k] * (rates[k] ** 2).sum(axis=1) / 2
        momentum += MASS[k] * v[:, k, :3]
        angular += MASS[k] * np.cross(q[:, k, :3], v[:, k, :3]) + INERTIA[k] * rates[k]
    return np.column_stack([energy, momentum, angular])


def _spin(p: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Angular velocity in space, the vector part of 2 p' p*."""
    return 2 * (p[:, :1] * rate[:, 1:] - rate[:, :1] * p[:, 1:] - np.cross(rate[:, 1:], p[:, 1:]))


@pytest.mark.parametrize(("dimension", "balance"), [(2, balance_in_plane), (3, balance_in_space)])
def test_a_bushing_keeps_energy_and_momenta(dimension, balance):
    """Its force is the gradient of what it stores, and what it does to one body it does to the other, moments included."""
    drifts = []
    for step in (5e-4, 2.5e-4):
        found = balance(run(flying(dimension), step))
        drifts.append(np.ptp(found, axis=0) / np.abs(found).max(axis=0))
    assert drifts[1][0] < 3e-4  # second order: (100 rad/s x 2.5e-4)^2 / 4 of what swings
    assert 3.5 < drifts[0][0] / drifts[1][0] < 4.5
    assert max(drifts[1][1 : dimension + 1]) < 1e-9  # linear in the velocities, so kept to Newton's tolerance
    assert max(drifts[1][dimension + 1 :]) < 1e-4  # second order, as the energy
    states = run(flying(dimension), 1e-3).q
    assert np.ptp(states, axis=0).max() > 0.1  # they do move


@pytest.mark.parametrize(("dimension", "balance"), [(2, balance_in_plane), (3, balance_in_space)])
def test_a_damped_bushing_takes_energy_and_no_momentum(dimension, balance):
    turning = 0.3 if dimension == 2 else (0.3, 0.2, 0.1)
    scene = flying(dimension, damping=(5.0, 3.0, 8.0)[:dimension], rotational_damping=turning)
    found = balance(run(scene, 2.5e-4))
    assert max(np.diff(found[:, 0])) < 1e-7 * found[0, 0]
    assert found[-1, 0] < 0.9 * found[0, 0]
    drift = np.ptp(found[:, 1:], axis=0) / np.abs(found[:, 1:]).max(axis=0)
    assert max(drift) < 1e-4  # as without damping


def pressed(load: dict) -> ffrf.Scene:
    """A body on a bushing of the ground, which is body a, so that the axes stay those of space."""
    return ffrf.Scene(
        units="m-kg-s",
        dimension=3,
        points=points(B=POINT),
        bodies={"one": space.Rigid(mass=1.0, inertia=(0.1, 0.1, 0.1), center="B")},
        loads={
            "bushing": space.Bushing(
                bodies=("ground", "one"), point="B", stiffness=tuple(STIFFNESS), rotational_stiffness=tuple(TURNING)
            ),
            **load,
        },
        responses={
            "z": space.Displacement(body="one", point="B", component="z"),
            "turned": space.Rotation(body="one", point="B", axis=(0.0, 1.0, 0.0)),
        },
    )


def test_a_pressed_and_turned_bushing_gives_way_by_force_over_stiffness_and_the_sine_of_torque_over_stiffness():
    """z = F / k_3, sin(angle) = M / k_5, and their derivatives by both."""
    force, torque = 2.7, 0.45 * TURNING[1]
    scene = pressed(
        {
            "push": space.PointForce(body="one", point="B", force=(0.0, 0.0, force)),
            "twist": space.Torque(body="one", point="B", torque=(0.0, torque, 0.0)),
        }
    )
    paths = ["loads.bushing.stiffness.2", "loads.bushing.rotational_stiffness.1", "loads.bushing.stiffness.0"]
    found = gradients_by("direct", scene, paths, "static")
    angle = np.arcsin(torque / TURNING[1])
    assert found.values["z"] == pytest.approx(force / STIFFNESS[2], rel=1e-9)
    assert found.values["turned"] == pytest.approx(angle, rel=1e-9)
    assert found.gradients["z"][paths[0]] == pytest.approx(-force / STIFFNESS[2] ** 2, rel=1e-9)
    assert found.gradients["turned"][paths[1]] == pytest.approx(-np.tan(angle) / TURNING[1], rel=1e-9)
    assert found.gradients["z"][paths[2]] == pytest.approx(0, abs=1e-15)


def test_a_bushing_that_is_turned_far_is_doubted_and_one_that_is_not_is_trusted():
    for part, doubted in ((0.55, True), (0.45, False)):  # 33 and 27 degrees
        scene = pressed({"twist": space.Torque(body="one", point="B", torque=(0.0, part * float(TURNING[1]), 0.0))})
        found = ffrf.compile(scene).statics()
        doubts = {each.code for each in found.verdict.warnings if each.doubt}
        assert doubts - {"unstable-vibration"} == (
            {"bushing-turned-far"} if doubted else set()
        )  # a torque that stays in space flutters


def test_a_damped_bushing_swings_as_the_closed_form_says():
    """x = exp(-d t) (cos(w t) + d / w sin(w t)) x_0, d = c / 2 m, w^2 = k / m - d^2."""
    k, c, mass = 250.0, 6.0, 1.7
    scene = ffrf.Scene(
        units="m-kg-s",
        points=points(P=np.array([0.3, 0.1]), B=np.array([0.25, 0.1])),
        bodies={"one": plane.Rigid(mass=mass, inertia=0.1, center="P")},
        loads={"bushing": plane.Bushing(bodies=("one", "ground"), point=("P", "B"), stiffness=(k, 0.0), damping=(c, 0.0))},
    )
    d = c / (2 * mass)
    w, errors = np.sqrt(k / mass - d**2), []
    for step in (2e-3, 1e-3):
        found = run(scene, step, 1.0)
        exact = 0.05 * np.exp(-d * found.times) * (np.cos(w * found.times) + d / w * np.sin(w * found.times))
        errors.append(np.abs(found.q[:, 0] - 0.25 - exact).max() / 0.05)
    assert errors[1] < 1e-4  # second order: (12 rad/s x 1 ms)^2 / 12, over two periods
    assert 3.8 < errors[0] / errors[1] < 4.2


@pytest.mark.parametrize("dimension", [2, 3])
def test_gradients_of_a_motion_by_all_numbers_of_a_bushing_are_those_of_the_complex_step(dimension):
    turning = 0.3 if dimension == 2 else (0.3, 0.2, 0.1)
    scene = flying(dimension, damping=(5.0, 3.0, 8.0)[:dimension], rotational_damping=turning)
    response = {"x": plane.Displacement(body="one", point="P", component="x")}
    scene = scene.model_copy(update={"responses": response, "solver": RunOptions(end_time=0.02, step=1e-3)})
    paths = [f"loads.bushing.{path}" for path, _ in scene.loads["bushing"].numbers()]
    assert len(paths) == (6 if dimension == 2 else 12)
    paths += ["points.B.x", "points.Q.y"]
    found = gradients_by("direct", scene, paths, "transient")
    ours = found.gradients["x"]
    largest, factors = max(map(abs, ours.values())), felt_direction({"x": ours}, 0.1, 0.1)
    judge = derivative_along(scene, factors, "transient", found.solution)["x"]
    # both to the Newton tolerance; a small derivative is as exact as one that is ten times smaller than the largest
    assert along(ours, factors) == pytest.approx(judge, rel=0, abs=1e-8 * largest)
    assert all(ours[path] for path in paths[:2])


@pytest.mark.parametrize("kind", [plane.Bushing, space.Bushing])
def test_what_no_bushing_can_be_is_refused(kind):
    with pytest.raises(ValueError, match="a bushing acts between two different bodies, not on 'one' alone"):
        kind(bodies=("one", "one"), point="B", stiffness=(1.0, 0.0, 0.0)[: kind.dimension])
    with pytest.raises(ValueError, match="greater than or equal to 0"):
        kind(bodies=("one", "two"), point="B", stiffness=(-1.0, 0.0, 0.0)[: kind.dimension])
