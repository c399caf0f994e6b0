"""Momentum, angular momentum and energy, computed from the invariants and the bodies' data, not from the equations of motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.curves.combined import Sum
from toolkit.components.curves.oscillation import Sine
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.driver import AngleDriver
from toolkit.components.joints.revolute import Revolute
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.springs import RotationalSpringDamper, SpringDamper
from toolkit.components.loads.torque import Torque
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.foundation.kinematics.orientation import rotation
from toolkit.reduced_model.file import load
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import System, compile_scene

WING = Path(__file__).parents[2] / "models" / "morphing_wing"
TILDE = np.array([[0.0, -1.0], [1.0, 0.0]])
DURATION = 0.01
"""A good half of a period of the skin's first bending mode, in which it tumbles by 40 degrees and flies 36 mm."""


@pytest.fixture(scope="module")
def invariants():
    return load(WING / "skin.h5").invariants


def free_skin(gravity: tuple[float, float] = (0.0, 0.0)) -> System:
    skin = Flexible(model="skin.h5", frame="moving", position=(10, -20), angle=0.4, velocity=(3e3, -2e3, 60.0))
    loads = {"gravity": Gravity(acceleration=gravity)}
    return compile_scene(Scene(units="mm-t-s", bodies={"skin": skin}, loads=loads, directory=WING))


def vibrating_start(system: System) -> np.ndarray:
    """The given motion of the frame and the first and third bending mode of the free skin, up to 2 and 1 m/s."""
    q, v, *_ = system.start()
    terms = system.evaluate(system.inputs(0, np.array([1.0, 0, 0])), q, 0 * q, 0 * q)
    modes = eigh(system.matrix(terms.A_q).toarray(), system.matrix(terms.I_acc).toarray())[1][:, [3, 5]]
    return v + modes / np.abs(modes[3::3]).max(axis=0) @ [2e3, 1e3]


def balance(inv, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Momentum, angular momentum about the origin, kinetic and strain energy of a floating body (theory section 1)."""
    A, omega, z, z_rate = rotation(q[2]), v[2], np.append(1, q[3:]), np.append(0, v[3:])
    lever, relative = A @ TILDE @ inv.first_moment @ z, A @ inv.first_moment @ z_rate
    momentum = inv.mass * v[:2] + omega * lever + relative
    spin = lever @ v[:2] + omega * z @ inv.inertia @ z + z @ inv.gyroscopic @ z_rate
    kinetic = (
        v[:2] @ momentum + omega * spin + v[:2] @ relative + z_rate @ inv.inertia @ z_rate + omega * z @ inv.gyroscopic @ z_rate
    ) / 2
    return momentum, q[0] * momentum[1] - q[1] * momentum[0] + spin, kinetic + q[3:] @ inv.stiffness @ q[3:] / 2


def center(inv, q: np.ndarray) -> np.ndarray:
    return q[:2] + rotation(q[2]) @ inv.first_moment @ np.append(1, q[3:]) / inv.mass


def rates(steps: list[int], errors: list) -> np.ndarray:
    """Order at which the errors vanish between the last two numbers of steps."""
    return np.log(np.array(errors[-2]) / errors[-1]) / np.log(steps[-1] / steps[-2])


def run(system: System, steps: int, duration: float = DURATION, v: np.ndarray | None = None, **options) -> Solution:
    return simulate(system, RunOptions(end_time=duration, step=duration / steps, **{"rho_inf": 1.0, **options}), v=v)


def test_a_free_tumbling_vibrating_skin_conserves_momentum_angular_momentum_and_energy(invariants):
    system = free_skin()
    v = vibrating_start(system)[: system.n_q]
    steps, errors = [1600, 3200, 6400], []
    for count in steps:
        solution = run(system, count, v=v)
        p, spin, energy = map(
            np.array, zip(*(balance(invariants, *state) for state in zip(solution.q, solution.v, strict=True)), strict=True)
        )
        drift = np.abs(p - p[0]).max() / np.linalg.norm(p[0]), np.ptp(spin) / abs(spin[0]), np.ptp(energy) / energy[0]
        errors.append(drift)
    strain = solution.q[:, 3:] @ invariants.stiffness * solution.q[:, 3:]
    assert strain.sum(axis=1).max() / 2 > 0.1 * energy[0]  # the skin does vibrate
    assert solution.q[-1, 2] - solution.q[0, 2] > 0.5  # and does tumble
    assert np.all(np.array(errors[-1]) < 5e-6)  # (omega h)^2 / 12 at the third mode's strain, summed over its share of the motion
    assert np.all(rates(steps, errors) > 1.7)  # second order, not yet asymptotic: the stiffest of the modes has 285 kHz


def test_gravity_changes_momentum_by_impulse_and_energy_by_work(invariants):
    g = np.array([2e5, -3e5])  # strong, so that it matters in 10 ms
    system = free_skin(tuple(g))
    v = vibrating_start(system)[: system.n_q]
    steps, errors = [1600, 3200], []
    for count in steps:
        solution = run(system, count, v=v)
        p, _, energy = map(
            np.array, zip(*(balance(invariants, *state) for state in zip(solution.q, solution.v, strict=True)), strict=True)
        )
        height = np.array([center(invariants, q) for q in solution.q]) @ g
        impulse = invariants.mass * np.outer(solution.times, g)
        errors.append(
            (
                np.abs(p - p[0] - impulse).max() / np.linalg.norm(impulse[-1]),
                np.ptp(energy - invariants.mass * height) / energy[0],
            )
        )
    assert np.all(np.array(errors[-1]) < 3e-5)  # second order in the step, as without gravity
    assert np.all(rates(steps, errors) > 1.7)


def beam_scene(directory: Path, **settings) -> Scene:
    section = Section(youngs_modulus=7e10, density=2700.0, thickness=0.01, width=0.05)
    save_beam(directory / "beam.h5", np.column_stack([np.linspace(0, 1, 9), np.zeros(9)]), section, {"tip": 1.0})
    return Scene(units="m-kg-s", bodies={"beam": Flexible(model="beam.h5", frame="grounded", **settings)}, directory=directory)


@pytest.mark.parametrize("scheme", ["paper", "arnold-bruels"])
@pytest.mark.parametrize("rho_inf", [0.0, 0.5, 0.9])
def test_numerical_dissipation_never_feeds_energy(tmp_path, scheme, rho_inf):
    """What remains above any later time only falls: the largest energy of the rest of the run, from the second step on."""
    system = compile_scene(beam_scene(tmp_path))
    inv = load(tmp_path / "beam.h5").invariants
    v = np.random.default_rng(2).normal(size=system.n_q)  # all frequencies, 8 Hz to 130 kHz
    solution = run(system, 400, 0.4, v, rho_inf=rho_inf, scheme=scheme)
    kinetic = np.einsum("ti,ij,tj->t", solution.v, inv.inertia[1:, 1:], solution.v) / 2
    energy = kinetic + np.einsum("ti,ij,tj->t", solution.q, inv.stiffness, solution.q) / 2
    assert energy.max() <= energy[0] * (1 + 1e-9)
    thirds = [part.max() for part in np.array_split(energy[1:], 4)]
    assert all(np.diff(thirds) < 0)
    assert energy[-1] < 0.5 * energy[0]  # high frequencies are gone


def test_linear_vibration_with_rho_inf_one_keeps_its_energy_to_round_off(tmp_path):
    """For a linear system and rho_inf = 1 the scheme is the trapezoidal rule, which conserves quadratic energies exactly."""
    system = compile_scene(beam_scene(tmp_path))
    inv = load(tmp_path / "beam.h5").invariants
    v = np.random.default_rng(2).normal(size=system.n_q)
    solution = run(system, 400, 0.4, v)
    kinetic = np.einsum("ti,ij,tj->t", solution.v, inv.inertia[1:, 1:], solution.v) / 2
    energy = kinetic + np.einsum("ti,ij,tj->t", solution.q, inv.stiffness, solution.q) / 2
    np.testing.assert_allclose(
        energy, energy[0], rtol=1e-7
    )  # the Newton tolerance 1e-10, times the stiffest frequency over the lowest


def rigid_energy(solution: Solution, masses: list[tuple[float, float]]) -> np.ndarray:
    diagonal = np.array([value for mass, inertia in masses for value in (mass, mass, inertia)])
    return solution.v**2 @ diagonal / 2


def test_spring_dampers_take_from_two_flying_bodies_what_they_store_and_dissipate():
    points = {"P": (0, 0), "Q": (1, 0.2), "a": (0.2, 0.3), "b": (0.9, -0.3)}
    stiffness, damping, turning, friction = 30.0, 0.8, 2.0, 0.1
    scene = Scene(
        units="m-kg-s",
        points={name: Point(x=x, y=y) for name, (x, y) in points.items()},
        bodies={
            "one": Rigid(mass=1.3, inertia=0.2, center="P", velocity=(1.0, 2.0, 3.0)),
            "two": Rigid(mass=0.8, inertia=0.1, center="Q", velocity=(-1.0, 0.5, -4.0)),
        },
        loads={
            "spring": SpringDamper(bodies=("one", "two"), points=("a", "b"), stiffness=stiffness, damping=damping, length=0.5),
            "turn": RotationalSpringDamper(bodies=("one", "two"), point="a", stiffness=turning, damping=friction, rest_angle=0.3),
        },
    )
    system, steps, errors = compile_scene(scene), [1000, 2000], []
    for count in steps:
        solution = run(system, count, 2.0)
        q, v = solution.q.reshape(-1, 2, 3), solution.v.reshape(-1, 2, 3)
        arms = [np.array([0.2, 0.3]), np.array([-0.1, -0.5])]
        arm = [np.array([rotation(angle) @ arms[k] for angle in q[:, k, 2]]) for k in range(2)]
        d = q[:, 0, :2] + arm[0] - q[:, 1, :2] - arm[1]
        speeds = [v[:, k, :2] + v[:, k, 2:] * arm[k] @ TILDE.T for k in range(2)]
        length, turn = np.linalg.norm(d, axis=1), q[:, 0, 2] - q[:, 1, 2] - 0.3
        rate = ((speeds[0] - speeds[1]) * d).sum(axis=1) / length
        stored = (stiffness * (length - 0.5) ** 2 + turning * turn**2) / 2
        power = damping * rate**2 + friction * (v[:, 0, 2] - v[:, 1, 2]) ** 2
        lost = np.append(0, np.cumsum((power[1:] + power[:-1]) / 2) * np.diff(solution.times))
        energy = rigid_energy(solution, [(1.3, 0.2), (0.8, 0.1)])
        total = energy + stored + lost
        errors.append(np.ptp(total) / total[0])
        momentum = 1.3 * v[:, 0, :2] + 0.8 * v[:, 1, :2]
        # rows of translation are linear in the accelerations, so momentum is kept to Newton's tolerance
        np.testing.assert_allclose(momentum, np.tile(momentum[0], (count + 1, 1)), atol=1e-8)
    assert lost[-1] > 0.2 * total[0]
    assert errors[-1] < 1e-4  # second order: (frequency 10 1/s x step 1e-3)^2
    assert rates(steps, errors) > 1.9


def driven_scene(drive: dict) -> Scene:
    points = {"O": (0, 0), "A": (0.6, 0.1), "B": (1.1, -0.3)}
    return Scene(
        units="m-kg-s",
        points={name: Point(x=x, y=y) for name, (x, y) in points.items()},
        bodies={"upper": Rod(between=("O", "A"), area=1.0, density=1.0), "lower": Rod(between=("A", "B"), area=1.0, density=1.5)},
        joints={
            "O": Revolute(bodies=("upper", "ground"), point="O"),
            "A": Revolute(bodies=("upper", "lower"), point="A"),
            **drive.get("joints", {}),
        },
        loads={"gravity": Gravity(acceleration=(0.0, -9.81)), **drive.get("loads", {})},
    )


def mechanical_energy(scene: Scene, solution: Solution) -> np.ndarray:
    masses = [scene.bodies[name].mass_properties(loaded(scene)) for name in ("upper", "lower")]
    heights = solution.q[:, [1, 4]] @ [m for m, *_ in masses]
    return rigid_energy(solution, [(m, inertia) for m, _, inertia in masses]) + 9.81 * heights


def integral(solution: Solution, power: np.ndarray) -> np.ndarray:
    return np.append(0, np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(solution.times)))


def test_the_work_of_a_driver_is_the_energy_that_the_mechanism_gains():
    curve = Sum(terms=(SmoothStep(height=2.0, duration=1.0), Sine(amplitude=0.5, frequency=1.5)))
    scene = driven_scene({"joints": {"drive": AngleDriver(bodies=("upper", "ground"), point="O", curve=curve)}})
    system, steps, errors = compile_scene(scene), [1000, 2000], []
    for count in steps:
        solution = run(system, count, 2.0, rho_inf=0.8)
        energy = mechanical_energy(scene, solution)
        work = integral(solution, -solution.multipliers[:, -1] * curve.evaluate(solution.times)[:, 1])
        errors.append(np.abs(energy - energy[0] - work).max() / np.ptp(energy))
    assert errors[-1] < 5e-4  # that this falls with the square of the step is the point
    assert rates(steps, errors) > 1.8


def test_the_work_of_a_torque_between_two_bodies_is_the_energy_that_they_gain():
    curve = SmoothStep(duration=0.5)
    motor = Torque(body="lower", point="A", torque=3.0, curve=curve, reaction="upper")
    scene = driven_scene({"loads": {"motor": motor}})
    system, steps, errors = compile_scene(scene), [2000, 4000], []
    for count in steps:
        solution = run(system, count, 1.5, rho_inf=0.8)
        energy = mechanical_energy(scene, solution)
        work = integral(solution, 3.0 * curve.evaluate(solution.times)[:, 0] * (solution.v[:, 5] - solution.v[:, 2]))
        errors.append(np.abs(energy - energy[0] - work).max() / np.ptp(energy))
    assert errors[-1] < 5e-4  # that this falls with the square of the step is the point
    assert rates(steps, errors) > 1.8
