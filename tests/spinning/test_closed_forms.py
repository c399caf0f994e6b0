"""Steady states of spins and their modes against closed forms, in the plane and in space."""

from __future__ import annotations

import numpy as np
import pytest

from tests.spatial.scenes import save_frame
from tests.spatial.test_frames import AREA, BEAM, ENDS, RHO, SECOND, E
from tests.spinning.scenes import SPINNING, Z, governor, motor, planar_blade, table, table_in_space, top
from toolkit.analyses.modes import Modes, solve_modes, undeformed
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.components.bodies.flexible import SpatialFlexible
from toolkit.components.bodies.rigid import Rigid
from toolkit.components.joints.driver import AngleDriver, SpatialAngleDriver
from toolkit.components.joints.revolute import Revolute
from toolkit.components.loads.springs import SpringDamper
from toolkit.description.design import Point
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution

ROUND_OFF = 1e-11
"""Of problems of a few numbers."""


def spin(scene: Scene) -> tuple[Solution, Modes]:
    state = solve(prepare(scene), "static")
    return state, solve_modes(state)


@pytest.mark.parametrize("make", [table, table_in_space], ids=["plane", "space"])
def test_a_block_on_a_radial_spring_of_a_table_that_spins(make):
    """k (r - 2) = m Omega^2 r, and s^2 + c s / m + k / m - Omega^2 = 0."""
    speed, k, m, c = 3.0, 50.0, 2.0, 1.0
    state, modes = spin(make(speed, k, m, c))
    where = np.real(state.q[0, state.coordinates("block")])[: state.system.scene.dimension]
    origin = state.system.scene.position("O")
    assert np.linalg.norm(where - origin) == pytest.approx(k * 2 / (k - m * speed**2), rel=ROUND_OFF)
    square = k / m - speed**2
    assert modes.frequencies == pytest.approx([np.sqrt(square - (c / m / 2) ** 2) / (2 * np.pi)], rel=ROUND_OFF)
    assert modes.damping == pytest.approx([c / m / 2 / np.sqrt(square)], rel=ROUND_OFF)
    assert modes.verdict.trusted


def test_a_table_that_spins_faster_than_its_spring_can_hold_has_an_unstable_state():
    """k < m Omega^2: the state beyond the axis is one that a block runs away from, with exp(sqrt(Omega^2 - k / m) t)."""
    speed, k, m = 6.0, 50.0, 2.0
    state, modes = spin(table(speed, k, m, damping=0.0))
    assert f"grows like exp({np.sqrt(speed**2 - k / m):.4g} t)" in " ".join(state.verdict.reasons)
    assert modes.frequencies == pytest.approx([-np.sqrt(speed**2 - k / m) / (2 * np.pi)], rel=ROUND_OFF)
    (caution,) = modes.verdict.warnings
    assert (caution.code, caution.doubt) == ("unstable", True)


def test_a_pendulum_on_a_table_is_held_outwards_by_its_spin():
    """omega^2 = Omega^2 m R l / (m l^2 + J), whatever the mass of the table."""
    R, length, m, J, speed = 0.8, 0.3, 1.5, 0.02, 4.0
    scene = Scene(
        units="m-kg-s",
        points={"O": Point(x=-1.0, y=2.0), "H": Point(x=-1.0 + R, y=2.0), "G": Point(x=-1.0 + R + length, y=2.0)},
        bodies={"table": Rigid(mass=3.0, inertia=1.0, center="O"), "bob": Rigid(mass=m, inertia=J, center="G")},
        joints={
            "axis": Revolute(bodies=("table", "ground"), point="O"),
            "motor": AngleDriver(bodies=("table", "ground"), point="O", curve=motor(-speed)),
            "hinge": Revolute(bodies=("bob", "table"), point="H"),
        },
        solver=SPINNING,
    )
    _, modes = spin(scene)
    assert modes.frequencies == pytest.approx(
        [speed * np.sqrt(m * R * length / (m * length**2 + J)) / (2 * np.pi)], rel=ROUND_OFF
    )


def test_the_ball_of_a_governor_rises_and_vibrates_as_textbooks_say():
    """(m l^2 + I_t - I_a) Omega^2 cos = m g l, and omega^2 = (m l^2 + I_t - I_a) / (m l^2 + I_t) Omega^2 sin^2."""
    speed, length, gravity, across, along = 6.0, 0.7, 9.81, 0.02, 0.01
    state, modes = spin(governor(speed, length, gravity, across, along))
    x, y, z = np.real(state.q[0, state.coordinates("ball")])[:3]
    cosine = gravity * length / (length**2 + across - along) / speed**2
    assert -z / length == pytest.approx(cosine, rel=ROUND_OFF)
    assert np.hypot(x, y) / length == pytest.approx(np.sqrt(1 - cosine**2), rel=ROUND_OFF)
    square = (length**2 + across - along) / (length**2 + across) * speed**2 * (1 - cosine**2)
    assert modes.frequencies == pytest.approx([np.sqrt(square) / (2 * np.pi)], rel=ROUND_OFF)


@pytest.mark.parametrize("speed", [1.0, 5.0, 9.0])
def test_whirls_of_a_disc_split_by_its_gyroscopic_moments(speed):
    """I_t w^2 - I_p Omega w - k = 0 in a frame at rest; the frame that spins sees |w - Omega|."""
    polar, across, k = 0.5, 0.3, 40.0
    _, modes = spin(top(speed, polar, across, k))
    whirls = np.roots([across, -polar * speed, -k])
    expected = np.sort(np.abs(whirls - speed)) / (2 * np.pi)
    assert modes.frequencies[:2] == pytest.approx(expected, rel=1e-7)  # the cross weighs 1e-9


def shaft(folder, speed: float, **damping: float) -> Scene:
    text = BEAM.format(elements=4, tip=[0.0, 0.0, 1.0], modulus=E, basis="")
    save_frame(folder, "beam", text)
    body = SpatialFlexible(model="beam.h5", frame="turning", axis=Z, **damping)
    drive = SpatialAngleDriver(bodies=("beam", "ground"), point="root", axis=Z, curve=motor(speed))
    return Scene(
        units="m-kg-s",
        dimension=3,
        directory=folder,
        points=ENDS,
        bodies={"beam": body},
        joints={"motor": drive},
        solver=SPINNING,
    )


@pytest.mark.parametrize("part", [0.4, 1.6])
def test_a_shaft_with_inner_damping_whirls_stably_below_its_critical_speed_alone(tmp_path, part):
    """(s + i Omega)^2 + alpha s + omega^2 = 0 of each bending mode, seen from the shaft; it grows from Omega = omega on.

    Damping that follows the stiffness is of the deformation alone: alpha = c omega^2.
    """
    omega, alpha = 1.875104068711961**2 * np.sqrt(E * SECOND / (RHO * AREA)), 2.0
    speed = part * omega
    state, modes = spin(shaft(tmp_path, speed, damping_stiffness=alpha / omega**2))
    roots = np.roots([1, 2j * speed + alpha, omega**2 - speed**2])
    order = np.argsort(np.abs(roots.imag))
    close = 2e-4  # of four elements, and the inertia of the section
    vibrating = np.flatnonzero(np.abs(modes.damping) < 0.9)[:2]  # not what is stiff along the shaft, which creeps
    assert modes.frequencies[vibrating] == pytest.approx(np.abs(roots.imag)[order] / (2 * np.pi), rel=close)
    assert modes.damping[vibrating] == pytest.approx((-roots.real / np.abs(roots))[order], rel=10 * close)
    assert (modes.damping.min() < 0) == (part > 1) == ("unstable" in modes.verdict.codes)
    assert ("critical-speed" in state.verdict.codes) == ("unstable-vibration" in state.verdict.codes) == (part > 1)


@pytest.mark.parametrize("part", [0.4, 1.6])
def test_a_shaft_whose_whole_velocity_is_damped_whirls_stably_at_any_speed(tmp_path, part):
    """s^2 + alpha s + omega^2 = 0 seen from the ground, s - i Omega from the shaft: outer damping, which follows the mass."""
    omega, alpha = 1.875104068711961**2 * np.sqrt(E * SECOND / (RHO * AREA)), 2.0
    _, modes = spin(shaft(tmp_path, part * omega, damping_mass=alpha))
    roots = np.concatenate([np.roots([1, alpha, omega**2]) + sign * 1j * part * omega for sign in (1, -1)])
    slow = roots[np.argmin(np.abs(roots.imag))]
    assert modes.frequencies[0] == pytest.approx(abs(slow.imag) / (2 * np.pi), rel=1e-3)  # of four elements
    assert modes.damping[0] == pytest.approx(-slow.real / abs(slow), rel=1e-3)
    assert "unstable" not in modes.verdict.codes


def test_a_bar_that_spins_is_stretched_and_pulls_as_the_closed_form_says(tmp_path):
    """E u'' + rho Omega^2 (x + u) = 0: x + u = sin(k x) / (k cos k), and the axis carries the inertia of the whole bar."""
    errors = []
    for parts in (4, 8):
        state, _ = spin(planar_blade(tmp_path, parts, 600.0))
        q = np.real(state.q[0])
        at = [q[state.system.numbering.first[name] :][:2] for name in state.system.scene.bodies]
        reach = np.hypot(*at[parts // 2])  # where the body begins at the middle of the bar
        k = 600.0 * np.sqrt(2700.0 / 6.75e10)
        errors.append(reach - np.sin(k / 2) / (k * np.cos(k)))
    stretch = np.sin(k / 2) / (k * np.cos(k)) - 0.5
    assert abs(errors[1]) < 0.02 * stretch
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)  # linear elements


def rotor(speed: float, across: float, damping: float = 0.0) -> Scene:
    """A rotor of 2 kg on four springs to the ground, two of 50 N/m along x and two along y."""
    ends = {"E": (1.0, 0.0), "N": (0.0, 1.0), "W": (-1.0, 0.0), "S": (0.0, -1.0)}
    springs = {
        name: SpringDamper(
            bodies=("rotor", "ground"), points=("O", name), stiffness=50.0 if name in "EW" else across, damping=damping
        )
        for name in ends
    }
    return Scene(
        units="m-kg-s",
        points={name: Point(x=x + 0.3, y=y - 0.2) for name, (x, y) in {"O": (0.0, 0.0), **ends}.items()},
        bodies={"rotor": Rigid(mass=2.0, inertia=1.0, center="O")},
        joints={"motor": AngleDriver(bodies=("rotor", "ground"), point="O", curve=motor(speed))},
        loads=springs,
        solver=SPINNING,
    )


@pytest.mark.parametrize("speed", [3.0, 15.0])
def test_a_rotor_on_springs_whirls_with_both_of_its_frequencies(speed):
    """Jeffcott: sqrt(k / m) at rest, |sqrt(k / m) - Omega| and sqrt(k / m) + Omega in the frame that spins; outer damping damps."""
    _, modes = spin(rotor(speed, 50.0))
    still = np.sqrt(100.0 / 2.0)
    assert modes.frequencies == pytest.approx(np.array([abs(still - speed), still + speed]) / (2 * np.pi), rel=ROUND_OFF)
    assert modes.verdict.trusted
    _, damped = spin(rotor(speed, 50.0, damping=1.0))
    outer = np.roots([1.0, 1.0, 50.0])  # 2 c / m
    roots = outer - 1j * speed
    assert damped.frequencies == pytest.approx(np.sort(np.abs(roots.imag)) / (2 * np.pi), rel=ROUND_OFF)
    assert (damped.damping > 0).all()


def test_a_rotor_on_springs_that_differ_is_no_matter_of_modes_in_a_frame_that_spins():
    """It rests in all of them at every angle; what small motions meet changes twice in a turn."""
    with pytest.raises(InputError, match=r"1 rad further the linearised equations of [xy] of body 'rotor' are other ones"):
        spin(rotor(3.0, 60.0))


def test_joints_that_repeat_each_other_change_nothing():
    """A table on two hinges; the joint forces of the rows left out are zero."""
    scene = table_in_space(3.0, 50.0, 2.0, 1.0)
    again = scene.joints["hinge"].model_copy()
    options = SPINNING.model_copy(update={"redundant": "least-squares"})
    doubled = scene.model_copy(update={"joints": {**scene.joints, "again": again}, "solver": options})
    one, two = spin(scene)[1], spin(doubled)[1]
    assert two.frequencies == pytest.approx(one.frequencies, rel=ROUND_OFF)
    assert two.damping == pytest.approx(one.damping, rel=1e-9)


def test_modes_about_the_given_positions_are_at_rest_whatever_statics_finds():
    scene = table(3.0, 50.0, 2.0, damping=0.0)
    modes = solve_modes(undeformed(prepare(scene)))
    assert modes.damping is None
    assert modes.frequencies == pytest.approx([5.0 / (2 * np.pi)], rel=ROUND_OFF)
    assert "spins" in modes.verdict.codes
