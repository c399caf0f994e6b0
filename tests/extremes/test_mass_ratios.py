"""Masses from 1e-8 to 1e8 of their neighbours': a heavy partner is a support, a light one is not there, and momentum is kept."""

from __future__ import annotations

import numpy as np
import pytest

from toolkit.analyses.modes import solve_modes, undeformed
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.springs import SpringDamper
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene

RATIOS = [1e-8, 1e-4, 1.0, 1e4, 1e8]
GRAVITY = 9.81
FORMULATIONS = pytest.mark.parametrize("formulation", ["index-1", "index-3", "ggl"])


@pytest.mark.parametrize("ratio", RATIOS)
def test_two_masses_on_a_spring_swing_as_one_reduced_mass(ratio):
    """d(t) - l_0 = A cos(omega t), omega^2 = k (1 + 1/ratio); the trapezoidal rule swings with 2/h atan(omega h / 2)."""
    scene = Scene(
        units="m-kg-s",
        points={"P": Point(x=0.0, y=0.0), "Q": Point(x=1.0, y=0.0)},
        bodies={"one": Rigid(mass=1.0, inertia=1.0, center="P"), "two": Rigid(mass=ratio, inertia=ratio, center="Q")},
        loads={"spring": SpringDamper(bodies=("one", "two"), points=("P", "Q"), stiffness=1.0, length=0.8)},
    )
    omega = np.sqrt(1 + 1 / ratio)
    step = 3.5 * np.pi / omega / 400
    run = simulate(compile_scene(scene), RunOptions(end_time=400 * step, step=step, rho_inf=1.0))
    stretch = run.q[:, 3] - run.q[:, 0] - 0.8
    np.testing.assert_allclose(
        stretch, 0.2 * np.cos(2 / step * np.arctan(omega * step / 2) * run.times), rtol=0, atol=1e-13
    )  # round-off
    momentum = run.v[:, 0] + ratio * run.v[:, 3]
    assert np.abs(momentum).max() <= 1e-13 * np.abs(run.v[:, 0]).max()  # round-off of 400 sums
    # the heavy one moves by 0.2 / ratio of the light one's way, below the last digit of its place at 1 m
    np.testing.assert_allclose(run.q[:, 0] + ratio * (run.q[:, 3] - 1), 0, atol=1e-13 * max(1, ratio))


def cart(mass: float, tip: tuple[float, float]) -> Scene:
    """A rod of 1 kg/m hangs from a cart on a level rail."""
    return Scene(
        units="m-kg-s",
        points={"P": Point(x=0.0, y=0.0), "Q": Point(x=tip[0], y=tip[1])},
        bodies={"cart": Rigid(mass=mass, inertia=mass, center="P"), "rod": Rod(between=("P", "Q"), area=1.0, density=1.0)},
        joints={
            "rail": Slider(bodies=("cart", "ground"), point="P", lock_rotation=True),
            "pin": Revolute(bodies=("rod", "cart"), point="P"),
        },
        loads={"weight": Gravity(acceleration=(0.0, -GRAVITY))},
    )


@pytest.mark.parametrize("mass", RATIOS)
def test_a_rod_on_a_cart_swings_between_a_fixed_and_a_free_support(mass):
    """omega^2 = m g l / (J + m l^2 - (m l)^2 / (M + m)), J = m L^2 / 12, l = L/2, m = L = 1."""
    found = solve_modes(undeformed(compile_scene(cart(mass, (0.0, -1.0))))).frequencies
    omega = np.sqrt(0.5 * GRAVITY / (1 / 3 - 0.25 / (mass + 1)))
    assert found[0] == pytest.approx(0, abs=1e-6)
    assert found[1] * 2 * np.pi == pytest.approx(omega, rel=1e-7)  # round-off of the ratio itself, 1e-16 x 1e8


@FORMULATIONS
@pytest.mark.parametrize("mass", RATIOS)
def test_a_rod_on_a_cart_keeps_momentum_and_energy(mass, formulation):
    run = simulate(
        compile_scene(cart(mass, (0.6, -0.8))), RunOptions(end_time=1.0, step=1e-3, rho_inf=0.8, formulation=formulation)
    )
    parts = mass * run.v[:, 0], run.v[:, 3]
    assert np.abs(sum(parts)).max() <= 1e-13 * max(np.abs(part).max() for part in parts)  # linear: round-off of 1000 sums
    centre = mass * run.q[:, 0] + run.q[:, 3]
    # the projection of "ggl" moves both ends of a joint alike, whatever their masses: by its part of the scheme's error
    error = 1e-6 if formulation == "ggl" else 1e-12
    np.testing.assert_allclose(centre, centre[0], rtol=0, atol=error * max(1, mass))
    energy = (run.v[:, [0, 3, 4, 5]] ** 2 @ [mass, 1, 1, 1 / 12]) / 2 + GRAVITY * run.q[:, 4]
    assert np.ptp(energy) < 1e-4 * np.ptp(GRAVITY * run.q[:, 4])  # second order: (10 1/s x 1 ms)^2


@FORMULATIONS
@pytest.mark.parametrize(("mass", "fixed"), [(1e8, True), (1e-8, False)])
def test_a_cart_of_extreme_mass_is_a_bearing_or_a_frictionless_rail_for_the_rod(mass, fixed, formulation):
    run = simulate(
        compile_scene(cart(mass, (0.6, -0.8))), RunOptions(end_time=1.0, step=1e-3, rho_inf=0.8, formulation=formulation)
    )
    held = run.q[:, 0] if fixed else run.q[:, 3] - run.q[0, 3]
    # the ratio itself, of a metre; and what "ggl" projects
    np.testing.assert_allclose(held, 0, atol=1e-6 if formulation == "ggl" else 1e-8)


def double(ratio: float, formulation: str) -> Solution:
    """A rod of 1 m and 1 kg from the horizontal, with a rod of 0.5 m at its end that is `ratio` times as heavy per length."""
    scene = Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "P": Point(x=-1.0, y=0.0), "Q": Point(x=-1.5, y=0.0)},
        bodies={
            "upper": Rod(between=("O", "P"), area=1.0, density=1.0),
            "lower": Rod(between=("P", "Q"), area=1.0, density=ratio),
        },
        joints={"O": Revolute(bodies=("upper", "ground"), point="O"), "P": Revolute(bodies=("lower", "upper"), point="P")},
        loads={"weight": Gravity(acceleration=(0.0, -GRAVITY))},
    )
    return simulate(compile_scene(scene), RunOptions(end_time=1.0, step=1e-3, rho_inf=0.8, formulation=formulation))


@FORMULATIONS
@pytest.mark.parametrize("ratio", RATIOS)
def test_a_double_pendulum_keeps_its_energy_and_forces_between_its_parts_go_with_the_mass(ratio, formulation):
    run = double(ratio, formulation)
    masses, inertias = np.array([1.0, 0.5 * ratio]), np.array([1 / 12, 0.5 * ratio / 48])
    q, v = run.q.reshape(-1, 2, 3), run.v.reshape(-1, 2, 3)
    weight = GRAVITY * q[:, :, 1] * masses
    energy = (v[:, :, :2] ** 2).sum(axis=2) @ masses / 2 + v[:, :, 2] ** 2 @ inertias / 2 + weight.sum(axis=1)
    assert np.ptp(energy) < 2e-4 * np.ptp(weight, axis=0).max()  # second order: (15 1/s x 1 ms)^2
    # Newton's law of the lower rod: the joint carries m (a - g)
    force = 0.5 * ratio * (run.a[:, 3:5] + [0, GRAVITY])
    scale = np.abs(force).max()
    np.testing.assert_allclose(np.abs(run.multipliers[:, 2:]), np.abs(force), rtol=0, atol=1e-8 * scale)  # Newton's tolerance


@FORMULATIONS
def test_a_feather_on_a_pendulum_does_not_disturb_it(formulation):
    """Compared with the pendulum that carries a thousandth of it: the disturbance is linear in the mass."""
    lighter, light, heavy = (double(ratio, formulation).q[-1, 2] for ratio in (1e-12, 1e-8, 1e-5))
    assert (light - lighter) / (heavy - lighter) == pytest.approx(
        1e-3, rel=0.05
    )  # the second order in 1e-5, and round-off of 1e-8
    assert light == pytest.approx(lighter, abs=1e-7)
