"""The energy monitor: against energies from other formulations, by its order, and where a scheme is known to create energy."""

from __future__ import annotations

import numpy as np
import pytest

from tests.models.scenes import MODELS, WING, hanging_skin
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import Rod
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.driver import AngleDriver
from toolkit.components.joints.revolute import Revolute
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.springs import RotationalSpringDamper, SpringDamper
from toolkit.components.loads.torque import Torque
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.responses.energy import KineticEnergy, StrainEnergy
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene
from toolkit.validity.energy_balance import energy_balance, energy_defects
from toolkit.validity.motion import ENERGY_DEFECT_LIMIT


def linkage() -> Scene:
    """Two rods with everything that puts energy in or takes it out: driver, torque, gravity, springs and dampers."""
    places = {"O": (0.0, 0.0), "A": (1.0, 0.2), "B": (1.8, -0.3), "S": (2.0, 1.0)}
    return Scene(
        units="m-kg-s",
        points={name: Point(x=x, y=y) for name, (x, y) in places.items()},
        bodies={"crank": Rod(between=("O", "A"), area=1.0, density=1.0), "arm": Rod(between=("A", "B"), area=1.0, density=0.7)},
        joints={
            "O": Revolute(bodies=("crank", "ground"), point="O"),
            "drive": AngleDriver(bodies=("crank", "ground"), point="O", curve=SmoothStep(height=1.5, duration=1.0)),
            "A": Revolute(bodies=("crank", "arm"), point="A"),
        },
        loads={
            "weight": Gravity(acceleration=(0.3, -9.81)),
            "motor": Torque(body="arm", point="A", torque=2.0, reaction="crank"),
            "brake": RotationalSpringDamper(bodies=("arm", "crank"), point="A", stiffness=3.0, damping=0.8),
            "strut": SpringDamper(bodies=("arm", "ground"), points=("B", "S"), stiffness=4.0, damping=0.5),
        },
    )


@pytest.mark.parametrize("scene", [linkage(), hanging_skin()], ids=["driven linkage", "flexible, moving frame"])
def test_work_and_energy_balance_to_second_order(scene):
    """Scheme and quadrature are both of second order, so that halving the step quarters the defect."""
    end = scene.solver.end_time
    defects = []
    for steps in (200, 400):
        options = RunOptions(end_time=end, step=end / steps, rho_inf=1.0, tolerance=1e-13)
        defects.append(energy_balance(simulate(compile_scene(scene), options)).relative_defect)
    assert defects[1] < 1e-3  # (2 pi h / period)^2 / 12 at the shortest period that carries energy
    assert np.log2(defects[0] / defects[1]) == pytest.approx(2.0, abs=0.35)  # not quite asymptotic for the stiff skin


def test_its_energies_are_those_of_the_responses():
    run = simulate(compile_scene(hanging_skin()))
    balance = energy_balance(run)
    kinetic = [KineticEnergy().at(run, n).value for n in range(len(run.times))]
    strain = [StrainEnergy().at(run, n).value for n in range(len(run.times))]
    # the same products, summed in another order
    np.testing.assert_allclose(balance.kinetic, kinetic, rtol=1e-12)
    np.testing.assert_allclose(balance.strain, strain, rtol=1e-9, atol=1e-12 * max(strain))


def test_compiled_and_plain_work_agree():
    scene = linkage()
    options = RunOptions(end_time=0.1, step=0.01)
    compiled = energy_balance(simulate(compile_scene(scene), options)).work
    plain = energy_balance(simulate(compile_scene(scene.with_number("points.S.x", 2.0 + 0j)), options)).work
    np.testing.assert_allclose(plain.real, compiled, rtol=1e-9)  # Newton's tolerance


@pytest.mark.parametrize("model", ["bricard", "spinning_beam", "morphing_wing_large"])
def test_what_velocities_add_to_forces_does_the_work_that_the_mass_matrix_takes(model):
    """Lagrange's identity v . (M'(v) v / 2 - f_v) = 0, by which the power is that of bodies which feel no velocities."""
    system = compile_scene(read_scene(MODELS.parent / model / "scene.toml"))
    (q, *_), n_q = system.start(), system.n_q
    v, rest = np.zeros((2, system.n))
    v[:n_q] = np.random.default_rng(3).normal(size=n_q) / system.weights[:n_q]
    for body in system.scene.all_bodies():
        turn = system.numbering.first[body] + 3
        if system.scene.dimension == 3:  # quaternions keep their length
            unit = q[turn : turn + 4]
            v[turn : turn + 4] -= unit * (unit @ v[turn : turn + 4])
    inputs = system.inputs(0.0, np.zeros(3))
    found = system.evaluate(inputs, q, v, np.append(v[:n_q], rest[n_q:]))
    still = system.evaluate(inputs._replace(inertia=False), q, v, rest, linearize=False)
    rates = v * system.times(found.I_q, v[:, None])[:, 0] / 2
    forces = v[:n_q] * (found.applied - still.applied)[:n_q]
    assert (rates[:n_q] - forces).sum() == pytest.approx(0.0, abs=1e-10 * np.abs(forces).sum())
    assert np.abs(forces).sum() > 0


def test_the_papers_scheme_creates_energy_to_first_order_on_the_wing():
    scene, defects = read_scene(WING), []
    for step in (0.02, 0.01):
        run = simulate(compile_scene(scene), scene.solver.model_copy(update={"scheme": "paper", "step": step}))
        balance = energy_balance(run)
        assert balance.defect[-1] > 0
        defects.append(balance.relative_defect)
    assert defects[0] / defects[1] == pytest.approx(2.0, rel=0.1)


def test_a_damper_without_inertia_creates_nothing_where_nothing_stores_energy():
    """A rod that follows its torque against a spring and a damper, which take all that the torque does: the sum of the works is an error of
    first order, and would be all of the largest energy."""
    rod = linkage()
    loads = {
        "turn": Torque(body="crank", point="O", torque=3.0, curve=SmoothStep(duration=1.0)),
        "brake": RotationalSpringDamper(bodies=("crank", "ground"), point="O", stiffness=9.0, damping=0.8),
    }
    alone = {"bodies": {"crank": rod.bodies["crank"]}, "joints": {"O": rod.joints["O"]}, "loads": loads}
    options = RunOptions(end_time=1.2, step=0.02, quasi_static=True)
    created, lost = energy_defects(simulate(compile_scene(rod.model_copy(update=alone)), options))
    assert max(created, lost) < ENERGY_DEFECT_LIMIT / 2  # by first order some h / T = 1/60 of the damper's work


def test_rest_has_no_defect():
    scene = linkage().model_copy(update={"loads": {}})
    rest = scene.model_copy(update={"joints": {name: joint for name, joint in scene.joints.items() if name != "drive"}})
    assert energy_balance(simulate(compile_scene(rest), RunOptions(end_time=0.1, step=0.05))).relative_defect == 0
