"""Responses against closed forms, balances and other formulations, on scenes whose motion is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from tests.models.response_cases import CASES, TIP, write_models
from tests.models.scenes import WING
from toolkit.analyses.sensitivity.preparation import evaluate_responses, prepare, solve
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid, Rod, SpatialRod
from toolkit.components.curves.oscillation import Sine
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.driver import AngleDriver, SpatialAngleDriver
from toolkit.components.joints.revolute import Revolute, SpatialRevolute
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.point_force import PointForce
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.responses.balance import CentreOfMass, Mass, Power, Work
from toolkit.responses.energy import KineticEnergy, StrainEnergy
from toolkit.responses.extremes import TimeKS, TimeMax, TimeMin
from toolkit.responses.joint_force import JointForce
from toolkit.responses.local_stress import StressAlongLine, StressAtPoint, stress_places
from toolkit.responses.marker_formula import MarkerMotion
from toolkit.responses.motion import Displacement
from toolkit.responses.over_time import TimeMean, TimeMeanSquare
from toolkit.responses.point_motion import Acceleration, AngularVelocity, Deflection, PointDistance, Velocity
from toolkit.responses.relative_angle import RelativeAngle
from toolkit.responses.stress import stress_field
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.validity.energy_balance import energy_balance

DRIVEN = Sine(amplitude=0.8, frequency=1.5)
TURN = SmoothStep(height=2.5 * 2 * np.pi, duration=0.4)
"""Two turns and a half."""


def crank(curve=DRIVEN, responses=None, step=0.005, end=0.4) -> Scene:
    """A rod of 1 m, driven about one end: every point moves on a circle."""
    return Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "A": Point(x=0.6, y=0.8)},
        bodies={"rod": Rod(between=("O", "A"), area=0.01, density=1000.0)},
        joints={
            "hinge": Revolute(bodies=("rod", "ground"), point="O"),
            "drive": AngleDriver(bodies=("rod", "ground"), point="O", curve=curve),
        },
        loads={"weight": Gravity(acceleration=(0.0, -9.81))},
        responses=responses or {},
        solver=RunOptions(end_time=end, step=step, tolerance=1e-12, rho_inf=0.8),
    )


def spatial_crank(axis, curve=TURN, responses=None, turning=False) -> Scene:
    """The same in space about any axis; if `turning`, a second rod that the first carries."""
    bodies = {"rod": SpatialRod(between=("O", "A"), area=0.01, density=1000.0)}
    joints = {
        "hinge": SpatialRevolute(bodies=("rod", "ground"), point="O", axis=axis),
        "drive": SpatialAngleDriver(bodies=("rod", "ground"), point="O", axis=axis, curve=curve),
    }
    if turning:
        bodies["second"] = SpatialRod(between=("A", "B"), area=0.01, density=1000.0)
        joints["elbow"] = SpatialRevolute(bodies=("second", "rod"), point="A", axis=(0.3, 1.0, 0.2))
        joints["motor"] = SpatialAngleDriver(bodies=("second", "rod"), point="A", axis=(0.3, 1.0, 0.2), curve=curve)
    return Scene(
        units="m-kg-s",
        dimension=3,
        points={"O": Point(x=0.0, y=0.0, z=0.0), "A": Point(x=0.6, y=0.8, z=0.1), "B": Point(x=1.0, y=0.1, z=0.7)},
        bodies=bodies,
        joints=joints,
        responses=responses or {},
        solver=RunOptions(end_time=0.4, step=0.002, tolerance=1e-12, rho_inf=0.8),
    )


def motion(scene):
    return solve(prepare(scene), "transient")


def test_a_point_on_a_circle_has_its_velocity_and_acceleration():
    """r = 1: speed |theta'|, along the circle theta'', towards the centre theta'^2."""
    point = {"body": "rod", "point": "A"}
    asked = {
        "speed": Velocity(**point),
        "x": Acceleration(**point, component="x"),
        "y": Acceleration(**point, component="y"),
        "turn": AngularVelocity(**point),
    }
    found = evaluate_responses(motion(crank(responses=asked, step=0.001)))
    angle, rate, growth = (value.item() for value in DRIVEN.evaluate(np.array([0.4])).T)
    direction = np.array([np.cos(angle + np.arctan2(0.8, 0.6)), np.sin(angle + np.arctan2(0.8, 0.6))])
    expected = -(rate**2) * direction + growth * np.array([-direction[1], direction[0]])
    # index 1 with stabilisation leaves a drift of the joints of 1e-6 with these steps
    assert found["turn"] == pytest.approx(rate, rel=1e-4)
    assert found["speed"] == pytest.approx(abs(rate), rel=1e-4)
    assert [found["x"], found["y"]] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.3, -0.5, 1.0)])
def test_angles_in_space_count_turns(axis):
    """Also against a body that turns itself, about an axis that turns with it; each driver says what its angle is at every time."""
    asked = {
        "angle": RelativeAngle(bodies=("rod", "ground"), point="O", axis=axis),
        "elbow": RelativeAngle(bodies=("second", "rod"), point="A", axis=(0.3, 1.0, 0.2)),
        "backwards": RelativeAngle(bodies=("ground", "rod"), point="O", axis=axis),
        "largest": TimeMax(of=RelativeAngle(bodies=("rod", "ground"), point="O", axis=axis)),
        "half": RelativeAngle(bodies=("rod", "ground"), point="O", axis=axis, time=0.2),
        "mean": TimeMean(of=RelativeAngle(bodies=("rod", "ground"), point="O", axis=axis)),
    }
    found = evaluate_responses(motion(spatial_crank(axis, responses=asked, turning=True)))
    turned = 5 * np.pi
    # drift of stabilised joints with these steps
    assert found["angle"] == pytest.approx(turned, abs=1e-4)
    assert found["elbow"] == pytest.approx(turned, abs=1e-4)
    assert found["backwards"] == pytest.approx(-turned, abs=1e-4)
    assert found["largest"] == pytest.approx(turned, abs=1e-4)
    assert found["half"] == pytest.approx(turned / 2, abs=1e-4)  # the smooth step is symmetric
    assert found["mean"] == pytest.approx(turned / 2, abs=1e-4)


def test_turns_are_counted_where_a_step_is_longer_than_half_a_turn():
    """Five steps for two turns and a half; the rate at both ends of each says how far it went."""
    asked = {"angle": RelativeAngle(bodies=("rod", "ground"), point="O", axis=(0.0, 0.0, 1.0))}
    scene = spatial_crank((0.0, 0.0, 1.0), responses=asked)
    fine = motion(scene)
    every = [*range(0, len(fine.times), 40)]
    thin = replace(fine, **{name: getattr(fine, name)[every] for name in ("times", "q", "v", "a", "multipliers")})
    assert asked["angle"].value(thin) == asked["angle"].value(fine)  # the same last state
    assert np.abs(np.diff(TURN.evaluate(thin.times)[:, 0])).max() > np.pi


def test_means_and_extremes_of_a_sine_are_those_of_the_sine():
    angle = RelativeAngle(bodies=("rod", "ground"), point="O")
    asked = {
        "mean": TimeMean(of=angle),
        "square": TimeMeanSquare(of=angle),
        "max": TimeMax(of=angle),
        "min": TimeMin(of=angle),
        "both": TimeMax(of=angle, measure="absolute"),
        "smooth": TimeKS(of=angle, aggregation=500.0),
    }
    found = evaluate_responses(motion(crank(Sine(amplitude=0.8, frequency=2.5), asked, end=0.4)))  # one period
    # the trapezoidal rule is exact for whole periods of a sine; the rest is the drift of the driver's joint
    assert found["mean"] == pytest.approx(0.0, abs=1e-5)
    assert found["square"] == pytest.approx(0.32, rel=1e-4)
    assert found["max"] == pytest.approx(0.8, rel=1e-4)
    assert found["min"] == pytest.approx(-0.8, rel=1e-4)
    assert found["both"] == pytest.approx(max(found["max"], -found["min"]), rel=1e-9)  # of equal ones the first
    assert found["max"] <= found["smooth"] <= found["max"] + np.log(81) / 500.0


@pytest.mark.parametrize("where", CASES)
def test_the_work_of_all_that_acts_is_the_energy_that_is_there(where, tmp_path):
    """Loads and driver by their own powers, against kinetic and strain energy, and against the power that the residual has in all."""
    write_models(tmp_path)
    scene = CASES[where][0](tmp_path)
    strip = _with(scene.bodies["strip"], {"damping_mass": 0.0, "damping_stiffness": 0.0})
    fine = scene.solver.model_copy(update={"step": 0.0005, "tolerance": 1e-11})
    start = {"T at first": KineticEnergy(time=0.0), "U at first": StrainEnergy(time=0.0)}
    works = {f"work of {name}": Work(load=name) for name in scene.loads} | {"work of lead": Work(joint="lead")}
    asked = {"bodies": {**scene.bodies, "strip": strip}, "solver": fine}
    responses = {**works, **start, "T": KineticEnergy(), "U": StrainEnergy()}
    solution = motion(scene.model_copy(update={**asked, "responses": responses}))
    found, balance = evaluate_responses(solution), energy_balance(solution)
    work, size = sum(found[name] for name in works), sum(abs(found[name]) for name in works)
    assert all(abs(found[name]) > 1e-3 * size for name in works)
    # second order of the trapezoidal rule and of the scheme, 120 steps
    assert work == pytest.approx(found["T"] + found["U"] - found["T at first"] - found["U at first"], abs=2e-3 * size)
    # the same rule; a driver's power there is that of its joint, which drifts
    assert work == pytest.approx(balance.work[-1], abs=1e-5 * size)
    assert found["T"] == pytest.approx(balance.kinetic[-1], rel=1e-12)
    assert found["U"] == pytest.approx(balance.strain[-1], rel=1e-12)


def _with(body, values):
    changed = body.model_copy()
    object.__setattr__(changed, "__pydantic_extra__", {**body.model_values(), **values})
    return changed


def test_a_driver_and_gravity_share_the_energy_of_a_rigid_crank():
    asked = {
        "drive": Work(joint="drive"),
        "weight": Work(load="weight"),
        "T": KineticEnergy(),
        "T at first": KineticEnergy(time=0.0),
    }
    found = evaluate_responses(motion(crank(responses=asked, step=0.001)))
    angle = DRIVEN.evaluate(np.array([0.4]))[0, 0]
    start = np.arctan2(0.8, 0.6)
    fallen = 10.0 * 9.81 * 0.5 * (np.sin(start) - np.sin(start + angle))  # m g times the fall of the middle
    # trapezoidal rule over 400 steps
    assert found["weight"] == pytest.approx(fallen, abs=1e-3)
    assert found["drive"] + found["weight"] == pytest.approx(found["T"] - found["T at first"], abs=1e-3 * found["T at first"])


@pytest.mark.parametrize("where", CASES)
def test_energies_of_bodies_add_up_and_masses_too(where, tmp_path):
    write_models(tmp_path)
    scene = CASES[where][0](tmp_path)
    solution = motion(scene.model_copy(update={"responses": {"all": CentreOfMass(component="x")}}))
    for kind in (KineticEnergy, StrainEnergy):
        parts = [kind(body=name).value(solution) for name in scene.bodies]
        assert sum(parts) == pytest.approx(kind().value(solution), rel=1e-12)
    masses = {name: Mass(bodies=(name,)).value(solution) for name in scene.bodies}
    assert masses["crank"] == pytest.approx(
        1.2 * 0.8 * np.linalg.norm(loaded(scene).position("A") - loaded(scene).position("O")), rel=1e-14
    )
    assert Mass().value(solution) == pytest.approx(sum(masses.values()), rel=1e-14)
    for component in scene.space.axes:
        places = [masses[name] * CentreOfMass(bodies=(name,), component=component).value(solution) for name in scene.bodies]
        assert CentreOfMass(component=component).value(solution) == pytest.approx(sum(places) / sum(masses.values()), rel=1e-12)


@pytest.mark.parametrize("where", CASES)
def test_the_centre_of_mass_accelerates_by_the_forces_from_outside(where, tmp_path):
    """M a_c = M g + the hinge - alpha m_s v_s: Newton's law, with the joint's force from its multipliers; alpha damps the strip."""
    write_models(tmp_path)
    scene = CASES[where][0](tmp_path)
    scene = scene.model_copy(update={"loads": {name: load for name, load in scene.loads.items() if name != "spring"}})
    solver = scene.solver.model_copy(update={"step": scene.solver.step / 2})
    system = prepare(scene.model_copy(update={"responses": {"c": CentreOfMass(component="x")}, "solver": solver}))
    solution = solve(system, "transient")
    names = tuple(scene.bodies)
    motions = MarkerMotion.of(system, [(name, "(centre of mass)") for name in names]).at(solution, -1)
    d = scene.dimension
    change = sum(Mass(bodies=(name,)).value(solution) * each.acceleration[:d] for name, each in zip(names, motions, strict=True))
    force = [sum(JointForce(joint=joint, component=c).value(solution) for joint in ("hinge", "lead")) for c in scene.space.axes]
    weight = Mass().value(solution) * np.array(scene.loads["weight"].acceleration)
    drag = 0.2 * Mass(bodies=("strip",)).value(solution) * motions[names.index("strip")].rate[:d]
    # Newton leaves a residual of 1e-13 of the forces
    assert change == pytest.approx(force + weight - drag, rel=1e-9)


def test_a_deflection_is_the_displacement_of_a_body_that_stays_where_it_is(tmp_path):
    """The wing's skin is grounded at its clamp, with axes that are those of the scene."""
    scene = read_scene(WING)
    solution = solve(
        prepare(scene.model_copy(update={"responses": {"d": Displacement(body="skin", point="C", component="x")}})), "static"
    )
    for component in ("x", "y", "magnitude"):
        seen = Displacement(body="skin", point="C", component=component).value(solution)
        assert Deflection(body="skin", point="C", component=component).value(solution) == pytest.approx(seen, rel=1e-12)


def test_a_deflection_does_not_depend_on_where_the_body_is(tmp_path):
    """The same elastic coordinates in a frame that is moved and turned."""
    write_models(tmp_path)
    solution = motion(CASES["plane"][0](tmp_path))
    moved = solution.q.copy()
    moved[:, solution.coordinates("strip").start : solution.coordinates("strip").start + 3] += [0.3, -0.2, 1.1]
    seen = Deflection(**TIP, component="y")
    assert seen.value(replace(solution, q=moved)) == seen.value(solution) != 0


def test_a_distance_is_that_of_the_points_and_its_components_those_of_the_way():
    asked = {name: PointDistance(bodies=("ground", "rod"), points=("A", "A"), component=name) for name in ("x", "y", "magnitude")}
    found = evaluate_responses(motion(crank(responses=asked)))
    angle = DRIVEN.evaluate(np.array([0.4]))[0, 0]
    assert found["magnitude"] == pytest.approx(2 * abs(np.sin(angle / 2)), rel=1e-4)  # chord of the circle; drift of the joint
    assert found["magnitude"] ** 2 == pytest.approx(found["x"] ** 2 + found["y"] ** 2, rel=1e-12)


def test_of_equal_extremes_the_first_counts_however_they_are_rounded():
    """Values that differ by less than a billionth are one; which is larger is round-off."""
    values = np.array([1.0, 2.0, 2.0 + 1e-12, -2.0 - 1e-11, 0.5])
    shares = np.full(5, 0.2)
    of = KineticEnergy()
    assert TimeMax(of=of).reduced(values, shares)[1].tolist() == [0, 1, 0, 0, 0]
    assert TimeMax(of=of, measure="absolute").reduced(values, shares)[1].tolist() == [0, 1, 0, 0, 0]
    assert TimeMax(of=of, measure="absolute").reduced(values - 1, shares)[1].tolist() == [0, 0, 0, -1, 0]
    assert TimeMin(of=of).reduced(-values, shares)[1].tolist() == [0, 1, 0, 0, 0]


WRONG = {
    "a distance of unknown bodies": (
        PointDistance(bodies=("rod", "wheel"), points=("A", "O")),
        r"responses.f names body 'wheel', which does not exist; bodies of the scene: rod, ground",
    ),
    "a point that is none": (
        PointDistance(bodies=("rod", "ground"), points=("A", "Q")),
        r"names point 'Q'.*points of the scene: O, A",
    ),
    "a component of space": (
        Velocity(body="rod", point="A", component="z"),
        r"velocity in a scene of dimension 2 has no component 'z'",
    ),
    "an axis in the plane": (
        RelativeAngle(bodies=("rod", "ground"), point="O", axis=(0.0, 0.0, 1.0)),
        r"a relative angle in space needs an `axis`.*one in the plane has none",
    ),
    "a component of a planar rate": (AngularVelocity(body="rod", point="A", component="z"), r"one in the plane has none"),
    "the deflection of a rigid body": (Deflection(body="rod", point="A"), r"'rod' is not flexible"),
    "the power of no load": (Power(load="wind"), r"names load 'wind', which does not exist; loads of the scene: weight"),
    "the power of a joint without driver": (Power(joint="hinge"), r"'hinge' has no driver.*joints with a driver: drive"),
    "the work of a joint without driver": (Work(joint="hinge"), r"'hinge' has no driver.*joints with a driver: drive"),
    "the mass of what is not there": (Mass(bodies=("rod", "hammer")), r"names body 'hammer'"),
    "a kinetic energy of nobody": (TimeMax(of=KineticEnergy(body="hammer")), r"names body 'hammer'"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_uses_say_what_would_be_right(name):
    response, message = WRONG[name]
    with pytest.raises(ValueError, match=message):
        prepare(crank(responses={"f": response}))


@pytest.mark.parametrize(
    "response",
    [Velocity(body="rod", point="A"), AngularVelocity(body="rod", point="A"), Power(load="weight"), Work(joint="drive")],
    ids=lambda response: response.kind,
)
def test_a_run_without_inertia_has_no_rates(response):
    scene = crank(responses={"f": response})
    still = scene.model_copy(update={"solver": scene.solver.model_copy(update={"quasi_static": True})})
    with pytest.raises(InputError, match=r"a quasi-static run .* knows no (velocity|angular-velocity|power)"):
        prepare(still)


def test_work_of_both_and_times_of_what_looks_at_all_are_refused():
    with pytest.raises(ValueError, match="give one of `load` and `joint`"):
        Power(load="a", joint="b")
    for bodies in (("rod", "rod"), (), ("ground",)):
        with pytest.raises(ValueError, match="one or more bodies, each once, and not the ground"):
            CentreOfMass(bodies=bodies, component="x")
    with pytest.raises(ValueError, match="leave `time` out"):
        TimeMax(of=KineticEnergy(time=0.1))


def test_turns_of_a_run_whose_beginning_is_not_kept_are_refused():
    asked = RelativeAngle(bodies=("rod", "ground"), point="O", axis=(0.0, 0.0, 1.0))
    whole = motion(spatial_crank((0.0, 0.0, 1.0), responses={"angle": asked}))
    window = replace(
        whole, run_times=whole.times, **{name: getattr(whole, name)[50:] for name in ("times", "q", "v", "a", "multipliers")}
    )
    with pytest.raises(InputError, match=r"turns are counted from the start of a run.*Raise solver.memory"):
        asked.value(window)


def test_a_free_body_falls_by_the_parabola():
    """v = g t, r = g t^2 / 2, a = g: also the centre of mass of the scene."""
    scene = Scene(
        units="m-kg-s",
        points={"C": Point(x=0.2, y=0.3)},
        bodies={"stone": Rigid(mass=2.0, inertia=0.1, center="C")},
        loads={"weight": Gravity(acceleration=(0.0, -9.81))},
        responses={
            "v": Velocity(body="stone", point="C", component="y"),
            "a": Acceleration(body="stone", point="C", component="y"),
            "c": CentreOfMass(component="y"),
            "P": Power(load="weight"),
        },
        solver=RunOptions(end_time=0.5, step=0.05),
    )
    found = evaluate_responses(motion(scene))
    # the scheme integrates a constant acceleration exactly
    assert found["v"] == pytest.approx(-4.905, rel=1e-12)
    assert found["a"] == pytest.approx(-9.81, rel=1e-12)
    assert found["c"] == pytest.approx(0.3 - 9.81 / 8, rel=1e-12)
    assert found["P"] == pytest.approx(2.0 * 9.81 * 4.905, rel=1e-12)


@pytest.mark.parametrize("where", CASES)
def test_the_largest_stress_is_that_at_its_own_place(where, tmp_path):
    """Place by place the stress is that of the field, whose largest `max-stress` has."""
    write_models(tmp_path)
    solution = motion(CASES[where][0](tmp_path))
    field, known = stress_field(solution, "strip")[0][-1], stress_places(solution.system.scene, "strip")
    row = int(np.argmax(field))
    fibre = {1: "outer", -1: "inner"}[int(known.fibre[row])]
    own = StressAtPoint(body="strip", place=tuple(known.place[row]), fibre=fibre).rows(solution.system.scene)[0]
    assert np.allclose(known.place[own], known.place[row], rtol=0, atol=1e-12)
    assert StressAtPoint(body="strip", place=tuple(known.place[row]), fibre=fibre).value(solution) == pytest.approx(
        field[own], rel=1e-12
    )
    ends = known.place[[0, 1]] if where == "space" else known.place[[0, 2]]
    along = StressAlongLine(body="strip", places=tuple(map(tuple, ends)), fibre="outer")
    assert along.value(solution) == pytest.approx(field[along.rows(solution.system.scene)].max(), rel=1e-12)  # round-off


def test_the_stress_of_a_bent_cantilever_is_that_of_the_moment(tmp_path):
    """sigma = F (L - s) t / (2 I) at the outer fibre of a beam that a force bends at its end."""
    nodes = np.column_stack([np.linspace(0, 1, 9), np.zeros(9)])
    section = Section(youngs_modulus=2e11, density=7800.0, thickness=0.01, width=0.02, damping_mass=0.0, damping_stiffness=0.0)
    save_beam(tmp_path / "beam.h5", nodes, section, {"end": 1.0})
    scene = Scene(
        units="m-kg-s",
        directory=tmp_path,
        points={"E": BodyPoint(body="beam", interface="end")},
        bodies={"beam": Flexible(model="beam.h5", frame="grounded")},
        loads={"pull": PointForce(body="beam", point="E", force=(0.0, -3.0))},
        responses={
            "root": StressAtPoint(body="beam", place=(0.0, 0.0), fibre="outer"),
            "middle": StressAtPoint(body="beam", place=(0.5, 0.0), fibre="outer"),
            "tip": StressAtPoint(body="beam", place=(1.0, 0.0), fibre="outer"),
            "mean": StressAlongLine(body="beam", places=((0.0, 0.0), (1.0, 0.0)), fibre="outer", take="mean"),
            "down": Deflection(body="beam", point="E", component="y"),
        },
    )
    found = evaluate_responses(solve(prepare(scene), "static"))
    inertia = 0.02 * 0.01**3 / 12
    root = 3.0 * 0.005 / inertia
    sign = np.sign(found["root"])
    # Euler-Bernoulli elements are exact for forces at nodes; round-off of a beam 1e4 times stiffer in tension
    assert sign * found["root"] == pytest.approx(root, rel=1e-9)
    assert sign * found["middle"] == pytest.approx(root / 2, rel=1e-9)
    assert abs(found["tip"]) < 1e-9 * root
    assert sign * found["mean"] == pytest.approx(root / 2, rel=1e-9)
    assert found["down"] == pytest.approx(-3.0 / (3 * 2e11 * inertia), rel=1e-9)


def test_a_place_far_from_the_body_and_a_wrong_fibre_are_refused(tmp_path):
    write_models(tmp_path)
    scene = loaded(CASES["plane"][0](tmp_path))
    with pytest.raises(InputError, match=r"no stress point near \[5, 5\]; the nearest is at \[1.1, 1.2\]"):
        StressAtPoint(body="strip", place=(5.0, 5.0)).check(scene)
    with pytest.raises(InputError, match=r"a place in a scene of dimension 2 has 2 numbers, not 3"):
        StressAtPoint(body="strip", place=(0.6, 0.1, 0.0)).check(scene)
    with pytest.raises(ValueError, match='`aggregation` belongs to take = "ks"'):
        StressAlongLine(body="strip", places=((0.0, 0.0), (0.6, 0.1)), aggregation=2.0)
    with pytest.raises(InputError, match="'crank' is not flexible"):
        StressAtPoint(body="crank", place=(0.6, 0.1)).check(scene)


def test_what_is_always_zero_is_refused():
    with pytest.raises(ValueError, match="the ground does not move, so that it has no velocity; name a body that moves"):
        Velocity(body="ground", point="A")
    with pytest.raises(ValueError, match="point 'A' of 'rod' has no angle against itself; name two bodies, or two points of one"):
        RelativeAngle(bodies=("rod", "rod"), point="A")
    with pytest.raises(ValueError, match="point 'A' of 'rod' has no distance from itself"):
        PointDistance(bodies=("rod", "rod"), points=("A", "A"))
    assert PointDistance(bodies=("rod", "rod"), points=("A", "O")).kind == "distance"
