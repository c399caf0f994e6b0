"""Scenes that follow each kind of curve, against Newton's and Euler's laws: what a driver exerts is inertia times the curve's f''."""

from __future__ import annotations

import json
from itertools import pairwise
from typing import Annotated, Any

import numpy as np
import pytest

from ffrf import extend
from tests.models.curves import CURVES, ROUGH
from tests.scene_file.test_schemas import complaints
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.components.bodies.rigid import Rigid, SpatialRigid
from toolkit.components.curves.combined import Product, Sequence, Sum
from toolkit.components.curves.curve import Curve
from toolkit.components.curves.oscillation import Sine
from toolkit.components.curves.polynomial import Constant, Polynomial
from toolkit.components.curves.rise import Cycloid
from toolkit.components.joints.driver import AngleDriver, PositionDriver, SpatialAngleDriver, SpatialPositionDriver
from toolkit.components.joints.prismatic import Prismatic
from toolkit.components.joints.revolute import Revolute, SpatialRevolute
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.point_force import PointForce, SpatialPointForce
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.files.gradient_units import converted, variable_unit
from toolkit.files.results import table_of
from toolkit.files.scene_reader import read_scene, scene_from_table
from toolkit.foundation.errors import InputError
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement
from toolkit.scene.scene import Scene

INERTIA, MASS, END, STEPS = 0.7, 1.3, 1.6, 400
SOLVER = RunOptions(end_time=END, step=END / STEPS, tolerance=1e-12, drift_tolerance=0.1, assemble=True)


def flywheel(dimension: int, curve: Curve) -> Scene:
    """A wheel whose angle follows a curve; the curve begins at zero."""
    curve = Sum(terms=(Constant(value=-float(curve.evaluate(np.zeros(1))[0, 0])), curve))
    where: dict[str, Any] = {"bodies": ("wheel", "ground"), "point": "O"}
    rest: dict[str, Any] = {
        "units": "m-kg-s",
        "responses": {"torque": JointForce(joint="drive", component="torque")},
        "solver": SOLVER,
    }
    if dimension == 2:
        return Scene(
            points={"O": Point(x=0.0, y=0.0)},
            bodies={"wheel": Rigid(mass=MASS, inertia=INERTIA, center="O")},
            joints={"hinge": Revolute(**where), "drive": AngleDriver(**where, curve=curve)},
            **rest,
        )
    axis = (0.0, 0.0, 1.0)
    return Scene(
        dimension=3,
        points={"O": Point(x=0.0, y=0.0, z=0.0)},
        bodies={"wheel": SpatialRigid(mass=MASS, inertia=(0.9, 0.8, INERTIA, 0.0, 0.0, 0.0), center="O")},
        joints={"hinge": SpatialRevolute(**where, axis=axis), "drive": SpatialAngleDriver(**where, axis=axis, curve=curve)},
        **(rest | {"responses": {"torque": JointForce(joint="drive", component="torque-z")}}),
    )


def sled(dimension: int, curve: Curve) -> Scene:
    """A mass on a rail that a curve times 2 N pushes."""
    rest: dict[str, Any] = {
        "units": "m-kg-s",
        "responses": {"way": Displacement(body="sled", point="O", component="x")},
        "solver": SOLVER,
    }
    if dimension == 2:
        return Scene(
            points={"O": Point(x=0.0, y=0.0)},
            bodies={"sled": Rigid(mass=MASS, inertia=1.0, center="O")},
            joints={"rail": Slider(bodies=("sled", "ground"), point="O", axis=(1.0, 0.0), lock_rotation=True)},
            loads={"push": PointForce(body="sled", point="O", force=(2.0, 0.0), curve=curve)},
            **rest,
        )
    return Scene(
        dimension=3,
        points={"O": Point(x=0.0, y=0.0, z=0.0)},
        bodies={"sled": SpatialRigid(mass=MASS, inertia=(1.0, 1.0, 1.0, 0.0, 0.0, 0.0), center="O")},
        joints={"rail": Prismatic(bodies=("sled", "ground"), point="O", axis=(1.0, 0.0, 0.0))},
        loads={"push": SpatialPointForce(body="sled", point="O", force=(2.0, 0.0, 0.0), curve=curve)},
        **rest,
    )


SMOOTH = sorted(set(CURVES) - ROUGH)
CLOSE = 2e-3
"""Second order with h = 4e-3: h^2 f'''' / 12 with a time scale of 0.1, about (0.04)^2; measured 1.2e-3 of a sine of 2 Hz."""
INNER = "joints.drive.curve.terms.1."


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("name", SMOOTH)
def test_the_torque_of_a_driver_is_inertia_times_the_second_derivative(name, dimension):
    """M = J f''(T), and dM / dp = J df''(T) / dp for every number p of the curve, direct and by the adjoint."""
    curve, exact, end = CURVES[name], {}, np.array([END])
    for path, value in curve.numbers():
        exact[f"{INNER}{path}"] = INERTIA * curve.with_number(path, value + 1e-30j).evaluate(end)[0, 2].imag / 1e-30
    expected = INERTIA * curve.evaluate(end)[0, 2]
    scene = flywheel(dimension, curve)
    for method in ("direct", "adjoint"):
        found = gradients_by(method, scene, list(exact), "transient")
        assert found.values["torque"] == pytest.approx(expected, abs=CLOSE * max(1.0, abs(expected)))
        assert found.gradients["torque"] == pytest.approx(exact, abs=CLOSE * max(1.0, *map(abs, exact.values())))


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("name", CURVES)
def test_a_load_moves_a_mass_by_the_double_integral_of_its_curve(name, dimension):
    """x(T) = F / m times the integral of (T - t) s(t), by fine quadrature between the corners."""
    curve = CURVES[name]
    found = gradients_by("direct", sled(dimension, curve), [], "transient")
    edges = np.unique(np.clip([0.0, *np.real(np.array(curve.corners())), END], 0, END))
    nodes, weights = np.polynomial.legendre.leggauss(20)
    exact = 0.0
    for low, high in pairwise(edges):
        t = (low + high) / 2 + (high - low) / 2 * nodes
        exact += (high - low) / 2 * weights @ ((END - t) * curve.evaluate(t)[:, 0])
    exact *= 2 / MASS
    # second order: (T / 400)^2 / 12 times second derivatives of 100
    assert found.values["way"] == pytest.approx(exact, abs=2e-4)


def test_the_units_of_coefficients_are_those_of_the_value_per_power_of_time(tmp_path):
    scene = flywheel(2, Polynomial(coefficients=(0.0, 0.0, 0.4), start=0.1))
    path = f"{INNER}coefficients"
    assert [variable_unit(scene, f"{path}.{k}") for k in range(3)] == ["rad", "rad/s", "rad/s^2"]
    assert variable_unit(scene, f"{INNER}start") == "s"
    pushed = sled(2, Product(curve=Sine(frequency=1.0), factors=(Polynomial(coefficients=(1.0, 0.5)),)))
    assert variable_unit(pushed, "loads.push.curve.factors.0.coefficients.y") == "1/s"


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_cam_in_other_units_moves_alike(dimension, tmp_path):
    """A position driver by a sequence with a polynomial of lengths, in m and in mm."""
    back = Polynomial(coefficients=(5.0, 0.0, -0.02, 0.004))  # it goes on from the reached value with the slope zero
    curve = Sequence(curves=(Cycloid(height=0.01, duration=0.2), back), times=(0.2,))
    scene = sled(dimension, Constant())
    where: dict[str, Any] = {"bodies": ("sled", "ground"), "point": "O", "axis": (1.0, 0.0, 0.0)[:dimension]}
    cam = PositionDriver(**where, curve=curve) if dimension == 2 else SpatialPositionDriver(**where, curve=curve)
    scene = scene.model_copy(update={"joints": {**scene.joints, "cam": cam}})
    other = converted(scene, "mm-t-s", tmp_path)
    path = "joints.cam.curve.curves.1.coefficients.2"
    assert other.number(path) == pytest.approx(-20.0)
    ways = [gradients_by("direct", each, [path], "transient") for each in (scene, other)]
    t = END - 0.2
    assert ways[0].values["way"] == pytest.approx(0.01 - 0.02 * t**2 + 0.004 * t**3, rel=1e-5)  # index 1 drifts by 1e-6
    assert ways[0].gradients["way"][path] == pytest.approx(t**2, rel=1e-5)
    assert ways[1].values["way"] == pytest.approx(1000 * ways[0].values["way"])
    assert ways[1].gradients["way"][path] == pytest.approx(ways[0].gradients["way"][path])


def test_a_file_names_curves_and_mistakes_in_them(tmp_path):
    text = """
units = "m-kg-s"
points = { O = [0.0, 0.0] }
bodies = { wheel = { type = "rigid", mass = 1.0, inertia = 0.7, center = "O" } }
[joints]
hinge = { type = "revolute", bodies = ["wheel", "ground"], point = "O" }
[joints.drive]
type = "angle-driver"
bodies = ["wheel", "ground"]
point = "O"
curve = { type = "sequence", curves = [{ type = "ramp" }, { type = "polynomial", coefficients = [0.0, SLOPE] }], times = [1.0] }
"""
    file = tmp_path / "scene.toml"
    file.write_text(text.replace("SLOPE", "0.0, 1.0"))
    assert table_of(read_scene(file))["joints"]["drive"]["curve"]["curves"][1] == {
        "type": "polynomial",
        "coefficients": [0.0, 0.0, 1.0],
        "start": 0.0,
    }
    for slope, words in {
        "2.0": r"joints\.drive\.curve: a driver needs a curve with a second derivative; .* jumps, from 0 to 2 at t = 1, where its curve 1",
        "true": r"joints\.drive\.curve\.curves\.1\.coefficients\.1: .* valid number \(given: True\)",
    }.items():
        file.write_text(text.replace("SLOPE", slope))
        with pytest.raises(InputError, match=words):
            read_scene(file)


class Fading(extend.Curve):
    """f(t) = height exp(-rate t)."""

    kind = "fading"

    height: Annotated[extend.Number, extend.Quantity()] = 1.0
    rate: Annotated[extend.Positive, extend.Quantity("1/time")]

    def rates(self, time):
        f = self.height * np.exp(-self.rate * time)
        return f, -self.rate * f, self.rate**2 * f


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_curve_of_ones_own_stands_in_a_file_and_is_differentiated(dimension, tmp_path):
    """x(T) = F / m (T / r - (1 - exp(-r T)) / r^2), and its derivative by r."""
    rate, table = 1.7, table_of(sled(dimension, Fading(rate=1.7)))
    assert table["loads"]["push"]["curve"] == {"type": "fading", "height": 1.0, "rate": 1.7}
    scene, path = scene_from_table(table, tmp_path / "scene.toml"), "loads.push.curve.rate"

    def way(r: complex) -> complex:
        return 2 / MASS * (END / r - (1 - np.exp(-r * END)) / r**2)

    variables = [path, "loads.push.curve.height"]
    for method in ("direct", "adjoint"):
        found = gradients_by(method, scene, variables, "transient")
        # second order: h^2 / 12 times r^2, 4e-6
        assert found.values["way"] == pytest.approx(way(rate), rel=1e-5)
        assert found.gradients["way"][path] == pytest.approx(way(rate + 1e-30j).imag / 1e-30, rel=1e-4)
        assert found.gradients["way"]["loads.push.curve.height"] == pytest.approx(way(rate), rel=1e-5)
    few = scene.model_copy(
        update={"solver": SOLVER.model_copy(update={"step": END / 20})}
    )  # of which both are derivatives exactly
    exact, found = (gradients_by(method, few, variables, "transient").gradients["way"] for method in ("complex-step", "direct"))
    assert found == pytest.approx(exact, rel=1e-10)
    assert variable_unit(scene, path) == "1/s"


@pytest.mark.parametrize("name", CURVES)
def test_every_curve_meets_the_schema_and_comes_back_from_a_table(name, tmp_path):
    scene = sled(2, CURVES[name])
    table = table_of(scene)
    assert complaints(json.loads(json.dumps({key: table[key] for key in ("units", "points", "bodies", "loads")})), "scene") == []
    assert scene_from_table(table, tmp_path / "scene.toml").loads == scene.loads
    table["loads"]["push"]["curve"]["nonsense"] = 1.0
    assert complaints({key: table[key] for key in ("units", "points", "bodies", "loads")}, "scene") != []


@pytest.mark.parametrize("name", ["cubic ramp", "monotone table"])
def test_a_jump_of_the_second_derivative_costs_no_order(name):
    """What the joint opens falls as the square of the step, though f'' jumps where steps end and between them; torque and angle follow."""
    curve, opened, end = CURVES[name], [], np.array([END])
    for steps in (400, 1600):
        scene = flywheel(2, curve)
        options = scene.solver.model_copy(update={"step": END / steps})
        found = gradients_by("direct", scene.model_copy(update={"solver": options}), [], "transient")
        opened.append(found.solution.drift)
        assert found.values["torque"] == pytest.approx(INERTIA * curve.evaluate(end)[0, 2], abs=1e-8)
    assert opened[1] < opened[0] / 12  # second order: a sixteenth
