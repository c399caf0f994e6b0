"""Responses: aggregation, stress, shape error, marker motion, energies; their values against independent formulas."""

from dataclasses import replace

import numpy as np
import pytest

from tests.models.scenes import WING, hanging_skin
from toolkit.analyses.sensitivity.adjoint import adjoint
from toolkit.analyses.sensitivity.direct import direct, numerical
from toolkit.analyses.sensitivity.preparation import prepare, solve, values_of
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.file import load, save
from toolkit.responses.energy import KineticEnergy
from toolkit.responses.extremes import TimeMax
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.over_time import TimeIntegral, TimeMean, TimeMeanSquare
from toolkit.responses.response import magnitude
from toolkit.responses.shape_error import ShapeMax, ShapeMSE, ShapeRMS, gaps, shape_error, shape_error_history
from toolkit.responses.stress import KSStress, MaxStress, gap_bound, kreisselmeier_steinhauser, stress_field
from toolkit.scene.changed_numbers import with_numbers
from toolkit.scene.resolution import loaded


@pytest.fixture(scope="module")
def wing():
    scene = read_scene(WING)
    return solve(prepare(scene, list(scene.design)), "static")


@pytest.fixture(scope="module")
def hanging():
    return solve(prepare(hanging_skin()), "transient")


def test_ks_is_an_upper_bound_within_its_gap_that_tightens_with_aggregation():
    values = np.random.default_rng(1).normal(size=100)
    sharp, soft = (kreisselmeier_steinhauser(values, each)[0] for each in (200, 50))
    assert values.max() <= sharp <= soft <= values.max() + gap_bound(100, 50)
    assert sharp <= values.max() + gap_bound(100, 200)


def test_ks_survives_values_whose_exponentials_overflow():
    value, weights = kreisselmeier_steinhauser(np.array([1e6, 1e6, -1e6]), 200.0)
    assert value == pytest.approx(1e6 + np.log(2) / 200, rel=1e-15)  # two equal largest values
    assert weights.tolist() == [0.5, 0.5, 0.0]


def test_ks_weights_are_its_derivative():
    values = np.random.default_rng(2).normal(size=20)
    _, weights = kreisselmeier_steinhauser(values, 3.0)
    for k in range(20):
        step = values + 1e-30j * (np.arange(20) == k)
        exact = np.imag(kreisselmeier_steinhauser(step, 3.0)[0]) / 1e-30
        assert weights[k] == pytest.approx(exact, rel=1e-13)  # round-off of 20 exponentials


def test_dimensionless_ks_does_not_depend_on_the_unit_of_stress(wing):
    in_mpa = KSStress(body="skin", aggregation=200.0, reference_stress=60.0).value(wing)
    assert in_mpa == pytest.approx(KSStress(body="skin", aggregation=200.0 / 60.0).value(wing), rel=1e-14)


def test_ks_remark_tells_gap_and_bound(wing):
    assert "exceeds the true maximum by" in KSStress(body="skin", aggregation=200.0).remark(wing)


def test_absolute_stress_counts_compression_too(wing):
    stress, _ = stress_field(wing, "skin")
    assert MaxStress(body="skin").value(wing) == stress.max()
    assert MaxStress(body="skin", measure="absolute").value(wing) == np.abs(stress).max() > stress.max()


def test_stress_field_and_its_gradient_belong_together(wing):
    stress, derivative = stress_field(wing, "skin")
    place = np.unravel_index(np.argmax(stress), stress.shape)
    assert derivative.shape == (*stress.shape, 5)
    np.testing.assert_allclose(derivative[place], MaxStress(body="skin").gradient(wing), rtol=1e-12)  # same sums, other order


def test_rms_and_mse_are_those_of_the_distances_per_node(wing):
    error, derivative = shape_error(wing, "skin")
    assert error.shape == (31,)
    assert ShapeRMS(body="skin").value(wing) == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-14)
    assert ShapeMSE(body="skin").value(wing) == pytest.approx(np.mean(error**2), rel=1e-14)
    free = error > 0
    mean = 2 * np.mean(np.where(free[:, None], error[:, None] * np.nan_to_num(derivative), 0), axis=0)
    np.testing.assert_allclose(ShapeMSE(body="skin").gradient(wing), mean, rtol=1e-10)  # node by node against squared errors


def test_the_curvature_of_the_mean_square_is_that_of_gaps_that_grow_linearly(wing):
    """v^T H v = 2/n |dgap/dv|^2, by differences of the gaps of designs on both sides, whose error is the square of the step."""
    curvature = ShapeMSE(body="skin").curvature(wing)
    scene = wing.system.scene
    along = np.array([0.01, -0.02, 0.01, 0.05, -0.03]) * [scene.value_of(name) for name in scene.design]
    sides = [
        {name: scene.value_of(name) + s * step for name, step in zip(scene.design, along, strict=True)} for s in (1e-3, -1e-3)
    ]
    there = [gaps(solve(prepare(with_numbers(scene, each)[0]), "static"), "skin")[0][0] for each in sides]
    change = (there[0] - there[1]) / 2e-3
    assert along @ curvature @ along == pytest.approx(2 / len(change) * np.sum(change**2), rel=1e-6)
    np.testing.assert_allclose(curvature, curvature.T, rtol=1e-12)


def test_the_distance_over_time_is_that_of_every_step(wing):
    """And its gradient, through the whole motion, by both exact methods."""
    asked = {
        "mean": TimeMean(of=ShapeRMS(body="skin")),
        "largest": TimeMax(of=ShapeMax(body="skin")),
        "half": ShapeRMS(body="skin", time=0.5),
    }
    scene = wing.system.scene.model_copy(update={"responses": asked})
    names = list(scene.design)
    solution = solve(prepare(scene, names), "transient")
    error = shape_error_history(solution, "skin")[0]
    rms = np.sqrt(np.mean(error**2, axis=1))
    # sums in another order
    assert asked["mean"].value(solution) == pytest.approx(np.trapezoid(rms, solution.times) / solution.times[-1], rel=1e-12)
    assert asked["largest"].value(solution) == pytest.approx(error.max(), rel=1e-12)
    assert asked["half"].value(solution) == pytest.approx(rms[np.argmin(np.abs(solution.times - 0.5))], rel=1e-12)
    slopes = np.array([ShapeRMS(body="skin", time=float(t)).gradient(solution) for t in solution.times])
    shares = np.trapezoid(np.eye(len(slopes)), solution.times) / solution.times[-1]
    square = TimeMeanSquare(of=ShapeRMS(body="skin")).curvature(solution)
    np.testing.assert_allclose(square, 2 * slopes.T @ np.diag(shares) @ slopes, rtol=1e-11, atol=1e-12 * np.abs(square).max())
    backwards, forwards = adjoint(scene, names, "transient").gradients, direct(scene, names, "transient").gradients
    for name, slopes in forwards.items():
        assert backwards[name] == pytest.approx(slopes, rel=1e-8), name  # round-off times the condition of the skin's equations


def test_distance_derivative_is_undefined_where_a_node_meets_its_target(wing, tmp_path):
    model = load(WING.parent / "skin.h5")
    position = model.shape.position
    moved = np.einsum("kif,tf->tki", position[:, :, 1:], wing.q[-1:, wing.coordinates("skin")])  # as `gaps` does, to the last bit
    target = position[:, :, 0] + moved[0]
    target[5:] += 0.1
    save(replace(model, shape=replace(model.shape, target=target)), tmp_path / "skin.h5")
    met = replace(wing, system=replace(wing.system, scene=wing.system.scene.model_copy(update={"directory": tmp_path})))
    error, derivative = shape_error(met, "skin")
    assert np.all(error[:5] == 0)
    assert np.all(np.isnan(derivative[:5]))
    assert np.all(np.isfinite(derivative[5:]))
    assert np.all(np.isfinite(ShapeRMS(body="skin").gradient(met)))


def test_shape_error_does_not_depend_on_where_the_body_is(hanging):
    model = load(WING.parent / "skin.h5", ["shape"])
    elastic = np.append(1, hanging.q[-1, hanging.coordinates("skin")][3:])
    distance = np.linalg.norm(model.shape.position @ elastic - model.shape.target, axis=1)
    np.testing.assert_allclose(shape_error(hanging, "skin")[0], distance, rtol=0, atol=1e-13 * distance.max())  # round-off


def test_rotation_of_a_rigid_body_is_its_coordinate(hanging):
    assert Rotation(body="arm", point="O").value(hanging) == hanging.q[-1, hanging.coordinates("arm")][2]


def test_time_that_is_no_step_is_refused(hanging):
    with pytest.raises(InputError, match=r"no time step at t = 0.0042; the nearest is 0.004"):
        Rotation(body="arm", point="O", time=0.0042).value(hanging)


def test_kinetic_energy_of_rigid_bodies_is_that_of_their_mass_properties():
    scene = hanging_skin()
    solution = solve(prepare(scene), "transient")
    arm = solution.v[-1, solution.coordinates("arm")]
    mass, _, inertia = scene.bodies["arm"].mass_properties(loaded(scene))
    block = solution.v[-1, solution.coordinates("block")]
    rigid = (mass * (arm[:2] @ arm[:2]) + inertia * arm[2] ** 2 + 1e-4 * (block[:2] @ block[:2]) + 0.05 * block[2] ** 2) / 2
    whole = KineticEnergy().value(solution)
    model = load(WING.parent / "skin.h5", [])
    q, v = solution.q[-1, solution.coordinates("skin")], solution.v[-1, solution.coordinates("skin")]
    assert whole - rigid == pytest.approx(_floating_energy(model.invariants, q, v), rel=1e-10)  # difference of near numbers


def _floating_energy(inv, q, v):
    """v^T M v / 2 with the block mass matrix of theory section 1, written out."""
    c, s = np.cos(q[2]), np.sin(q[2])
    A, J = np.array([[c, -s], [s, c]]), np.array([[0.0, -1.0], [1.0, 0.0]])
    z, dz = np.append(1, q[3:]), np.append(0, v[3:])
    N, G, H = inv.first_moment, inv.inertia, inv.gyroscopic
    translation = v[:2] @ (inv.mass * v[:2] / 2 + A @ J @ N @ z * v[2] + A @ N @ dz)
    return translation + v[2] * (z @ G @ z * v[2] / 2 + z @ H @ dz) + dz @ G @ dz / 2


def test_integral_of_an_energy_is_the_trapezoidal_sum(hanging):
    values = [KineticEnergy(time=t).value(hanging) for t in hanging.times]
    integral = TimeIntegral(of=KineticEnergy()).value(hanging)
    assert integral == pytest.approx(np.trapezoid(values, hanging.times), rel=1e-13)


def test_a_rigid_body_has_no_stress():
    scene = hanging_skin(responses={"wrong": MaxStress(body="arm")})
    with pytest.raises(InputError, match=r"'arm' is not flexible.*flexible bodies: skin"):
        values_of(scene, "transient")


def test_statics_leave_out_what_needs_motion():
    scene = read_scene(WING)
    scene = scene.model_copy(update={"responses": {**scene.responses, "work": TimeIntegral(of=KineticEnergy())}})
    assert set(values_of(scene, "static")) == set(read_scene(WING).responses)
    assert "work" in values_of(scene, "transient")


def test_the_integral_of_a_magnitude_that_starts_at_zero_has_a_gradient(hanging):
    """At the start the displacement is zero whatever the design, so its length is too; nothing is undefined about that."""
    integral = TimeIntegral(of=Displacement(body="arm", point="C", component="magnitude"))
    path = "loads.drive.torque"
    scene = hanging.system.scene.model_copy(update={"responses": {"way": integral}})
    found = direct(scene, [path], "transient").gradients["way"][path]
    exact = numerical(scene, [path], "transient", "complex-step").gradients["way"][path]
    assert found == pytest.approx(exact, rel=1e-9)  # round-off, times the condition of the skin's equations


def test_a_length_has_no_derivative_where_it_starts_to_grow():
    assert magnitude(np.zeros(2), lambda: np.zeros((2, 3)))[1].tolist() == [0.0, 0.0]
    assert np.isnan(magnitude(np.zeros(2), lambda: np.array([[0.0], [1.0]]))[1]).all()
    assert magnitude(np.array([3.0, 4.0]), lambda: np.zeros((2, 1)))[0] == pytest.approx(5.0)
