"""Linkages whose gradients are certified: direct differentiation = adjoint = complex step, every derivative relative to itself."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from tests.models.directions import along, derivative_along, direction
from tests.scenes.test_benchmarks import CHAIN, slider_crank
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.sensitivity.preparation import Kind, values_of
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.point_force import PointForce
from toolkit.components.loads.springs import RotationalSpringDamper, SpringDamper
from toolkit.components.loads.torque import Torque
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.responses.energy import KineticEnergy
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.over_time import TimeIntegral
from toolkit.responses.stress import KSStress, MaxStress
from toolkit.scene.scene import Scene
from toolkit.system.quantities import STEP

AGREEMENT = 1e-9
"""All methods are exact for the discrete equations. What differs is round-off of the state, 1e-16 of the model size, times the
condition of the equations: up to 1e6, the ratio of a thin rod's stretching to its bending stiffness."""
METHODS = ("direct", "adjoint", "complex-step")


def agree(by: Mapping[str, Mapping[str, Mapping[str, float]]]) -> None:
    """Every derivative of every response, relative to itself."""
    for name, slopes in by["direct"].items():
        assert all(slopes.values()), name
        for method in by.keys() - {"direct"}:
            assert by[method][name] == pytest.approx(slopes, rel=AGREEMENT, abs=0), (name, method)


def certified(scene: Scene, design: list[str], kind: Kind = "transient") -> None:
    """All three methods agree: for each response one complex step, along which every number moves it by about one."""
    found = {method: gradients_by(method, scene, design, kind) for method in METHODS[:2]}
    by = {method: each.gradients for method, each in found.items()}
    agree(by)
    for name, slopes in by["direct"].items():
        factors = {path: part / abs(slopes[path]) for path, part in direction(design).items()}
        judge = derivative_along(scene, factors, kind, found["direct"].solution)[name]
        assert along(slopes, factors) == pytest.approx(judge, rel=0, abs=AGREEMENT), name


# --- flexible slider-crank ------------------------------------------------------------------------------------------------------

CRANK, ROD, START = 0.15, 0.4, np.radians(50)
CRANK_PIN = (CRANK * np.cos(START), CRANK * np.sin(START))
AXIS_ANGLE = -np.arcsin(CRANK_PIN[1] / ROD)
PISTON = CRANK_PIN[0] + ROD * np.cos(AXIS_ANGLE)


@pytest.fixture(scope="module")
def rod_folder(tmp_path_factory):
    """A connecting rod of steel, 6 mm thick, of four elements, with Rayleigh damping."""
    folder = tmp_path_factory.mktemp("rod")
    nodes = np.column_stack([np.linspace(0, ROD, 5), np.zeros(5)])
    section = Section(
        youngs_modulus=2.1e11, density=7850.0, thickness=0.006, width=0.02, damping_mass=0.5, damping_stiffness=1e-5
    )
    save_beam(folder / "rod.h5", nodes, section, {"crank": 0.0, "piston": ROD})
    return folder


def flexible_slider_crank(folder, **solver: Any) -> Scene:
    """Crank OA turned by a torque, flexible rod AB with a moving frame, piston at B on the x axis against a spring and a damper."""
    return Scene(
        units="m-kg-s",
        directory=folder,
        points={
            "O": Point(x=0.0, y=0.0),
            "A": BodyPoint(body="rod", interface="crank"),
            "B": BodyPoint(body="rod", interface="piston"),
            "W": Point(x=1.0, y=0.0),
        },
        bodies={
            "crank": Rod(between=("O", "A"), area=4e-4, density=7850.0),
            "rod": Flexible(model="rod.h5", frame="moving", position=CRANK_PIN, angle=AXIS_ANGLE),
            "piston": Rigid(mass=0.5, inertia=1e-3, center="B"),
        },
        joints={
            "O": Revolute(bodies=("crank", "ground"), point="O"),
            "A": Revolute(bodies=("crank", "rod"), point="A"),
            "B": Revolute(bodies=("rod", "piston"), point="B"),
            "guide": Slider(bodies=("piston", "ground"), point="B", axis=(1.0, 0.0), lock_rotation=True),
        },
        loads={
            "drive": Torque(body="crank", point="O", torque=40.0, curve=SmoothStep(duration=0.02)),
            "gas": SpringDamper(bodies=("piston", "ground"), points=("B", "W"), stiffness=2000.0, damping=30.0, length=0.55),
        },
        responses={
            "ks": KSStress(body="rod", aggregation=30.0, reference_stress=1e7),
            "stress": MaxStress(body="rod", when="end"),
            "stroke": Displacement(body="piston", point="B", component="x"),
            "turn": Rotation(body="crank", point="O"),
            "hinge": JointForce(joint="A", component="magnitude"),
            "side": JointForce(joint="guide", component="y", time=0.016),
        },
        solver=RunOptions(end_time=0.02, step=0.002, tolerance=1e-13, **solver),
    )


ROD_DESIGN = [
    "bodies.crank.area",
    "bodies.crank.density",
    "bodies.rod.thickness",
    "bodies.rod.youngs_modulus",
    "bodies.rod.density",
    "bodies.rod.width",
    "bodies.piston.mass",
    "loads.gas.stiffness",
    "loads.gas.damping",
    "loads.gas.length",
    "loads.drive.torque",
    "loads.drive.curve.duration",
    "points.O.x",
    "points.W.x",
]


@pytest.mark.parametrize(("scheme", "rho_inf"), [("arnold-bruels", 0.8), ("paper", 0.5)])
def test_flexible_slider_crank_with_a_moving_frame(rod_folder, scheme, rho_inf):
    certified(flexible_slider_crank(rod_folder, scheme=scheme, rho_inf=rho_inf), ROD_DESIGN)


# --- double pendulum ------------------------------------------------------------------------------------------------------------


def double_pendulum() -> Scene:
    """Two rods with springs and dampers to the ground, across the first, and in the second hinge."""
    places = {"O": (0.0, 0.0), "A": (0.7, -0.6), "B": (1.5, -1.0), "G": (1.3, 0.4), "H": (-0.2, -1.4)}
    return Scene(
        units="m-kg-s",
        points={name: Point(x=x, y=y) for name, (x, y) in places.items()},
        bodies={
            "upper": Rod(between=("O", "A"), area=0.8, density=1.2, angular_velocity=0.6),
            "lower": Rod(between=("A", "B"), area=0.5, density=1.1, angular_velocity=-0.4),
        },
        joints={
            "O": Revolute(bodies=("upper", "ground"), point="O"),
            "A": Revolute(bodies=("upper", "lower"), point="A"),
        },
        loads={
            "weight": Gravity(acceleration=(0.0, -9.81)),
            "hanger": SpringDamper(bodies=("upper", "ground"), points=("A", "G"), stiffness=14.0, damping=0.7, length=0.9),
            "stay": SpringDamper(bodies=("lower", "ground"), points=("B", "H"), stiffness=6.0, damping=0.4),
            "coil": RotationalSpringDamper(bodies=("lower", "upper"), point="A", stiffness=3.0, damping=0.2, rest_angle=0.15),
            "tip": PointForce(body="lower", point="B", force=(0.9, 1.7)),
        },
        responses={
            "upper": Rotation(body="upper", point="O"),
            "lower": Rotation(body="lower", point="A"),
            "reach": Displacement(body="lower", point="B", component="magnitude"),
            "hinge": JointForce(joint="A", component="magnitude"),
            "energy": TimeIntegral(of=KineticEnergy()),
        },
        solver=RunOptions(end_time=0.6, step=0.02, tolerance=1e-13, rho_inf=0.9),
    )


def test_double_pendulum_with_springs_by_all_its_numbers():
    scene = double_pendulum()
    certified(scene, scene.available_paths())


def test_double_pendulum_with_springs_at_rest():
    scene = double_pendulum()
    moving = ("velocity", "damping")
    certified(scene, [path for path in scene.available_paths() if not any(word in path for word in moving)], "static")


# --- SUNDIALS slider-crank ------------------------------------------------------------------------------------------------------


def benchmark_scene() -> Scene:
    """The benchmark over its whole time in coarse steps (its published values: `test_benchmarks`), with its functional and its end."""
    responses = {
        "G": TimeIntegral(of=KineticEnergy()),
        "q": Rotation(body="crank", point="O"),
        "x": Displacement(body="rod", point="X", component="x"),
        "pin": JointForce(joint="X", component="y"),
    }
    solver = RunOptions(end_time=10.0, step=0.1, rho_inf=1.0, tolerance=1e-13)
    return slider_crank().model_copy(update={"responses": responses, "solver": solver})


def parameters(crank: complex, rod: complex, **values: complex) -> dict[str, complex]:
    """Numbers of the scene by the benchmark's parameters: where its points lie follows from crank radius and rod length."""
    pin = np.sqrt(rod**2 - crank**2)
    points = {"T.y": crank, "H.y": crank / 2, "X.x": pin, "M.x": pin / 2, "M.y": crank / 2, "W.x": 2 * pin, "W.y": -crank}
    return {f"points.{name}": value for name, value in points.items()} | {next(iter(CHAIN[n])): v for n, v in values.items()}


NOMINAL: dict[str, float] = {"crank": 0.5, "rod": 1.0, "k": 1, "c": 1, "l0": 1, "F": 1, "J1": 1, "J2": 2, "m2": 1}
NAMES = {"a": "crank", "L": "rod"}


def stepped(factors: dict[str, float]) -> dict[str, float]:
    """Derivatives of all responses along a direction of the parameters: the geometry, and the whole run, in complex numbers."""
    scene = benchmark_scene()
    moved: dict[str, complex] = {x: value + 1j * STEP * factors.get(x, 0.0) for x, value in NOMINAL.items()}
    for path, value in parameters(**moved).items():
        if np.imag(value):
            scene = scene.with_number(path, value)
    return {name: np.imag(value) / STEP for name, value in values_of(scene, "transient").items()}


def test_sundials_slider_crank_by_all_nine_parameters():
    paths = sorted({path for chain in CHAIN.values() for path in chain})
    by_path = {method: gradients_by(method, benchmark_scene(), paths, "transient").gradients for method in METHODS[:2]}
    by: dict[str, dict[str, dict[str, float]]] = {
        method: {
            response: {n: sum(factor * slopes[path] for path, factor in chain.items()) for n, chain in CHAIN.items()}
            for response, slopes in found.items()
        }
        for method, found in by_path.items()
    }
    agree(by)
    for response, slopes in by["direct"].items():
        factors = {name: part / abs(slopes[name]) for name, part in direction(CHAIN).items()}
        judge = stepped({NAMES.get(name, name): factor for name, factor in factors.items()})[response]
        assert along(slopes, factors) == pytest.approx(judge, rel=0, abs=AGREEMENT), response
