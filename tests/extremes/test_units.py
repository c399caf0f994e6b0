"""The same scene in m, kg, s and in mm, t, s: the same motion, forces and gradients to round-off."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.sensitivity.preparation import Kind
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.distance import Distance
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.point_force import PointForce
from toolkit.components.loads.springs import RotationalSpringDamper, SpringDamper
from toolkit.components.loads.torque import Torque
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.responses.energy import KineticEnergy, StrainEnergy
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.over_time import TimeIntegral
from toolkit.responses.stress import KSStress, MaxStress
from toolkit.scene.scene import Scene

LENGTH, MASS = 1e3, 1e-3
"""How many mm are 1 m, and how many t are 1 kg; both systems have the second, and the newton: 1 t mm/s^2."""
PRESSURE, DENSITY, TURNING = 1 / LENGTH**2, MASS / LENGTH**3, LENGTH
"""N/m^2 in N/mm^2, kg/m^3 in t/mm^3, N m in N mm."""
DESIGN = {
    "bodies.beam.thickness": LENGTH,
    "bodies.beam.youngs_modulus": PRESSURE,
    "bodies.rod.density": DENSITY,
    "points.W.x": LENGTH,
    "loads.motor.torque": TURNING,
    "loads.spring.stiffness": 1 / LENGTH,
    "loads.weight.acceleration.y": LENGTH,
}
VALUES = {
    "stress": PRESSURE, "peak": PRESSURE, "turn": 1.0, "way": LENGTH, "force": 1.0, "moment": TURNING, "strain": TURNING,
    "kinetic": TURNING, "action": TURNING,
}  # fmt: skip
"""What each number of the scene in m-kg-s is multiplied with."""


def scene(folder: Path, units: str) -> Scene:
    """A beam on a rod, with a block on a rail, springs, weight and a motor."""
    m, kg = (1.0, 1.0) if units == "m-kg-s" else (LENGTH, MASS)
    pa, n_m = kg / m, kg * m**2  # per s^2
    section = Section(
        youngs_modulus=7e10 * pa, density=2700 * kg / m**3, thickness=0.01 * m, width=0.05 * m, damping_stiffness=1e-3
    )
    save_beam(
        folder / "beam.h5",
        m * np.array([[0.0, 0.0], [0.3, 0.05], [0.6, 0.05], [1.0, 0.0]]),
        section,
        {"root": 0.0, "tip": 0.9 * m},
        units,
    )
    at = {"O": (0.0, 0.0), "A": (0.5, 0.1), "C": (1.2, -0.4), "W": (2.0, 0.3)}
    responses = {
        "stress": KSStress(body="beam", aggregation=1e-6 / pa),
        "peak": MaxStress(body="beam"),
        "turn": Rotation(body="rod", point="O"),
        "way": Displacement(body="block", point="C", component="x"),
        "force": JointForce(joint="A", component="magnitude"),
        "moment": JointForce(joint="rail", component="torque"),
        "strain": StrainEnergy(),
        "kinetic": KineticEnergy(),
        "action": TimeIntegral(of=KineticEnergy()),
    }
    return Scene(
        units=units,
        directory=folder,
        points={name: Point(x=m * x, y=m * y) for name, (x, y) in at.items()}
        | {"R": BodyPoint(body="beam", interface="root"), "T": BodyPoint(body="beam", interface="tip")},
        bodies={
            "rod": Rod(between=("O", "A"), area=1e-3 * m**2, density=7800 * kg / m**3, angular_velocity=0.2),
            "beam": Flexible(model="beam.h5", frame="moving", position=(0.5 * m, 0.1 * m), angle=-0.2),
            "block": Rigid(mass=2.0 * kg, inertia=0.1 * kg * m**2, center="C"),
        },
        joints={
            "O": Revolute(bodies=("rod", "ground"), point="O"),
            "A": Revolute(bodies=("beam", "rod"), point=("R", "A")),
            "bar": Distance(bodies=("beam", "block"), points=("T", "C")),
            "rail": Slider(bodies=("block", "ground"), point="C", axis=(1.0, 0.2), lock_rotation=True),
        },
        loads={
            "weight": Gravity(acceleration=(0.0, -9.81 * m)),
            "spring": SpringDamper(bodies=("block", "ground"), points=("C", "W"), stiffness=3000 * kg, damping=2.0 * kg),
            "coil": RotationalSpringDamper(bodies=("rod", "ground"), point="O", stiffness=800 * n_m, damping=0.1 * n_m),
            "motor": Torque(body="rod", point="O", torque=3.0 * n_m, curve=SmoothStep(duration=0.1)),
            "push": PointForce(body="beam", point="T", force=(0.5 * kg * m, -0.3 * kg * m), frame="body"),
        },
        responses=responses,
        solver=RunOptions(end_time=0.2, step=2e-3),
    )


@pytest.mark.parametrize("kind", ["static", "transient"])
@pytest.mark.parametrize(
    "solver",
    [{}, {"formulation": "index-3"}, {"newton": "modified"}, {"local_error": 1e-4}, {"rho_inf": 0.0, "scheme": "paper"}],
    ids=str,
)
def test_a_change_of_units_changes_nothing(tmp_path, kind: Kind, solver):
    found = []
    for units in ("m-kg-s", "mm-t-s"):
        folder = tmp_path / units
        folder.mkdir()
        given = scene(folder, units)
        options = RunOptions(**{**dict(given.solver), **solver, "tolerance": 1e-12})
        found.append(direct(given.model_copy(update={"solver": options}), list(DESIGN), kind))
    si, mm = found
    if solver.get("local_error") and kind == "transient":  # round-off decides where a step is as long as it may be
        np.testing.assert_allclose(mm.solution.times, si.solution.times, rtol=0, atol=1e-9)
    # round-off through the stiffness of a beam that is 1e4 times stiffer in tension; kept factors leave Newton's tolerance
    error = 1e-6 if "newton" in solver else 1e-8
    for name, factor in VALUES.items():
        if name not in si.values:
            continue
        assert mm.values[name] == pytest.approx(factor * si.values[name], rel=error), name
        slopes = {x: factor / by * si.gradients[name][x] for x, by in DESIGN.items()}
        sizes = {x: abs(slope * si.solution.system.scene.number(x) * DESIGN[x]) for x, slope in slopes.items()}
        for x, slope in slopes.items():
            part = max(sizes.values()) / abs(si.solution.system.scene.number(x) * DESIGN[x])
            assert mm.gradients[name][x] == pytest.approx(slope, rel=error, abs=error * part), (name, x)


def test_the_two_models_differ_by_units_alone(tmp_path):
    """The invariants have the units of mass, length and stiffness, so that the test above compares the same beam."""
    from toolkit.reduced_model.file import load

    models = []
    for units in ("m-kg-s", "mm-t-s"):
        folder = tmp_path / units
        folder.mkdir()
        scene(folder, units)
        models.append(load(folder / "beam.h5"))
    si, mm = (asdict(model.invariants) for model in models)
    assert mm["mass"] == pytest.approx(si["mass"] * MASS, rel=1e-12)
    assert mm["inertia"][0, 0] == pytest.approx(si["inertia"][0, 0] * MASS * LENGTH**2, rel=1e-12)
