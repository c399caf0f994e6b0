"""Every model of the project runs, meets its check value, and its gradients meet closed forms, published values or the complex step."""

from __future__ import annotations

import json
import runpy
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from preprocessing import build
from tests.models.solid_bodies import compliance, frequencies
from toolkit.foundation.errors import LimitPointError
from toolkit.reduced_model.file import load
from toolkit.scene_file.reader import read_scene
from toolkit.sensitivity.direct import direct
from toolkit.sensitivity.numerical import numerical
from toolkit.sensitivity.result import Result
from toolkit.validity.description.frame_choice import frame_choices

ROOT = Path(__file__).parents[2]
MODELS = ROOT / "models"
NAMES = sorted(path.parent.name for path in MODELS.glob("*/scene.toml"))


def published(name: str) -> dict:
    return json.loads((ROOT / "tests" / "data" / "benchmarks" / f"{name}.json").read_text())


def run(name: str, changes: dict[str, str] | None = None) -> Result:
    """Responses of a model with gradients by all variables that it declares."""
    scene = read_scene(MODELS / name / "scene.toml", changes)
    return direct(scene, list(scene.design), "transient")


def test_the_models_are_those_that_are_checked_here():
    planar = ["bracket", "flexible_slider_crank", "four_bar_chain", "morphing_wing", "pendulum", "rotating_beam"]
    planar += ["slider_crank", "snap_through"]
    assert [*planar, "spatial_bracket"] == NAMES
    assert [name for name in NAMES if not (MODELS / name / "README.md").exists()] == []


@pytest.mark.parametrize("name", NAMES)
def test_gradients_of_every_model_are_those_of_the_complex_step(name):
    """By all variables that the scene declares, over its first steps, for the complex step is slow."""
    scene = read_scene(MODELS / name / "scene.toml")
    short = scene.model_copy(update={"solver": scene.solver.model_copy(update={"end_time": 5 * scene.solver.step})})
    ours = direct(short, list(scene.design), "transient").gradients
    judge = numerical(short, list(scene.design), "transient", "complex-step").gradients
    for response, slopes in ours.items():
        largest = max(abs(slope * scene.number(scene.design[x])) for x, slope in slopes.items())
        for x, slope in slopes.items():
            # both are exact up to the Newton tolerance of 1e-10, relative to moves and forces that have just begun to grow from zero
            error = abs(slope - judge[response][x]) * abs(scene.number(scene.design[x]))
            assert error <= 1e-6 * largest + 1e-15 * scene.size, (response, x)


def test_wing_meets_the_values_stated_with_the_scene():
    found = run("morphing_wing")
    stated = {"max_stress_true": (56.78, 0.01), "shape_rmse": (0.330, 5e-4), "shape_max_error": (0.564, 5e-4)}
    for name, (value, half_a_digit) in {**stated, "drive_angle": (0.503, 5e-4)}.items():
        assert found.values[name] == pytest.approx(value, abs=half_a_digit), name


def test_wing_that_snaps_through_has_the_stated_limit_and_ends_beyond_it():
    """Where a damped motion comes to rest; the stress alone has its largest value during the jump."""
    with pytest.raises(LimitPointError) as error:
        direct(read_scene(MODELS / "snap_through" / "scene.toml"), [], "static")
    assert error.value.load_factor == pytest.approx(0.92, abs=5e-3)
    beyond = direct(read_scene(MODELS / "snap_through" / "scene.toml", {"solver.continuation": "arc-length"}), [], "static")
    damped = run("snap_through", {"bodies.skin.damping_mass": "30", "solver.end_time": "2", "solver.step": "0.002"})
    for name in ("drive_angle", "shape_rmse", "shape_max_error"):
        assert damped.values[name] == pytest.approx(beyond.values[name], rel=1e-5), name  # exp(-15 x 1.2) of the jump is left


def test_pendulum_meets_the_elliptic_functions_in_place_force_and_gradients():
    known = published("iftomm_a01_pendulum")["rederived"]
    k = known["t"].index(10.0)
    angle, by_length, by_g, force = (known[key][k] for key in ("theta_rad", "dtheta_dL", "dtheta_dg", "rod_tension_N"))
    found = run("pendulum")
    close = {"rel": 1e-4}  # second order: the phase is off by 1e-5 of the 4 periods, times the slope of the response
    assert found.values["move_x"] == pytest.approx(1 + np.sin(angle), **close)
    assert found.values["move_y"] == pytest.approx(-np.cos(angle), **close)
    assert found.values["rod_force"] == pytest.approx(force, **close)
    slopes = found.gradients["move_x"]
    assert slopes["x_P"] == pytest.approx(-(1 + np.sin(angle) + np.cos(angle) * by_length), **close)  # x_P = -L
    assert slopes["g_y"] == pytest.approx(-np.cos(angle) * by_g, **close)  # g_y = -g
    assert slopes["m"] == pytest.approx(0, abs=1e-10)  # round-off: no motion of a pendulum depends on its mass
    assert found.gradients["rod_force"]["m"] == pytest.approx(force, **close)


def four_bar_angle(gravity: complex, mass: complex, end_time: float) -> complex:
    """Angle of the links while all loops are parallelograms.

    (1 + m_1 + m_2) phi'' = g (3/2 + m_1 + m_2) sin(phi), phi'(0) = 1: three links of 1 kg about their ends, couplers that translate.
    """
    factor = gravity * (2.5 + mass) / (2 + mass)
    start = np.array([0, 1], complex)
    motion = solve_ivp(lambda _, y: [y[1], factor * np.sin(y[0])], (0, end_time), start, "DOP853", rtol=1e-12, atol=1e-12)
    return motion.y[0, -1]


def test_four_bar_chain_meets_the_exact_angle_and_its_slopes_after_five_singular_positions():
    known = published("iftomm_a02_n_fourbar")["rederived"]["N=2"]
    k = known["t"].index(5.0)
    found, h = run("four_bar_chain"), 1e-20
    assert four_bar_angle(9.81, 1, 5).real == pytest.approx(known["phi_rad"][k], rel=1e-9)  # the judge of the slopes
    error = 5e-5  # second order: 5 s at up to 7 rad/s in steps of 1 ms
    assert -found.values["angle"] == pytest.approx(known["phi_rad"][k], rel=error)
    height = 3.5 * 9.81 * (1 - known["B0_y_m"][k])  # what the five bars have lost, for all mean heights go with B0
    assert found.values["kinetic"] == pytest.approx(1.5 + height, rel=10 * error)
    slopes = found.gradients["angle"]
    assert slopes["g_y"] == pytest.approx(four_bar_angle(9.81 + 1j * h, 1, 5).imag / h, rel=10 * error)  # angle = -phi, g_y = -g
    assert -slopes["m_1"] == pytest.approx(four_bar_angle(9.81, 1 + 1j * h, 5).imag / h, rel=10 * error)


def test_slider_crank_meets_the_published_functional_and_gradients():
    known = published("sundials_slider_crank_sensitivity")
    found = run("slider_crank")
    assert found.values["G"] == pytest.approx(known["reference"]["G_idas_forward"], rel=5e-5)  # second order at 0.005
    slopes = found.gradients["G"]
    for name, value in zip(("k", "c"), known["reference"]["dG_dp_idas"], strict=True):
        assert slopes[name] == pytest.approx(value, rel=known["tolerance"]["published_gradient_rel"]), name
    for name, slope in slopes.items():
        assert slope == pytest.approx(known["rederived"]["dG_d"][name], rel=1e-4), name  # second order at 0.005


def stretched(rate: float, modulus: float, density: float) -> tuple[float, float]:
    """Moment of inertia about the hub per area, and the mean strain of the first of 20 elements, of a rotating bar of length 1.

    E u'' + rho Omega^2 (x + u) = 0, u(0) = u'(1) = 0:  x + u = sin(k x) / (k cos k),  k = Omega sqrt(rho / E)
    J / A = rho int (x + u)^2 dx = rho (1/2 - sin(2 k) / (4 k)) / (k cos k)^2
    """
    k, h = rate * np.sqrt(density / modulus), 1 / 20
    inertia = density * (0.5 - np.sin(2 * k) / (4 * k)) / (k * np.cos(k)) ** 2
    return inertia, np.sin(k * h) / (k * h * np.cos(k)) - 1


def test_rotating_beam_ends_in_the_closed_form_of_a_stretched_bar():
    modulus, density, area = 210e9, 7800.0, 1e-3
    momentum = density / 3 * 50  # per area: of the undeformed beam at the start, which no force about the hub changes
    rate = brentq(lambda omega: stretched(omega, modulus, density)[0] * omega - momentum, 40, 50.1, xtol=1e-12)
    inertia, strain = stretched(rate, modulus, density)
    errors = []
    for step in ("0.001", "0.0005"):  # the last is the scene's own
        found = run("rotating_beam", {"solver.step": step})
        energy = found.values["kinetic"] / (area * inertia * rate**2 / 2) - 1
        errors.append((abs(energy), abs(found.values["stress"] / (modulus * strain) - 1)))
    # second order: the sudden stretch of the first milliseconds costs a little momentum, (50/s x 0.5 ms)^2 / 80 of it
    assert max(errors[1]) < 1e-5
    np.testing.assert_allclose(np.divide(*errors), 4, rtol=0.02)


def test_bracket_moves_its_piston_as_the_rigid_slider_crank_does():
    """x = r cos(a) + s, s^2 = l^2 - r^2 sin(a)^2, at a quarter of a turn with constant rate w: x = s, x'' = w^2 r^2 / s."""
    radius, length, mass = 30.0, 120.0, 5e-4
    s, rate = np.sqrt(length**2 - radius**2), 15 / 8 * np.pi / 0.02  # of the smooth step, in its middle
    found = run("bracket")
    assert found.values["stroke"] == pytest.approx(s - radius - length, abs=5e-3)  # mm; the rod is stretched by some micrometres
    assert found.values["pin_force"] == pytest.approx(-mass * rate**2 * radius**2 / s, rel=5e-3)  # it vibrates a little
    assert found.gradients["pin_force"]["m"] == pytest.approx(-(rate**2) * radius**2 / s, rel=1e-2)
    scaled = found.gradients["stress"]["E"] * 70e3 / found.values["stress"]
    assert abs(scaled) < 5e-3  # inertia forces make the same stress in a stiffer rod, but for its vibrations


def spatial_stroke(o: np.ndarray) -> complex:
    """Move of the piston along x after a quarter of a turn, where the axis of the crank passes through o, real or complex.

    T = o + R (T_0 - o), P = P_0 + s n, |P - T|^2 = |P_0 - T_0|^2:  s^2 + 2 s n . d + |d|^2 - |P_0 - T_0|^2 = 0, d = P_0 - T, T_0 = 0
    """
    quarter, pin, n = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([90.0, 0, 60]), np.array([4, 1, 1]) / np.sqrt(18)
    d = pin - (o - quarter @ o)
    b = n @ d
    return n[0] * (-b + np.sqrt(b**2 - d @ d + pin @ pin))


def on_two_pins(rods: np.ndarray) -> np.ndarray:
    """Deflections (n,) in the middle of rods of 0.3 m after half a turn of a crank of 0.15 m at 54 rad/s, in their modes k pi x / L.

    q_k'' + (omega_k^2 - phi'^2) q_k = -(2 / L) int_0^L sin(k pi x / L) (n . a_A + x phi'') dx, with the angle phi of the rod, its normal n,
    and the acceleration a_A of the crank's pin. `rods` has modulus, thickness and density of each, (n, 3).
    """
    crank, length, speed, k = 0.15, 0.3, 54.0, np.arange(1, 10, 2)  # even modes are at rest in the middle
    modulus, thickness, density = rods.T[:, :, None]
    own = (k * np.pi / length) ** 2 * np.sqrt(modulus * thickness**2 / 12 / density)

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        sine, first, second = (
            crank / length * np.array([-np.sin(speed * t), -speed * np.cos(speed * t), speed**2 * np.sin(speed * t)])
        )
        cosine = np.sqrt(1 - sine**2)
        spin = first / cosine
        turn = (second + sine * spin**2) / cosine
        across = -(speed**2) * crank * (cosine * np.sin(speed * t) - sine * np.cos(speed * t))
        push = 2 / (k * np.pi) * (2 * across + length * turn)
        q, v = y.reshape(2, *own.shape)
        return np.concatenate([v.ravel(), (-(own**2 - spin**2) * q - push).ravel()])

    found = solve_ivp(rates, (0, np.pi / speed), np.zeros(2 * own.size), rtol=1e-11, atol=1e-16, method="DOP853")
    middle: np.ndarray = found.y[: own.size, -1].reshape(own.shape) @ np.sin(k * np.pi / 2)
    return middle


def test_flexible_slider_crank_bends_as_a_rod_on_two_pins():
    found, rod = run("flexible_slider_crank"), {"E": 2e11, "t": 0.006, "rho": 7870.0}
    size, h = np.array(list(rod.values())), 1e-3
    expected, *ups_and_downs = on_two_pins(size * (1 + h * np.vstack([np.zeros(3), np.eye(3), -np.eye(3)])))
    # on the way it deflects by 3.7e-4 m; elongation, which this theory leaves out, and 4 modes in each half change a part of 2e-4 of that
    assert found.values["deflection"] == pytest.approx(expected, abs=1e-7)
    up, down = np.reshape(ups_and_downs, (2, 3))
    for k, (name, value) in enumerate(rod.items()):
        assert found.gradients["deflection"][name] == pytest.approx((up - down)[k] / (2 * h * value), rel=2e-3), name
    assert found.verdict.trusted


def test_flexible_slider_crank_is_what_its_file_gives_and_its_joints_ask_for():
    model = load(MODELS / "flexible_slider_crank" / "frame.h5")
    assert model.input_hash == build(MODELS / "flexible_slider_crank" / "frame.toml").input_hash
    (choice,) = frame_choices(read_scene(MODELS / "flexible_slider_crank" / "scene.toml")).values()
    assert not choice.advice


def test_spatial_bracket_moves_its_piston_as_the_rigid_slider_crank_does():
    found, h = run("spatial_bracket"), 1e-20
    o = np.array([-25.0, 0, 0], complex)
    assert found.values["stroke"] == pytest.approx(
        spatial_stroke(o).real, abs=0.2
    )  # mm; the bracket of 8 mm bends by 4.7 um per N
    for k, name in enumerate(("x_O", "y_O")):
        slope = spatial_stroke(o + 1j * h * np.eye(3)[k]).imag / h
        assert found.gradients["stroke"][name] == pytest.approx(slope, rel=2e-2), name  # its bending follows the crank too
    stiff = run("spatial_bracket", {"bodies.bracket.youngs_modulus": "7e7"})  # a thousand times
    # what is left is the centre of the meshed bore, which is that of its curved triangles
    assert stiff.values["stroke"] == pytest.approx(spatial_stroke(o).real, abs=1e-3)


@pytest.mark.parametrize("name", ["bracket", "spatial_bracket"])
def test_bracket_file_is_what_its_mesh_gives(name):
    """The same body: vectors of modes may turn their signs, so the compliance of the pin and the frequencies are compared."""
    folder = MODELS / name
    committed, fresh = load(folder / "body.h5"), build(folder / "body.toml")
    assert committed.input_hash == fresh.input_hash
    assert committed.nominal == fresh.nominal
    # other versions of the libraries may sum in another order: round-off times the condition of the stiffness
    np.testing.assert_allclose(compliance(committed, "pin"), compliance(fresh, "pin"), rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(frequencies(committed), frequencies(fresh), rtol=1e-7)


def test_rotating_beam_file_is_what_its_script_gives(tmp_path):
    fresh = runpy.run_path(str(MODELS / "rotating_beam" / "build.py"))["model"]
    committed = load(MODELS / "rotating_beam" / "beam.h5")
    assert committed.input_hash == fresh.input_hash
    assert committed.nominal == fresh.nominal
    for name, array in asdict(fresh.invariants).items():
        # other versions of numpy may sum in another order: units in the last place of the largest entry
        np.testing.assert_allclose(getattr(committed.invariants, name), array, rtol=0, atol=1e-12 * np.abs(array).max(initial=1))
