"""Vibrations that steps take out are told with what they would add to values and gradients, against closed forms of what vibrates."""

from __future__ import annotations

import numpy as np
import pytest

import ffrf
from preprocessing import build, save
from toolkit.analyses.sensitivity.errors import step_error
from toolkit.analyses.sensitivity.errors.excited_vibrations import error_after, root
from toolkit.solvers.transient.scheme import generalized_alpha

MASS, STIFFNESS, PULL = 0.01, 1000.0, 9.81 * 0.01
RATE, STATIC = (STIFFNESS / MASS) ** 0.5, PULL / STIFFNESS
OSCILLATOR = """units = "m-kg-s"
points.C = [0.0, -1.0]
points.S = [0.0, 0.0]
bodies.mass = {{ type = "rigid", mass = 0.01, inertia = 1e-5, center = "C" }}
loads.g = {{ type = "point-force", body = "mass", point = "C", force = [0.0, -0.0981]{curve} }}
design.k = "loads.spring.stiffness"
responses.y = {{ type = "displacement", body = "mass", point = "C", component = "y" }}
responses.least = {{ type = "time-min", of = {{ type = "displacement", body = "mass", point = "C", component = "y" }} }}
solver = {{ end_time = {end}, step = {step}{options} }}

[joints.guide]
type = "slider"
bodies = ["mass", "ground"]
point = "C"
axis = [0.0, 1.0]
lock_rotation = true

[loads.spring]
type = "spring-damper"
bodies = ["mass", "ground"]
points = ["C", "S"]
stiffness = 1000.0
length = 1.0
damping = {damping}
"""
RESOLVED, LINEAR = 10_000, 0
"""Most steps of a run that keeps the vibration: enough, or none, so that the linear motion tells."""


def hung(folder, end=0.4, step=0.01, damping=0.0, curve="", options=""):
    """A mass on a spring that begins at its unloaded length, and its weight."""
    path = folder / "hung.toml"
    path.write_text(OSCILLATOR.format(end=end, step=step, damping=damping, curve=curve, options=options))
    return ffrf.compile(ffrf.read_scene(path), variables=["k"]).simulate(gradients=True)


def doubts(run):
    """Codes of the doubts about a run."""
    return {each.code for each in run.warnings if each.doubt}


@pytest.mark.parametrize(
    ("step", "most"), [(0.004, LINEAR), (0.01, RESOLVED), (0.019869, LINEAR), (0.04, RESOLVED)]
)  # period 0.019869
def test_a_mass_on_a_spring_that_steps_bring_to_rest_is_told_its_place_and_the_derivative(tmp_path, monkeypatch, step, most):
    """y = -g m / k (1 - cos w t), and its derivative by k, which grows with time."""
    monkeypatch.setattr(step_error, "MOST_STEPS", most)
    run, end = hung(tmp_path, step=step), 0.4
    found = run.step_error
    true = -STATIC * (1 - np.cos(RATE * end))
    slope = -true / STIFFNESS - STATIC * np.sin(RATE * end) * end * RATE / (2 * STIFFNESS)
    assert "lost-vibrations" in doubts(run)
    error, slope_error = true - run.values["y"], slope - run.gradients["y"]["k"]
    assert 0.7 < (found.other_values["y"] - run.values["y"]) / error < 1.4
    assert 0.7 < (found.other_gradients["y"]["k"] - run.gradients["y"]["k"]) / slope_error < 1.4
    assert abs(slope_error) > 5 * abs(run.gradients["y"]["k"])


def test_the_text_names_the_vibration_its_size_and_a_step(tmp_path):
    (text,) = (each.text for each in hung(tmp_path).warnings if each.code == "lost-vibrations")
    assert f"a vibration of {RATE / (2 * np.pi):.4g} 1/s" in text
    assert "derivative of y by k" in text
    assert "Try solver.step = " in text


@pytest.mark.parametrize(
    "given",
    [
        {"step": 0.0002, "end": 0.1},
        {"options": ', start = "equilibrium"'},
        {"curve": ', curve = { type = "smooth-step", duration = 0.35 }'},
    ],
    ids=["resolved", "at rest", "slow"],
)
def test_nothing_is_told_where_nothing_is_lost(tmp_path, given):
    assert "lost-vibrations" not in doubts(hung(tmp_path, **given))


def test_what_is_damped_away_is_told_of_the_peak_alone(tmp_path):
    """A fifth of the critical damping: the first swing goes to 1 + exp(-pi zeta / sqrt(1 - zeta^2)) of the static deflection."""
    zeta = 0.2
    run = hung(tmp_path, damping=2 * zeta * (STIFFNESS * MASS) ** 0.5)
    peak = -STATIC * (1 + np.exp(-np.pi * zeta / (1 - zeta**2) ** 0.5))
    assert run.step_error.values["y"] < 1e-3
    error = abs(peak - run.values["least"]) / STATIC
    assert error > 0.05
    assert 0.5 < run.step_error.values["least"] / error < 2


@pytest.mark.parametrize(("steps", "later", "code"), [(20, 0.4, "rough-gradients"), (8, 0.2, "gradient-steps"), (8, -0.2, "")])
def test_a_derivative_at_the_step_beside_a_peak_is_told_its_distance_from_that_at_the_peak(tmp_path, steps, later, code):
    """The lowest place is -2 g m / k, half a period from the start; steps half as long may lie as far from it."""
    step = np.pi / RATE / (steps + later)
    run = hung(tmp_path, step=step, end=step * int(1.4 * steps))
    found, slope = run.step_error, run.gradients["least"]["k"]
    error = 2 * PULL / STIFFNESS**2 - slope
    assert found.slope_changes["least"]["k"] == pytest.approx(error, rel=0.15)
    assert found.gradients["least"]["k"] == pytest.approx(abs(error / slope), rel=0.15)
    assert ("least", "k") in found.at_peaks or steps == 8
    assert {"rough-gradients", "gradient-steps"} & set(run.verdict.codes) == ({code} if code else set())


def test_a_load_that_sets_in_within_a_step_is_one_that_sets_in_suddenly(tmp_path):
    """Late, and between two steps: the cosine begins there."""
    run = hung(
        tmp_path,
        curve=', curve = { type = "table", times = [0.0, 0.1043, 0.1044, 1.0], values = [0.0, 0.0, 1.0, 1.0], interpolation = "linear" }',
    )
    true = -STATIC * (1 - np.cos(RATE * (0.4 - 0.10435)))
    assert 0.7 < (run.step_error.other_values["y"] - run.values["y"]) / (true - run.values["y"]) < 1.4


STRIP = """units = "m-kg-s"
dimension = 2
rotary_inertia = false
nodes = { A = [0.0, 0.0], B = [0.2, 0.0] }
beams = [{ from = "A", to = "B", section = "bar", elements = 10 }]
sections.bar = { kind = "rectangle", thickness = 0.01, width = 0.02, material = "alu" }
materials.alu = { youngs_modulus = 70e9, density = 2700.0 }
clamp = ["A"]
interface_points = { tip = { node = "B" } }
"""
PUSHED = """units = "m-kg-s"
points.T = { body = "beam", interface = "tip" }
bodies.beam = { type = "flexible", model = "strip.h5", frame = "grounded" }
loads.push = { type = "point-force", body = "beam", point = "T", force = [0.0, 100.0] }
responses.end = { type = "displacement", body = "beam", point = "T", component = "y" }
responses.stress = { type = "max-stress", body = "beam" }
responses.largest = { type = "time-max", of = { type = "displacement", body = "beam", point = "T", component = "y" } }
"""
BENDING, WEIGHT = 70e9 * 0.02 * 0.01**3 / 12, 2700.0 * 0.2 * 0.02 * 0.01
ROOTS = np.array([1.8751040687, 4.6940911330, 7.8547574382, 10.995540735, 14.137168391, 17.278759532])
RATES = ROOTS**2 * (BENDING / (WEIGHT * 0.2**3)) ** 0.5


def deflected(times):
    """Tip of a clamped beam under a sudden load, by its first modes: sum of 4 F / (m w^2) (1 - cos w t)."""
    return (4 * 100.0 / (WEIGHT * RATES**2) * (1 - np.cos(np.outer(times, RATES)))).sum(axis=1)


def test_a_strip_under_a_sudden_load_is_told_what_its_vibrations_add(tmp_path):
    (tmp_path / "strip.toml").write_text(STRIP)
    save(build(tmp_path / "strip.toml"), tmp_path / "strip.h5")
    (tmp_path / "pushed.toml").write_text(PUSHED)
    run = ffrf.compile(ffrf.read_scene(tmp_path / "pushed.toml")).simulate()
    assert run.values["end"] == pytest.approx(100.0 * 0.2**3 / (3 * BENDING), rel=1e-6)  # at rest, after 206 periods
    assert "lost-vibrations" in doubts(run)
    other, peak = run.step_error.other_values, deflected(np.arange(0, 0.2, 2e-5)).max()
    assert other["end"] == pytest.approx(float(deflected(np.array([1.0]))[0]), rel=0.03)
    assert 0.5 < (other["largest"] - run.values["largest"]) / (peak - run.values["largest"]) < 2
    assert other["stress"] == pytest.approx(146.5e6, rel=0.1)  # all modes of a finite-element beam


@pytest.mark.parametrize("name", ["arnold-bruels", "paper"])
def test_the_scheme_keeps_slow_vibrations_and_its_own_part_of_fast_ones(name):
    """rho_inf at infinite frequency (Chung and Hulbert 1993); an error of the phase of second order."""
    scheme = generalized_alpha(name, 0.5)
    assert abs(root(scheme, 1e5)) == pytest.approx(0.5, rel=1e-3)
    assert abs(root(scheme, 1e-3)) == pytest.approx(1.0, rel=1e-9)
    coarse, fine = (error_after(scheme, 1.0, step, 1.0) for step in (0.02, 0.01))
    assert coarse / fine == pytest.approx(4.0, rel=0.05)
