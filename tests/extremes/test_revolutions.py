"""A beam after a million revolutions: angle, stretch and hub force as closed forms have them, whatever the step and the number of turns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import Rod
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.driver import AngleDriver
from toolkit.components.joints.revolute import Revolute
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ConvergenceError
from toolkit.scene.scene import Scene
from toolkit.system.solution import flexible_body
from toolkit.system.system import System, compile_scene
from toolkit.validity.energy_balance import energy_balance

BEAM = Path(__file__).parents[2] / "models" / "rotating_beam" / "scene.toml"
SPEED, MODULUS, DENSITY, AREA = 50.0, 210e9, 7800.0, 1e-3
TURN = 2 * np.pi
MILLION = 1_000_000
FORMULATIONS = pytest.mark.parametrize("formulation", ["index-1", "index-3", "ggl"])


@pytest.fixture(scope="module")
def beam() -> System:
    return compile_scene(read_scene(BEAM))


def stretched(x: np.ndarray) -> np.ndarray:
    """u(x) of a bar of 1 m that spins: E u'' + rho Omega^2 (x + u) = 0, x + u = sin(k x) / (k cos k), k = Omega sqrt(rho / E)."""
    k = SPEED * np.sqrt(DENSITY / MODULUS)
    return np.sin(k * x) / (k * np.cos(k)) - x


def hub_force() -> float:
    """A E u'(0), what keeps the bar on its circle."""
    return float(AREA * MODULUS * (1 / np.cos(SPEED * np.sqrt(DENSITY / MODULUS)) - 1))


def steady(beam: System, angle: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and velocities of steady rotation of the finite elements, (K - Omega^2 G_ff) q_f = Omega^2 G_f0."""
    inv = flexible_body(beam.scene, "beam").invariants(beam.scene)
    q, v = np.zeros(beam.n_q), np.zeros(beam.n_q)
    q[2], v[2] = angle, SPEED
    q[3:] = np.linalg.solve(inv.stiffness - SPEED**2 * inv.inertia[1:, 1:], SPEED**2 * inv.inertia[1:, 0])
    return q, v


def test_the_elements_are_stretched_as_the_closed_form_says(beam):
    stretch = steady(beam)[0][3::3]
    np.testing.assert_allclose(
        stretch, stretched(np.linspace(0, 1, 21)[1:]), rtol=1e-7
    )  # (k h)^2 = 2e-7, at nodes a twelfth of it
    np.testing.assert_allclose(AREA * MODULUS * stretch[0] * 20, hub_force(), rtol=1e-3)  # mean of the first element: h^2 / 3


LONG, SHORT = [(1000, 20), (MILLION, 1 / 50.3)], [(100, 20), (MILLION // 10, 1 / 50.3)]
"""Turns, and steps in each: 20000 steps, whose round-off adds up, and 2000, in which formulations differ as much."""


@pytest.mark.parametrize(
    ("turns", "steps_per_turn", "formulation"),
    [(*run, "index-1") for run in LONG] + [(*run, other) for run in SHORT for other in ("index-3", "ggl")],
)
def test_a_freely_spinning_beam_keeps_its_time_and_its_stretch(beam, turns, steps_per_turn, formulation):
    """In its own frame nothing changes, so that a step may take many turns: 1e6 revolutions in 2e4 steps, or 1000 with 20 steps each."""
    end, step = turns * TURN / SPEED, TURN / SPEED / steps_per_turn
    q, v = steady(beam)
    run = simulate(beam, RunOptions(end_time=end, step=step, rho_inf=0.8, formulation=formulation), q, v)
    # the first step, of many turns, leaves 1e-9 of a stretch of 3e-5: a speed that is off by 2e-11 for good
    assert run.q[-1, 2] == pytest.approx(turns * TURN, rel=5e-11)
    np.testing.assert_allclose(run.q[-1, 3::3], q[3::3], rtol=1e-10)  # round-off of tension, which is stiff
    np.testing.assert_allclose(run.q[:, 4::3], 0, atol=1e-12)  # nothing bends
    force = np.hypot(*run.multipliers.T)
    np.testing.assert_allclose(force, hub_force(), rtol=1e-6)  # linear shapes carry all mass: exact to (k h)^2
    # it pulls along the beam, which is where the angle says: sin and cos have not lost their digits
    along = -(run.multipliers * np.column_stack([np.cos(run.q[:, 2]), np.sin(run.q[:, 2])])).sum(axis=1)
    np.testing.assert_allclose(np.abs(along), force, rtol=1e-12)
    assert run.drift < 1e-15  # of the size of 1 m


@pytest.mark.parametrize("angle", [1.0, 2.0, TURN * 10_000, TURN * MILLION])
def test_a_beam_that_has_turned_a_million_times_moves_as_one_that_has_not(beam, angle):
    """Vibrating and speeding up and down. The million costs no digit: one radian leaves as much.

    In every direction the accelerations at the start have another round-off, of 1e-10: frame and elements can turn against each other
    with hardly any mass, so that the mass matrix on a unit diagonal has a condition of 1.2e7. The first step takes over a sixth of that,
    and numerical damping takes it out again.
    """
    q, v = steady(beam)
    x = np.linspace(0, 1, 21)[1:]
    v[4::3], v[5::3] = 0.1 * x**2, 0.2 * x
    options = RunOptions(end_time=0.2, step=1e-3, rho_inf=0.8)
    here, far = (simulate(beam, options, np.where(np.arange(beam.n_q) == 2, angle, q), v) for angle in (0.0, angle))
    size = np.abs(here.q[:, 3:]).max()
    np.testing.assert_allclose(far.q[:, 3:], here.q[:, 3:], rtol=0, atol=1e-10 * size)
    np.testing.assert_allclose(far.q[100:, 3:], here.q[100:, 3:], rtol=0, atol=1e-13 * size)
    np.testing.assert_allclose(far.q[:, 2] - angle, here.q[:, 2], rtol=0, atol=1e-7)  # 200 roundings of up to 5e-10
    size = np.abs(here.multipliers).max()
    np.testing.assert_allclose(turned_by(-angle, far.multipliers), here.multipliers, rtol=0, atol=1e-7 * size)


def turned_by(angle: float, forces: np.ndarray) -> np.ndarray:
    """Forces (n, 2), turned by an angle."""
    c, s = np.cos(angle), np.sin(angle)
    return forces @ np.array([[c, s], [-s, c]])


ROD = Scene(
    units="m-kg-s",
    points={"O": Point(x=0.0, y=0.0), "P": Point(x=1.0, y=0.0)},
    bodies={"rod": Rod(between=("O", "P"), area=1.0, density=1.0)},
    joints={
        "O": Revolute(bodies=("rod", "ground"), point="O"),
        "motor": AngleDriver(bodies=("rod", "ground"), point="O", curve=SmoothStep(height=TURN * MILLION, duration=1e5)),
    },
)


def test_a_rod_that_is_driven_a_million_turns_stops_where_it_started():
    """In 1000 steps of up to 2000 turns, joints closed by positions: its angle is the curve's, its centre is where the angle says."""
    run = simulate(compile_scene(ROD), RunOptions(end_time=1.2e5, step=120.0, formulation="index-3"))
    assert run.q[-1, 2] == TURN * MILLION
    np.testing.assert_allclose(run.q[-1, :2], [0.5, 0.0], rtol=0, atol=1e-9)  # 2 pi 1e6 is rounded to 1e-9
    turned = ROD.joints["motor"].curve.evaluate(run.times)[:, 0]
    np.testing.assert_allclose(run.q[:, 2], turned, rtol=1e-15)
    np.testing.assert_allclose(run.q[:, :2], 0.5 * np.column_stack([np.cos(turned), np.sin(turned)]), rtol=0, atol=1e-9)


def spin(formulation: str, per_turn: int, turns: int, rho_inf: float = 0.8):
    scene = ROD.model_copy(
        update={
            "bodies": {"rod": Rod(between=("O", "P"), area=1.0, density=1.0, velocity=(0.0, SPEED / 2, SPEED))},
            "joints": {"O": ROD.joints["O"]},
        }
    )
    step = TURN / SPEED / per_turn
    return simulate(
        compile_scene(scene), RunOptions(end_time=turns * per_turn * step, step=step, rho_inf=rho_inf, formulation=formulation)
    )


@FORMULATIONS
def test_a_rod_whose_centre_goes_round_needs_steps_that_follow_it_and_then_keeps_its_time(formulation):
    """theta = omega t. A rigid body is described by its centre, so that every turn has to be resolved: third order of what a turn loses."""
    errors = [abs(spin(formulation, count, 100).q[-1, 2] / (100 * TURN) - 1) for count in (100, 200)]
    assert errors[1] < 1e-3
    assert 1.8 < np.log2(errors[0] / errors[1]) < 3.5  # at least the second order


def test_steps_of_a_twentieth_of_a_turn_are_refused():
    with pytest.raises(ConvergenceError, match="joints came apart"):
        spin("index-1", 20, 20)
    with pytest.raises(ConvergenceError, match="Newton stopped"):
        spin("index-3", 20, 200, 0.8)


def test_what_too_long_steps_lose_shows_in_the_energy():
    """Every turn loses the same small part, so that many add up: a quarter of the energy after 400, where no single step is coarse."""
    run = spin("index-1", 60, 400)
    lost = 1 - (run.v[-1, 2] / SPEED) ** 2
    assert lost > 0.2
    assert energy_balance(run).relative_defect == pytest.approx(lost, rel=0.05)
