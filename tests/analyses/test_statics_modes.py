"""Static equilibria, their design derivatives and limits, and modes, against closed forms of one and two degrees of freedom."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from preprocessing.elements.section import Section
from preprocessing.reduction.basis import BasisChoice
from tests.models.beam_models import save_beam
from tests.models.directions import combined
from toolkit.analyses.modes import solve_modes, undeformed
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.api.model import compile_model
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.distance import Distance
from toolkit.components.joints.driver import AngleDriver
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.point_force import PointForce
from toolkit.components.loads.springs import RotationalSpringDamper, SpringDamper
from toolkit.components.loads.torque import Torque
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ConvergenceError, SingularSystemError
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene
from toolkit.validity.energy_balance import energy_balance

MODELS = Path(__file__).parents[2] / "models"
NEWTON = 1e-9
"""Newton stops at corrections of 1e-10 of the model size and converges quadratically, so states are at least this exact."""


def at(**places: tuple[float, float]) -> dict[str, Point]:
    return {name: Point(x=x, y=y) for name, (x, y) in places.items()}


def scene(points: dict, bodies: dict, joints: dict, loads: dict) -> Scene:
    return Scene(units="m-kg-s", points=at(**points), bodies=bodies, joints=joints, loads=loads)


ARM = {"O": (0.0, 0.0), "A": (1.0, 0.0)}


def arm(**loads) -> Scene:
    """A horizontal rod of 3 kg and 1 m on a hinge with a rotational spring of 20 N m."""
    spring = RotationalSpringDamper(bodies=("rod", "ground"), point="O", stiffness=20.0)
    bodies = {"rod": Rod(between=("O", "A"), area=1.0, density=3.0)}
    joints = {"O": Revolute(bodies=("rod", "ground"), point="O")}
    return scene(ARM, bodies, joints, {"spring": spring, **loads})


def test_a_sprung_pendulum_hangs_where_moments_balance():
    found = solve_statics(compile_scene(arm(gravity=Gravity(acceleration=(0.0, -9.81))))).q[0, 2]
    exact = brentq(lambda angle: 20.0 * angle + 3.0 * 9.81 * 0.5 * np.cos(angle), -1.5, 0)
    assert found == pytest.approx(exact, rel=NEWTON)


def test_a_following_force_turns_the_arm_in_proportion():
    """The moment of a force that stays perpendicular is F L at every angle; one fixed in space has F L cos(angle)."""
    force = {"body": "rod", "point": "A", "force": (0.0, 30.0)}
    following = solve_statics(compile_scene(arm(tip=PointForce(**force, frame="body")))).q[0, 2]
    fixed = solve_statics(compile_scene(arm(tip=PointForce(**force)))).q[0, 2]
    assert following == pytest.approx(30.0 / 20.0, rel=NEWTON)
    assert fixed == pytest.approx(brentq(lambda angle: 20.0 * angle - 30.0 * np.cos(angle), 0, 1.5), rel=NEWTON)


HANGING = {"O": (0.0, 0.0), "A": (0.0, -1.0)}


def hanging_rod(points: dict = HANGING, **joints) -> Scene:
    """A rod of 3 kg on a hinge, held by nothing but its weight."""
    bodies = {"rod": Rod(between=("O", "A"), area=1.0, density=3.0)}
    joints = {"O": Revolute(bodies=("rod", "ground"), point="O"), **joints}
    return scene(points, bodies, joints, {"gravity": Gravity(acceleration=(0.0, -9.81))})


@pytest.mark.parametrize("tilt", [0.0, 0.1, 1.0, 1.3, 1.5, np.pi / 2, -1.7, 2.5, 3.0])
def test_a_pendulum_that_only_its_weight_holds_hangs_straight_and_swings_like_a_pendulum(tilt):
    """Without load nothing determines it; frequency of a rod about its end: omega^2 = 3 g / (2 L)."""
    points = {"O": (0.0, 0.0), "A": (np.sin(tilt), -np.cos(tilt))}
    run = solve_statics(compile_scene(hanging_rod(points)))
    assert run.q[0, 2] == pytest.approx(-tilt, abs=1e-9)  # the short way to the vertical, to Newton's tolerance
    assert solve_modes(run).frequencies == pytest.approx([np.sqrt(1.5 * 9.81) / (2 * np.pi)], rel=NEWTON)


def test_a_double_pendulum_finds_the_valley_that_it_starts_above():
    """A spring between the rods, whose twist tells one valley from another; a damped motion from the same start ends in it."""
    angles = (-1.8525, 0.5420)
    ends = np.cumsum([[0.0, 0.0], *([np.sin(a), -np.cos(a)] for a in angles)], axis=0)
    points = dict(zip("OAB", map(tuple, ends), strict=True))
    bodies = {"upper": Rod(between=("O", "A"), area=1.0, density=2.0), "lower": Rod(between=("A", "B"), area=1.0, density=3.0)}
    joints = {"O": Revolute(bodies=("upper", "ground"), point="O"), "A": Revolute(bodies=("upper", "lower"), point="A")}
    spring = RotationalSpringDamper(bodies=("upper", "lower"), point="A", stiffness=0.5721)
    brakes = {
        "spring": RotationalSpringDamper(bodies=("upper", "lower"), point="A", stiffness=0.5721, damping=20.0),
        "brake": RotationalSpringDamper(bodies=("upper", "ground"), point="O", damping=20.0),
    }
    gravity = {"gravity": Gravity(acceleration=(0.0, -9.81))}
    run = solve_statics(compile_scene(scene(points, bodies, joints, {**gravity, "spring": spring})))
    settled = simulate(compile_scene(scene(points, bodies, joints, {**gravity, **brakes})), RunOptions(end_time=60.0, step=0.05))
    np.testing.assert_allclose(run.q[0], settled.q[-1], atol=1e-5)  # what the motion has left after 60 s


def test_a_repeated_joint_of_a_pendulum_is_named():
    again = Revolute(bodies=("rod", "ground"), point="O")
    with pytest.raises(SingularSystemError, match=r"constraints .*joint 'again'.* repeat or contradict each other"):
        solve_statics(compile_scene(hanging_rod(again=again)))


def test_the_upright_pendulum_is_refused():
    with pytest.raises(ConvergenceError, match="equilibrium is unstable"):
        solve_statics(compile_scene(hanging_rod({"O": (0.0, 0.0), "A": (0.0, 1.0)})))


def test_modes_of_a_free_body_are_found_about_the_given_positions():
    """Three rigid motions without frequency, and nothing else; statics has nothing to hold it."""
    bodies = {"block": Rigid(mass=2.0, inertia=0.3, center="P")}
    spring = SpringDamper(bodies=("block", "ground"), points=("Q", "R"), stiffness=8.0)
    sprung = scene({"P": (0.0, 0.0), "Q": (1.0, 0.0), "R": (2.0, 0.0)}, bodies, {}, {"spring": spring})
    with pytest.raises(SingularSystemError):
        solve_statics(compile_scene(sprung))
    frequencies = solve_modes(undeformed(compile_scene(sprung))).frequencies
    # along the spring omega^2 = k / m; across it and in rotation nothing restores at relaxed length
    assert frequencies == pytest.approx([0.0, 0.0, 2.0 / (2 * np.pi)], abs=1e-9)


@pytest.mark.parametrize("weight", [{}, {"weight": Gravity(acceleration=(2.0, -9.81))}], ids=["no load", "weight"])
@pytest.mark.parametrize(
    "basis", [BasisChoice("full"), BasisChoice("eigenmodes", count=4, boundary="free")], ids=["clamped frame", "mean axes"]
)
def test_a_body_that_nothing_holds_has_the_frequencies_of_a_free_beam(tmp_path, basis, weight):
    """Rigid motions take no time, falling or not and whatever the frame is tied to; then come the roots of cos x cosh x = 1."""
    nodes = np.column_stack([np.linspace(0, 1, 13), np.zeros(13)])
    save_beam(tmp_path / "beam.h5", nodes, Section(2e11, 7800.0, 0.01, 0.05), {"root": 0.0}, basis=basis)
    bodies = {"beam": Flexible(model="beam.h5", angle=0.3)}
    free = Scene(units="m-kg-s", bodies=bodies, loads=weight, directory=tmp_path)
    found = compile_model(free).modes(count=5)
    exact = np.array([4.7300408, 7.8532046]) ** 2 / (2 * np.pi) * 0.01 * np.sqrt(2e11 / 7800.0 / 12)
    assert found.frequencies[:3] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)
    assert found.frequencies[3:] == pytest.approx(exact, rel=2e-3)
    assert "free-modes" in [each.code for each in found.verdict.warnings]
    assert compile_model(free).modes(count=5, undeformed=True).frequencies == pytest.approx(found.frequencies, abs=1e-6)


def test_a_body_on_a_frame_that_is_grounded_is_held(tmp_path):
    nodes = np.column_stack([np.linspace(0, 1, 9), np.zeros(9)])
    save_beam(tmp_path / "beam.h5", nodes, Section(2e11, 7800.0, 0.01, 0.05), {"root": 0.0})
    held = Scene(units="m-kg-s", bodies={"beam": Flexible(model="beam.h5", frame="grounded")}, directory=tmp_path)
    found = compile_model(held).modes(count=1)
    assert found.frequencies == pytest.approx(1.8751041**2 / (2 * np.pi) * 0.01 * np.sqrt(2e11 / 7800.0 / 12), rel=1e-3)
    assert "free-modes" not in [each.code for each in found.verdict.warnings]


def test_joints_that_cannot_be_closed_are_named_not_called_a_limit_point():
    out_of_reach = Distance(bodies=("rod", "ground"), points=("A", "B"), length=5.0)
    points = {**HANGING, "B": (2.0, 0.0)}
    with pytest.raises(ConvergenceError, match=r"joints cannot be closed: .*distance of joint 'stay' is open by 2 m"):
        solve_statics(compile_scene(hanging_rod(points, stay=out_of_reach)))


def test_open_joints_are_closed_before_the_load_grows():
    """The stay of 1.7 m is 0.54 m too short; closed, the rod leans towards it by the law of cosines."""
    stay = Distance(bodies=("rod", "ground"), points=("A", "B"), length=1.7)
    run = solve_statics(compile_scene(hanging_rod({**HANGING, "B": (2.0, 0.0)}, stay=stay)))
    between = np.arccos((1 + 4 - 1.7**2) / 4)  # angle at O between rod and OB
    assert run.q[0, 2] == pytest.approx(np.pi / 2 - between, abs=1e-9)


def test_the_load_steps_of_a_static_solution_are_counted():
    run = solve_statics(compile_scene(arm(gravity=Gravity(acceleration=(0.0, -9.81)))), RunOptions(load_steps=7))
    assert (
        run.load_steps == len(run.path.load_factors) - 1 == 8
    )  # the arm stiffens, so that each is a little shorter than a seventh
    assert np.diff(run.path.load_factors).max() <= 1.05 / 7  # by length of a path that bends
    assert run.steps == 0


CRANK, ROD, STIFFNESS, TORQUE = 0.5, 1.2, 40.0, 6.0
START = 0.6
MECHANISM = {
    "O": (0.0, 0.0),
    "T": (CRANK * np.cos(START), CRANK * np.sin(START)),
    "X": (CRANK * np.cos(START) + np.sqrt(ROD**2 - (CRANK * np.sin(START)) ** 2), 0.0),
    "W": (3.0, 0.4),
}
MECHANISM_DESIGN = ["points.T.x", "points.T.y", "loads.spring.stiffness", "loads.motor.torque", "points.W.x", "joints.X.axis.y"]


def mechanism() -> Scene:
    """A slider-crank against a spring between its slider and a wall."""
    bodies = {"crank": Rod(between=("O", "T"), area=1.0, density=1.0), "rod": Rod(between=("T", "X"), area=1.0, density=1.0)}
    joints = {
        "O": Revolute(bodies=("crank", "ground"), point="O"),
        "T": Revolute(bodies=("crank", "rod"), point="T"),
        "X": Slider(bodies=("rod", "ground"), point="X", axis=(1.0, 0.0)),
    }
    loads = {
        "spring": SpringDamper(bodies=("rod", "ground"), points=("X", "W"), stiffness=STIFFNESS),
        "motor": Torque(body="crank", point="O", torque=TORQUE),
    }
    return scene(MECHANISM, bodies, joints, loads)


def test_a_spring_loaded_slider_crank_rests_where_virtual_work_vanishes():
    def slider(angle: float) -> float:
        return CRANK * np.cos(angle) + np.sqrt(ROD**2 - (CRANK * np.sin(angle)) ** 2)

    def work(angle: float) -> float:
        sine, cosine = CRANK * np.sin(angle), CRANK * np.cos(angle)
        rate = -sine - sine * cosine / np.sqrt(ROD**2 - sine**2)
        length, rest = (np.hypot(3.0 - slider(each), 0.4) for each in (angle, START))
        return TORQUE + STIFFNESS * (length - rest) * (3.0 - slider(angle)) / length * rate

    found = solve_statics(compile_scene(mechanism())).q[0, 2]
    assert found == pytest.approx(brentq(work, START, 1.5) - START, rel=NEWTON)


@pytest.mark.parametrize("name", ["q", "multipliers"])
def test_static_sensitivities_are_the_complex_step_of_the_whole_analysis(name):
    """Along a direction in which every number moves them alike, so that what is wrong by one of them shows beside the others."""
    given = mechanism()
    run = solve_statics(compile_scene(given, MECHANISM_DESIGN))
    ours = getattr(run, f"d{name}")[0]
    factors = dict(zip(MECHANISM_DESIGN, (1 / np.abs(ours).max(axis=0)).tolist(), strict=True))
    stepped = solve_statics(compile_scene(given.moved(combined(given, factors), 1e-30j)))
    exact = getattr(stepped, name)[0].imag / 1e-30
    np.testing.assert_allclose(ours @ np.array(list(factors.values())), exact, rtol=0, atol=1e-9 * np.abs(exact).max())


@pytest.mark.parametrize("path", MECHANISM_DESIGN)
def test_static_sensitivities_pass_the_taylor_test(path):
    given = mechanism()
    options = RunOptions(tolerance=1e-13)
    run = solve_statics(compile_scene(given, [path]), options)
    steps, value = np.array([4e-3, 2e-3, 1e-3]), given.number(path)
    scale = abs(value) or 1.0
    remainder = []
    for h in steps * scale:
        moved = solve_statics(compile_scene(given.with_number(path, value + h)), options).q[0]
        remainder.append(np.abs(moved - run.q[0] - h * run.dq[0, :, 0]).max())
    assert np.polyfit(np.log(steps), np.log(remainder), 1)[0] == pytest.approx(2.0, abs=0.05)  # the cubic term at 0.4 %


def test_a_static_driver_ends_at_the_last_value_of_its_curve():
    drive = AngleDriver(bodies=("rod", "ground"), point="O", curve=SmoothStep(height=2.5))
    given = arm(gravity=Gravity(acceleration=(0.0, -9.81)))
    run = solve_statics(compile_scene(given.model_copy(update={"joints": {**given.joints, "drive": drive}})))
    assert run.q[0, 2] == pytest.approx(2.5, rel=NEWTON)
    # the driver's moment on the rod, -lambda, carries spring and weight
    assert -run.multipliers[0, -1] == pytest.approx(20.0 * 2.5 + 3.0 * 9.81 * 0.5 * np.cos(2.5), rel=NEWTON)


HALF_SPAN, HEIGHT, BAR = 1.0, 0.3, 1000.0
REST = np.hypot(HALF_SPAN, HEIGHT)
AT_LIMIT = np.cbrt(REST * HALF_SPAN**2)
LIMIT = 2 * BAR * (REST - AT_LIMIT) / AT_LIMIT * np.sqrt(AT_LIMIT**2 - HALF_SPAN**2)
"""Shallow truss of two sprung bars: F = 2 k (l_0 / l - 1) y is largest where l^3 = l_0 b^2."""


def truss(force: float) -> Scene:
    points = {"P": (0.0, HEIGHT), "L": (-HALF_SPAN, 0.0), "R": (HALF_SPAN, 0.0)}
    bars = {side: SpringDamper(bodies=("apex", "ground"), points=("P", side), stiffness=BAR) for side in ("L", "R")}
    push = PointForce(body="apex", point="P", force=(0.0, -force))
    guide = Slider(bodies=("apex", "ground"), point="P", axis=(0.0, 1.0), lock_rotation=True)
    return scene(points, {"apex": Rigid(mass=1.0, inertia=1.0, center="P")}, {"guide": guide}, {**bars, "push": push})


@pytest.mark.parametrize("part", [0.5, 0.99, 0.9999])
def test_a_shallow_truss_is_followed_up_to_its_limit_load(part):
    found = solve_statics(compile_scene(truss(part * LIMIT))).q[0, 1]
    low = np.sqrt(AT_LIMIT**2 - HALF_SPAN**2)
    exact = brentq(lambda y: 2 * BAR * (REST / np.hypot(HALF_SPAN, y) - 1) * y - part * LIMIT, low, HEIGHT, xtol=1e-14)
    # the last correction leaves (1e-10)^2 / distance to the limit point, which is sqrt(1 - part)
    assert found == pytest.approx(exact, rel=1e-7)


@pytest.mark.parametrize("part", [1.001, 1.2, 3.0])
def test_beyond_the_limit_load_statics_refuse_and_say_where_the_path_ends(part):
    with pytest.raises(ConvergenceError, match=r"static path ends at .* % of the load .*limit point.*transient run") as error:
        solve_statics(compile_scene(truss(part * LIMIT)))
    percent = float(str(error.value).split("ends at ")[1].split(" %")[0])
    assert percent == pytest.approx(100 / part, abs=1e-4)  # six digits are printed


def test_modes_of_a_bead_between_two_tight_springs_feel_the_tension():
    """omega^2 = 2 (T / l) / m across a string under the tension T."""
    points = {"P": (0.0, 0.0), "L": (-1.0, 0.0), "R": (1.0, 0.0)}
    springs = {p: SpringDamper(bodies=("bead", "ground"), points=("P", p), stiffness=50.0, length=0.4) for p in ("L", "R")}
    guide = Slider(bodies=("bead", "ground"), point="P", axis=(0.0, 1.0), lock_rotation=True)
    given = scene(points, {"bead": Rigid(mass=0.7, inertia=1.0, center="P")}, {"guide": guide}, springs)
    found = solve_modes(solve_statics(compile_scene(given))).frequencies
    assert found == pytest.approx([np.sqrt(2 * 50.0 * 0.6 / 0.7) / (2 * np.pi)], rel=NEWTON)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_modes_of_a_double_pendulum_hanging_and_standing(side):
    """omega^2 = (2 +- sqrt 2) g / L; negative, so unstable, if it stands."""
    points = {"O": (0.0, 0.0), "P": (0.0, side), "Q": (0.0, 2 * side)}
    bodies = {name: Rigid(mass=1.3, inertia=1.0, center=name) for name in ("P", "Q")}
    joints = {
        "upper": Distance(bodies=("P", "ground"), points=("P", "O")),
        "lower": Distance(bodies=("Q", "P"), points=("Q", "P")),
        **{f"turn{name}": AngleDriver(bodies=(name, "ground"), point=name, curve=SmoothStep(height=0.0)) for name in bodies},
    }
    given = scene(points, bodies, joints, {"gravity": Gravity(acceleration=(0.0, -9.81))})
    at_rest = simulate(compile_scene(given), RunOptions(end_time=1e-3, step=1e-3))
    exact = -side * np.sqrt((2 + np.array([-1, 1]) * np.sqrt(2)) * 9.81) / (2 * np.pi)
    np.testing.assert_allclose(solve_modes(at_rest).frequencies, np.sort(exact), rtol=NEWTON)


def ziegler(force: float) -> Scene:
    """Two links of 1 m with springs of 1 N m, masses of 2 and 1 kg at their ends, under a force that follows the upper link."""
    points = {"O": (0.0, 0.0), "P": (0.0, 1.0), "Q": (0.0, 2.0)}
    small = 1e-12  # moment of inertia about the end, against 1 kg m^2
    bodies = {"lower": Rigid(mass=2.0, inertia=small, center="P"), "upper": Rigid(mass=1.0, inertia=small, center="Q")}
    joints = {
        "O": Revolute(bodies=("lower", "ground"), point="O"),
        "P": Revolute(bodies=("upper", "lower"), point="P"),
    }
    loads = {
        "k1": RotationalSpringDamper(bodies=("lower", "ground"), point="O", stiffness=1.0),
        "k2": RotationalSpringDamper(bodies=("upper", "lower"), point="P", stiffness=1.0),
        "push": PointForce(body="upper", point="Q", force=(0.0, -force), frame="body"),
    }
    return scene(points, bodies, joints, loads)


def test_modes_under_a_following_force_are_those_of_zieglers_column():
    """det(K - omega^2 M) = 0, M = [[3, 1], [1, 1]], K = [[2 - P, P - 1], [-1, 1]] in the links' angles."""
    force = 1.5
    squares = np.linalg.eigvals(np.linalg.solve([[3, 1], [1, 1]], [[2 - force, force - 1], [-1, 1]]))
    found = solve_modes(solve_statics(compile_scene(ziegler(force)))).frequencies
    np.testing.assert_allclose(found, np.sort(np.sqrt(squares)) / (2 * np.pi), rtol=1e-8)  # unsymmetric: sensitive to round-off


@pytest.mark.parametrize("part", [0.99, 1.001, 1.5])
def test_modes_that_flutter_are_told_with_their_growth_and_no_others(part):
    """Roots of the same determinant; Ziegler's column flutters beyond P = 3.5 - sqrt(2), and is stable below."""
    force = part * (3.5 - np.sqrt(2))
    squares = np.linalg.eigvals(np.linalg.solve([[3, 1], [1, 1]], [[2 - force, force - 1], [-1, 1]]))
    found = solve_modes(solve_statics(compile_scene(ziegler(force))))
    if part < 1:
        np.testing.assert_allclose(found.frequencies, np.sort(np.sqrt(squares.real)) / (2 * np.pi), rtol=1e-7)
        assert found.damping is None
        assert found.verdict.trusted
        return
    s = np.sqrt(-squares[0])
    np.testing.assert_allclose(found.frequencies, 2 * [abs(s.imag) / (2 * np.pi)], rtol=1e-7)
    np.testing.assert_allclose(found.damping, abs(s.real) / abs(s) * np.array([-1, 1]), rtol=1e-6)
    assert f"grows like exp({abs(s.real):.4g} t)" in found.verdict.reasons[0]


def test_stiff_springs_beside_a_fluttering_column_do_not_hide_that_it_flutters():
    """A mass on a spring whose square of frequency is 1e14 times theirs."""
    given = ziegler(2.5)
    stiff = {"bead": Rigid(mass=1e-3, inertia=1e-3, center="P")}
    guide = {"guide": Slider(bodies=("bead", "ground"), point="P", axis=(1.0, 0.0), lock_rotation=True)}
    spring = {"hard": SpringDamper(bodies=("bead", "ground"), points=("P", "L"), stiffness=1e11)}
    both = given.model_copy(
        update={
            "points": {**given.points, **at(L=(-1.0, 1.0))},
            "bodies": {**given.bodies, **stiff},
            "joints": {**given.joints, **guide},
            "loads": {**given.loads, **spring},
        }
    )
    alone, found = (solve_modes(solve_statics(compile_scene(each))) for each in (given, both))
    np.testing.assert_allclose(found.frequencies[:2], alone.frequencies, rtol=1e-6)
    np.testing.assert_allclose(found.damping[:2], alone.damping, rtol=1e-6)


# --- the hard neighbour of the reference scene ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def hard_neighbour() -> Scene:
    """The wing with a linkage that snaps through at 92 % of the torque."""
    return read_scene(MODELS / "snap_through" / "scene.toml")


def test_the_hard_neighbour_has_no_static_state_beyond_92_percent_of_the_torque(hard_neighbour):
    with pytest.raises(ConvergenceError, match=r"static path ends at 9[12]\.\d* % of the load .*limit point"):
        solve_statics(compile_scene(hard_neighbour))
    below = hard_neighbour.with_number("loads.drive.torque", 0.915 * 4200.0)
    run = solve_statics(compile_scene(below))
    assert solve_modes(run, 1).frequencies[0] > 0  # still stable


def transient(given: Scene, **options) -> tuple[np.ndarray, np.ndarray, float]:
    """Times, angle of body 2, and the defect of the energy balance over the largest energy or work."""
    run = simulate(compile_scene(given), given.solver.model_copy(update=options))
    return run.times, run.q[:, run.coordinates("body2")][:, 2], energy_balance(run).relative_defect


@pytest.mark.parametrize("step", [0.05, 0.02, 0.01])
@pytest.mark.parametrize("scheme", ["paper", "arnold-bruels"])
def test_a_coarse_transient_run_of_the_snap_through_is_refused(hard_neighbour, scheme, step):
    """Where steps are not to be halved, which may lead through it."""
    with pytest.raises(ConvergenceError, match=r"Newton stopped at t = (0\.[78]|1\.).*Try a smaller solver.step"):
        transient(hard_neighbour, scheme=scheme, step=step, halvings=0)


def test_a_fine_transient_run_resolves_the_way_into_the_snap_through_and_through_it(hard_neighbour):
    """Three steps agree before and in the snap, which the static limit announces. The undamped ringing after it does not converge
    point by point (neighbouring paths part), so only its energy is held to account."""
    angles, defects = [], []
    for step in (1e-3, 5e-4, 2.5e-4):
        times, angle, defect = transient(hard_neighbour, scheme="arnold-bruels", step=step)
        angles.append(np.interp([0.5, 0.6, 0.7, 0.75, 0.8], times, angle))
        defects.append(defect)
        snapped = times[np.argmax(angle > 0.45)]
        assert 0.75 < snapped < 0.85  # 92 % of the torque is reached at 0.76 s
    np.testing.assert_allclose(angles[0][:4], angles[2][:4], rtol=1e-5)  # slow motion: (1e-3 / 0.2)^2 / 5
    np.testing.assert_allclose(
        angles[0][4], angles[2][4], rtol=5e-3
    )  # in the snap, time scale 0.01: (1e-3 / 0.01)^2 / 5 and more
    assert max(defects) < 0.03  # numerical damping of the ringing, with rho_inf = 0.5


@pytest.mark.parametrize("step", [1e-3, 2.5e-4])
def test_the_energy_balance_tells_that_the_papers_scheme_creates_energy_in_the_snap(hard_neighbour, step):
    """Newton converges and the joints hold, so nothing else would tell."""
    assert transient(hard_neighbour, scheme="paper", step=step)[2] > 0.03


def test_the_papers_scheme_is_refused_at_a_coarser_step(hard_neighbour):
    """Its joints open by 2.5e-3 of the model size."""
    with pytest.raises(ConvergenceError, match="joints came apart"):
        transient(hard_neighbour, scheme="paper", step=2e-3)


def column(force: float) -> Scene:
    """An upright rigid link of 1 m with a spring of 20 N m at its foot, under a force down: it buckles at 20 N."""
    spring = RotationalSpringDamper(bodies=("rod", "ground"), point="O", stiffness=20.0)
    push = PointForce(body="rod", point="A", force=(0.0, -force))
    bodies = {"rod": Rod(between=("O", "A"), area=1.0, density=3.0)}
    joints = {"O": Revolute(bodies=("rod", "ground"), point="O")}
    return scene({"O": (0.0, 0.0), "A": (0.0, 1.0)}, bodies, joints, {"spring": spring, "push": push})


def test_a_column_below_its_buckling_load_stands():
    run = solve_statics(compile_scene(column(19.0)))
    inertia = 3.0 / 3
    assert solve_modes(run).frequencies == pytest.approx([np.sqrt((20.0 - 19.0) / inertia) / (2 * np.pi)], rel=1e-8)


@pytest.mark.parametrize("force", [21.0, 40.0])
def test_a_buckled_column_is_not_reported_as_standing(force):
    """Behind the bifurcation the straight state is an equilibrium, but an unstable one, which statics promise to refuse."""
    with pytest.raises(ConvergenceError, match="unstable"):
        solve_statics(compile_scene(column(force)))


LINKAGE = """units = "m-kg-s"
dimension = 3
points = { O = [0.0, 0.0, 0.0], A = [0.0, 0.2, 0.0], B = [1.0, 0.5, 0.3], C = [1.0, 0.0, 0.3] }
bodies.crank = { type = "rigid", mass = 1.0, inertia = [0.01, 0.01, 0.01], center = "A" }
bodies.coupler = { type = "rod", between = ["A", "B"], area = 1e-4, density = 7800.0 }
bodies.rocker = { type = "rigid", mass = 1.0, inertia = [0.01, 0.01, 0.01], center = "B" }
joints.crank = { type = "revolute", bodies = ["crank", "ground"], point = "O", axis = [0.0, 0.0, 1.0] }
joints.A = { type = "spherical", bodies = ["crank", "coupler"], point = "A" }
joints.B = { BALL, bodies = ["coupler", "rocker"], point = "B" }
joints.rocker = { type = "revolute", bodies = ["rocker", "ground"], point = "C", axis = [0.0, 0.0, 1.0] }
loads.spring = { type = "rotational-spring-damper", bodies = ["crank", "ground"], point = "O", axis = [0.0, 0.0, 1.0], stiffness = 50.0 }
loads.push = { type = "point-force", body = "rocker", point = "B", force = [5.0, 0.0, 0.0] }
responses.x = { type = "displacement", body = "rocker", point = "B", component = "x" }
"""
"""Weight along the axes of both cranks would do no work."""


def pushed_linkage() -> float:
    """x of B: of crank, coupler and rocker the least of spring's energy less the work of 5 N."""
    length = np.sqrt(1.0 + 0.3**2 + 0.3**2)

    def tip(angle: float) -> float:
        a = np.array([-0.2 * np.sin(angle), 0.2 * np.cos(angle), 0.0])

        def apart(turn: float) -> float:
            b = np.array([1.0 - 0.5 * np.sin(turn), 0.5 * np.cos(turn), 0.3])
            return float(np.linalg.norm(b - a)) - length

        return -0.5 * np.sin(brentq(apart, -0.3, 0.3, xtol=1e-15))

    def slope(angle: float, h: float = 1e-5) -> float:
        return 50.0 * angle - 5.0 * (tip(angle + h) - tip(angle - h)) / (2 * h)

    return tip(brentq(slope, -0.2, 0.2, xtol=1e-14))


def test_a_coupler_that_turns_idly_is_named_and_the_joint_that_helps_gives_the_equilibrium(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(LINKAGE.replace("BALL", 'type = "spherical"'))
    with pytest.raises(SingularSystemError, match=r"'coupler' turns idly about the line through 'A' and 'B'") as error:
        compile_model(read_scene(path)).statics()
    written = str(error.value).split("joints.B with ")[1].split(", which holds")[0].replace(" and ", ", ")
    path.write_text(LINKAGE.replace("BALL", written))
    assert compile_model(read_scene(path)).statics().values["x"] == pytest.approx(pushed_linkage(), rel=1e-6)
