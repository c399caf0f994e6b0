"""Doubts about energy: told where it is lost from the answer, and not where works cancel or shorter steps show that the answer is right."""

from __future__ import annotations

import numpy as np
import pytest

from toolkit.analyses.sensitivity.compiled import Compiled
from toolkit.analyses.sensitivity.direct import values_alone
from toolkit.analyses.sensitivity.run import Run
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.driver import AngleDriver
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.friction import PlanarSlidingFriction
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.springs import SpringDamper
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement
from toolkit.scene.scene import Scene
from toolkit.validity.energy_balance import energy_defects

SLOPE, WIDTH, LEVEL = np.deg2rad(20.0), 1e-3, 5.53091
DOWN = (float(np.cos(SLOPE)), float(np.sin(SLOPE)))


def creeping() -> Scene:
    """A block of 1 kg that friction holds on a slope, but for what its width lets creep."""
    return Scene(
        units="m-kg-s",
        points={"B": Point(x=0.0, y=0.0)},
        bodies={"block": Rigid(mass=1.0, inertia=0.01, center="B")},
        joints={"slope": Slider(bodies=("block", "ground"), point="B", axis=DOWN, lock_rotation=True)},
        loads={
            "weight": Gravity(acceleration=(0.0, -9.81)),
            "friction": PlanarSlidingFriction(bodies=("block", "ground"), point="B", axis=DOWN, level=LEVEL, width=WIDTH),
        },
        responses={"x": Displacement(body="block", point="B", component="magnitude")},
        solver=RunOptions(end_time=0.2, step=1e-3),
    )


def led_crank(scheme: str) -> Scene:
    """A rod that is turned against its weight by 0.3 rad and stands still then."""
    return Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "A": Point(x=1.0, y=0.0)},
        bodies={"crank": Rod(between=("O", "A"), area=1e-3, density=1000.0)},
        joints={
            "O": Revolute(bodies=("crank", "ground"), point="O"),
            "lead": AngleDriver(bodies=("crank", "ground"), point="O", curve=SmoothStep(height=0.3, duration=0.7)),
        },
        loads={"weight": Gravity(acceleration=(0.0, -9.81))},
        responses={"torque": JointForce(joint="lead", component="torque")},
        solver=RunOptions.model_validate({"end_time": 1.2, "step": 0.02, "scheme": scheme, "rho_inf": 0.3}),
    )


def damped_away() -> Scene:
    """A mass on a spring that starts 0.1 m beside its rest, and is asked where it is; no step sees its vibration of 1 kHz."""
    return Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "B": Point(x=1.1, y=0.0)},
        bodies={"block": Rigid(mass=1.0, inertia=0.01, center="B")},
        joints={"guide": Slider(bodies=("block", "ground"), point="B", axis=(1.0, 0.0), lock_rotation=True)},
        loads={
            "spring": SpringDamper(
                bodies=("block", "ground"), points=("B", "O"), stiffness=(2000.0 * np.pi) ** 2, damping=0.0, length=1.0
            )
        },
        responses={"x": Displacement(body="block", point="B", component="x")},
        solver=RunOptions(end_time=1.0, step=0.01, rho_inf=0.0),
    )


def run(scene: Scene) -> Run:
    return values_alone(Compiled(scene, ()), "transient")


def test_creeping_friction_is_compared_with_the_works_that_cancel():
    """It slides with width * atanh(weight / level); its kinetic energy is 1e-4 of what weight and friction turn over."""
    found = run(creeping())
    rate = WIDTH * np.arctanh(9.81 * np.sin(SLOPE) / LEVEL)
    assert found.values["x"] == pytest.approx(rate * 0.2, rel=2e-3)  # it takes 1 ms to get there
    assert found.verdict.trusted


def test_energy_that_goes_away_with_the_step_is_a_remark():
    """The torque that holds the rod is m g L / 2 cos(0.3); the driver's work is summed to first order of the step."""
    found = run(led_crank("paper"))
    assert found.values["torque"] == pytest.approx(0.5 * 9.81 * np.cos(0.3), rel=1e-6)
    assert max(energy_defects(found.solution)) > 0.04
    assert found.verdict.trusted
    assert "energy" in found.verdict.codes


def test_a_vibration_that_steps_damp_away_stays_a_doubt():
    """It swings for ever, and stands still with any step that is longer than its period."""
    found = run(damped_away())
    assert "energy" in {each.code for each in found.verdict.warnings if each.doubt}
