"""What double precision leaves of forces and gradients, and that a certificate tells its round-off from a wrong derivative."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from toolkit.analyses.sensitivity.certificate import certificate
from toolkit.analyses.sensitivity.certificate.certificate import DisagreementError, certify
from toolkit.analyses.sensitivity.certificate.differences import STEPS, direction, jumping, round_off, taylor_rates
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.sensitivity.preparation import response_scales, variable_sizes
from toolkit.files.scene_reader import read_scene
from toolkit.system.system import compile_scene

MODELS = Path(__file__).parents[2] / "models"
WING = MODELS / "morphing_wing" / "scene.toml"
BEAM = MODELS / "rotating_beam" / "scene.toml"


def exact_forces(strains, q: np.ndarray) -> np.ndarray:
    """B^T D B q in rational numbers, rounded once."""
    found = [Fraction(0)] * len(q)
    for row, weight in enumerate(strains.weight):
        own = range(strains.start[row], strains.start[row + 1])
        force = Fraction(weight) * sum(Fraction(strains.value[p]) * Fraction(q[strains.column[p]]) for p in own)
        for p in own:
            found[strains.column[p]] += Fraction(strains.value[p]) * force
    return np.array([float(each) for each in found])


def test_elastic_forces_of_a_thin_skin_have_the_round_off_of_single_strains():
    """Moved far and hardly strained, so that nearly all of a product with the stiffness cancels: a strain is off by three roundings of
    its products with coordinates, and no force is off by more than what follows from that."""
    rng = np.random.default_rng(3)
    system = compile_scene(read_scene(WING))
    strains, q, n_f = system.plan.constant.strains, np.zeros(system.n), 90  # 30 free nodes of three coordinates
    q[:n_f] = np.tile([3.0, -7.0, 0.0], 30) + 1e-9 * rng.normal(size=n_f)
    force = system.evaluate(system.inputs(0.0, np.zeros(3)), q, np.zeros(system.n), np.zeros(system.n)).applied
    products = np.zeros(n_f)
    for row, weight in enumerate(strains.weight):
        own = slice(strains.start[row], strains.start[row + 1])
        size = weight * np.abs(strains.value[own] * q[strains.column[own]]).sum()
        np.add.at(products, strains.column[own], np.abs(strains.value[own]) * size)
    far = np.arange(6, n_f)  # but for the node next to the clamp, whose element is stretched by all of it
    assert products[far].max() > 1e7 * np.abs(force[far]).max()
    assert np.all(np.abs(force[:n_f] - exact_forces(strains, q)[:n_f]) < 4 * np.finfo(float).eps * products)


@pytest.mark.parametrize("kind", ["transient", "static"])
def test_small_derivatives_by_geometry_agree_as_well_as_large_ones(kind):
    """d shape_rmse / d D.x is a thousandth of other changes of the wing; usual sums in K q left it 7.6 digits."""
    scene, design = read_scene(WING), ["points.D.x", "bodies.skin.chord"]
    by = {method: gradients_by(method, scene, design, kind).gradients for method in ("direct", "adjoint", "complex-step")}
    for method in ("adjoint", "complex-step"):
        for x in design:
            # the state is exact to 1e-16, and round-off of the linear solves is magnified by a condition of 1e6 to 1e7
            assert by[method]["shape_rmse"][x] == pytest.approx(by["direct"]["shape_rmse"][x], rel=5e-9, abs=0), (method, x)


def test_every_number_of_the_wing_is_certified_in_motion():
    scene = read_scene(WING, {"solver.end_time": "0.3"})
    paths = [path for path in scene.available_paths() if "velocity" not in path and "body" not in path]
    found = certify(scene, paths, "transient")
    found.check(1e-8)
    for response in ("max_stress", "drive_angle"):  # what is not small has all its digits, whatever is small beside it
        for x in ("points.A.x", "points.A.y", "loads.drive.torque", "bodies.skin.thickness"):
            assert found.limits[response][x] < 1e-8, (response, x)


@pytest.mark.parametrize(("kind", "variables"), [("transient", ("x_A", "M_t", "t_w")), ("static", ("M_t",))])
def test_a_derivative_that_is_wrong_by_a_millionth_is_found(monkeypatch, kind, variables):
    right, spoilt = certificate.adjoint_gradients, ""

    def wrong(system, solution):
        found, gradient = right(system, solution)
        gradient[system.design.names.index(spoilt)] *= 1 + 1e-6
        return found, gradient

    scene = read_scene(WING, {"solver.end_time": "0.3"})
    exact = direct(scene, ["x_A", "M_t", "t_w"], kind)
    certificate.compare(exact, kind, exact.gradients).check(1e-8)
    monkeypatch.setattr(certificate, "adjoint_gradients", wrong)
    for spoilt in variables:
        with pytest.raises(DisagreementError, match=f"and adjoint disagree on d .* / d {spoilt}"):
            certificate.compare(exact, kind, exact.gradients).check(1e-8)


@pytest.mark.processors
def test_the_estimate_of_round_off_is_small_for_ordinary_derivatives():
    """A tenth of the millionth that is found above; the estimate is round-off itself, up to 2e-8 for stress by E, which hardly matters."""
    scene = read_scene(WING, {"solver.end_time": "0.3"})
    exact = direct(scene, list(scene.design), "transient")
    floors = round_off(scene, exact, "transient")
    for response, slopes in exact.gradients.items():
        for x, slope in slopes.items():
            assert floors[response][x] < 1e-7 * abs(slope), (response, x)  # so that nothing larger is taken for round-off


def test_a_variable_that_is_zero_has_the_size_of_what_it_does():
    """A damping of 1 s would be three thousand periods of the beam; a step of its size moves no response further than others do."""
    scene = read_scene(BEAM, {"solver.end_time": "0.01", "bodies.beam.damping_stiffness": "0.0"})
    zero, other = "bodies.beam.damping_stiffness", "bodies.beam.angular_velocity"
    exact = direct(scene, [zero, other], "transient")
    size = variable_sizes(scene, exact)[zero]
    assert size < 1.0
    for f, slopes in exact.gradients.items():
        largest = max(abs(exact.values[f]), 50.0 * abs(slopes[other]))
        assert abs(slopes[zero]) * size <= (1 + 1e-12) * largest  # round-off of the product


def test_taylor_steps_that_fail_are_left_out_instead_of_ending_the_certificate():
    scene = read_scene(BEAM, {"solver.end_time": "0.01"})
    design = ["bodies.beam.angular_velocity"]
    rates = taylor_rates(scene, design, "transient", steps=(1e9, 1e-2, 5e-3))
    assert rates["kinetic"] == pytest.approx(2, abs=0.05)  # quadratic in the speed, nearly
    assert all(np.isnan(rate) for rate in taylor_rates(scene, design, "transient", steps=(1e9,)).values())


def test_numbers_that_only_preprocessing_changes_do_not_move_in_studies():
    scene = read_scene(WING)
    exact = direct(scene, ["bodies.skin.chord", "bodies.skin.damping_mass", "t_w", "x_A"], "static")
    assert set(direction(scene, exact)) == {"t_w", "x_A"}


def test_a_derivative_that_means_nothing_to_a_response_need_not_agree():
    """Least size of a derivative, as an optimum asks for it: a part of the response for a change of the variable by its own size."""
    scene = read_scene(BEAM, {"solver.end_time": "0.002"})
    exact = direct(scene, list(scene.design), "transient")
    usual, least = round_off(scene, exact, "transient"), round_off(scene, exact, "transient", unseen=1e-6)
    sizes = variable_sizes(scene, exact)
    scales = response_scales(exact, sizes)
    for f, slopes in exact.gradients.items():
        for x in slopes:
            assert least[f][x] == pytest.approx(max(usual[f][x], 1e-6 * scales[f] / sizes[x]), rel=1e-12)


def test_round_off_beside_a_slope_of_zero_is_no_jump():
    """Differences of (h/3)^3 with the last digit of 1, right to the bit at one step by chance; a step of 1e-4 in the response is seen."""
    left = {h: {"f": h**2 / 27 + (0.0 if h < 2e-10 else 1e-16 / h)} for h in STEPS}
    left[STEPS[-1]]["f"] = 0.0
    assert jumping(left, {"f": 0.0}, {"f": 1.0}) == ()
    leaping = {h: {"f": each["f"] + (1e-4 / h if h > 1e-7 else 0.0)} for h, each in left.items()}
    assert jumping(leaping, {"f": 0.0}, {"f": 1.0}) == ("f",)
