"""Damping that follows the mass acts on the whole velocity of a body: whatever its frame is tied to, nothing else than exp(-alpha t)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ffrf
from tests.spatial.scenes import save_frame

ALPHA = 0.5
BEAM = """units = "m-kg-s"
dimension = {d}
{clamp}
nodes = {{ A = {A}, B = {B} }}
beams = [{{ from = "A", to = "B", section = "s", elements = 8{across} }}]
interface_points = {{ A = {{ node = "A" }}, B = {{ node = "B" }} }}
sections.s = {{ kind = "rectangle", thickness = 0.01, width = 0.02, material = "m" }}
materials.m = {{ youngs_modulus = 1.2e7, density = 100.0{ratio} }}
damping = {{ mass = {alpha}, stiffness = 0.0 }}
{basis}
"""
BASES = {
    "clamp": "",
    "chord": 'basis = { kind = "craig-bampton", count = 4, chord = ["A", "B"] }',
    "mean axes": 'basis = { kind = "eigenmodes", boundary = "free", count = 6 }',
}
HINGED = """units = "m-kg-s"
[points]
A = { body = "beam", interface = "A" }
[bodies]
beam = { type = "flexible", model = "beam.h5"FRAMES }
[joints]
hub = { type = "revolute", bodies = ["beam", "ground"], point = "A" }
[loads]
k = { type = "rotational-spring-damper", bodies = ["beam", "ground"], point = "A", stiffness = 10.0 }
[responses]
f1 = { type = "frequency", number = 1 }
z1 = { type = "damping-ratio", number = 1 }
f2 = { type = "frequency", number = 2 }
z2 = { type = "damping-ratio", number = 2 }
"""
THROWN = """units = "m-kg-s"
dimension = DIMENSION
[points]
A = { body = "beam", interface = "A" }
B = { body = "beam", interface = "B" }
[bodies]
beam = { type = "flexible", model = "beam.h5", damping_mass = DAMPING, VELOCITY }
[design]
alpha = "bodies.beam.damping_mass"
[responses]
x = { type = "displacement", body = "beam", point = "A", component = "x", time = 1.0 }
[solver]
end_time = 1.0
step = 0.02
"""


def save_model(folder: Path, basis: str, dimension: int = 2, alpha: float = ALPHA) -> None:
    """A bar of 1 m along x, clamped to its frame at A unless its basis says otherwise."""
    zero, across, ratio = ([0.0], ", orientation = [0.0, 0.0, 1.0]", ", poisson_ratio = 0.3") if dimension == 3 else ([], "", "")
    ends = {"A": [0.0, 0.0, *zero], "B": [1.0, 0.0, *zero]}
    clamp = "" if basis else 'clamp = ["A"]'
    save_frame(
        folder, "beam", BEAM.format(d=dimension, clamp=clamp, **ends, across=across, ratio=ratio, alpha=alpha, basis=basis)
    )


@pytest.mark.parametrize("basis", BASES)
def test_every_mode_is_damped_by_half_of_alpha_over_omega_whatever_the_frame_is(tmp_path, basis):
    """M q'' + alpha M q' + K q = 0: zeta = alpha / (2 omega), of the swinging bar on a spring as of its bending."""
    save_model(tmp_path, BASES[basis])
    (tmp_path / "scene.toml").write_text(HINGED.replace("FRAMES", ""))
    run = ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml")).statics()
    for k in "12":
        assert run.values[f"z{k}"] == pytest.approx(ALPHA / (4 * np.pi * run.values[f"f{k}"]), rel=1e-9)


def test_a_body_of_several_frames_is_damped_as_one_of_one(tmp_path):
    save_model(tmp_path, "")
    (tmp_path / "scene.toml").write_text(HINGED.replace("FRAMES", ", frames = 4"))
    run = ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml")).statics()
    assert run.values["z2"] == pytest.approx(ALPHA / (4 * np.pi * run.values["f2"]), rel=1e-9)
    assert run.verdict.trusted


def thrown(folder: Path, dimension: int, velocity: str, damping: float, more: str = "") -> ffrf.Model:
    text = THROWN.replace("DIMENSION", str(dimension)).replace("VELOCITY", velocity).replace("DAMPING", str(damping))
    text = text.replace("time = 1.0 }", "time = 1.0 }" + more)
    (folder / "scene.toml").write_text(text)
    return ffrf.compile(ffrf.read_scene(folder / "scene.toml"), variables=["alpha"])


PUSHED = "velocity = [3.0, 0.0, 0.0]"


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_thrown_body_slows_down_as_all_of_its_mass_is_damped(tmp_path, dimension):
    """m x'' = -alpha m x': x = v (1 - exp(-alpha t)) / alpha, and its derivative by alpha, forwards and backwards."""
    save_model(tmp_path, "", dimension)
    a, v = 0.8, 3.0
    model = thrown(tmp_path, dimension, PUSHED, a)
    for method in ("direct", "adjoint"):
        run = model.simulate(gradients=method)
        assert run.values["x"] == pytest.approx(v * (1 - np.exp(-a)) / a, rel=1e-4)
        assert run.gradients["x"]["alpha"] == pytest.approx(v * (np.exp(-a) * (a + 1) - 1) / a**2, rel=3e-4)
    assert run.verdict.trusted


def test_the_first_bit_of_damping_has_its_derivative(tmp_path):
    """x = v t - alpha v t^2 / 2 + ...: at no damping at all dx/dalpha = -v / 2 after 1 s."""
    save_model(tmp_path, "", alpha=0.0)
    run = thrown(tmp_path, 2, PUSHED, 0.0).simulate(gradients=True)
    assert run.values["x"] == pytest.approx(3.0, rel=1e-9)
    assert run.gradients["x"]["alpha"] == pytest.approx(-1.5, rel=1e-4)


def test_a_body_that_tumbles_loses_its_energy_by_exp_minus_two_alpha_t(tmp_path):
    """omega' of a damped body is that of a free one whose clock slows down: T = T_0 exp(-2 alpha t) of a stiff bar about any axes."""
    save_model(tmp_path, "", 3)
    energy = '\nearly = { type = "kinetic-energy", time = 0.0 }\nlate = { type = "kinetic-energy", time = 1.0 }'
    run = thrown(tmp_path, 3, "angular_velocity = [0.7, 0.4, 0.9]", 0.8, energy).simulate()
    assert run.values["late"] / run.values["early"] == pytest.approx(np.exp(-1.6), rel=1e-3)


def test_numbers_of_a_damping_that_comes_and_goes_are_those_of_a_fresh_model(tmp_path):
    save_model(tmp_path, "", alpha=0.0)
    model = thrown(tmp_path, 2, PUSHED, 0.0)
    for a in (0.8, 0.0, 0.4):
        found = model.at({"alpha": a}).simulate().values["x"]
        fresh = thrown(tmp_path, 2, PUSHED, a).simulate().values["x"]
        assert found == pytest.approx(fresh, rel=1e-12)
