"""What users get wrong, and what the toolkit says: what, where, what would be right, what to do next."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from pydantic import ValidationError

from toolkit.analyses.sensitivity.preparation import prepare
from toolkit.analyses.statics import farthest, free_motion_states, solve_statics
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.curves.combined import Sum
from toolkit.components.curves.oscillation import Sine
from toolkit.components.curves.polynomial import Constant
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.curves.table import Table
from toolkit.components.joints.distance import Distance
from toolkit.components.joints.driver import AngleDriver, PositionDriver
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.rigid_joint import RigidJoint
from toolkit.components.loads.bushing import Bushing
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.point_force import PointForce
from toolkit.components.loads.springs import RotationalSpringDamper, SpringDamper
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ConvergenceError, InputError, ModelFileError, SingularSystemError
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene
from toolkit.validity.scene_cautions import cautions_of_scene

WING = Path(__file__).parents[2] / "models" / "morphing_wing"
TEXT = """
units = "m-kg-s"

[points]
O = [0.0, 0.0]
A = [1.0, 0.0]

[bodies]
rod = { type = "rod", between = ["O", "A"], area = 1.0, density = 1.0 }

[joints]
hinge = { type = "revolute", bodies = ["rod", "ground"], point = "O" }

[loads]
drive = { type = "torque", body = "rod", point = "A", torque = 2.0, curve = { type = "smooth-step", duration = 1.0 } }

[design]
M = "loads.drive.torque"

[solver]
end_time = 1.0
step = 0.01
"""


@pytest.fixture
def file(tmp_path):
    """Write the scene with one piece of text replaced, and return its path."""

    def write(old: str = "", new: str = "") -> Path:
        assert old in TEXT
        path = tmp_path / "pendulum.toml"
        path.write_text(TEXT.replace(old, new, 1) if old else TEXT)
        return path

    return write


def pendulum(**changes: Any) -> Scene:
    """A rod on a hinge, swinging under gravity; `changes` add joints, loads or points."""
    points = {"O": Point(x=0.0, y=0.0), "A": Point(x=1.0, y=0.0), "C": Point(x=0.5, y=0.0), **changes.get("points", {})}
    bodies = {"rod": Rod(between=("O", "A"), area=1.0, density=1.0), **changes.get("bodies", {})}
    joints = {"hinge": Revolute(bodies=("rod", "ground"), point="O"), **changes.get("joints", {})}
    loads = {"gravity": Gravity(acceleration=(0.0, -9.81)), **changes.get("loads", {})}
    return Scene(units="m-kg-s", points=points, bodies=bodies, joints=joints, loads=loads)


# --- scene files ----------------------------------------------------------------------------------------------------------------

MISTAKES = {
    "unknown type": ('type = "revolute"', 'type = "hinge"', r"joints\.hinge\.type = 'hinge' is unknown; available: .*revolute"),
    "missing type": ('type = "revolute", ', "", r"joints\.hinge needs a `type`, one of: .*revolute"),
    "misspelt key": (
        "torque = 2.0",
        "torqe = 2.0",
        r"loads\.drive\.torqe: unknown key, did you mean 'torque'; possible here: body, point",
    ),
    "missing key": (", density = 1.0", "", r"bodies\.rod\.density: this key is missing; needed or possible here: .*density"),
    "unknown group": ("[loads]", "[forces]", r"forces: unknown key.*possible here: .*loads"),
    "text for a number": ("torque = 2.0", 'torque = "much"', r"loads\.drive\.torque: .*number.*given: 'much'"),
    "negative area": ("area = 1.0", "area = -1.0", r"bodies\.rod\.area: .*greater than 0.*given: -1\.0"),
    "not finite": ("density = 1.0", "density = nan", r"bodies\.rod\.density: .*finite|bodies\.rod\.density: .*greater"),
    "three coordinates": ("A = [1.0, 0.0]", "A = [1.0, 0.0, 2.0]", r"points\.A has 3 coordinates; a planar point has two"),
    "point that is no point": ("A = [1.0, 0.0]", "A = 3.0", r"points\.A.*3\.0"),
    "point that is a table": (
        "A = [1.0, 0.0]",
        "A = { x = 1.0, y = 0.0 }",
        r"points\.A.*is no point; a planar point has two, \[x, y\]",
    ),
    "unknown units": ('units = "m-kg-s"', 'units = "inch"', r"units: .*'mm-t-s' or 'm-kg-s'.*'inch'"),
    "missing units": ('units = "m-kg-s"', "", r"units: this key is missing"),
    "torque on a missing body": (
        'body = "rod"',
        'body = "rood"',
        r"loads\.drive names body 'rood', which does not exist, did you mean 'rod'; bodies of the scene: rod, ground",
    ),
    "missing point": (
        'point = "O"',
        'point = "Q"',
        r"joints\.hinge names point 'Q', which does not exist; points of the scene: O, A",
    ),
    "rod between missing points": ('["O", "A"]', '["O", "Z"]', r"'Z'.*points of the scene: O, A"),
    "joint to itself": (
        '["rod", "ground"]',
        '["rod", "rod"]',
        r"joints\.hinge: .*a joint ties two different bodies, not 'rod' to itself",
    ),
    "text that looks like a number": ("torque = 2.0", 'torque = "2.0"', r"loads\.drive\.torque: .*number.*given: '2\.0'"),
    "truth for a number": ("torque = 2.0", "torque = true", r"loads\.drive\.torque: .*number.*given: True"),
    "misspelt key of a curve": (
        "duration = 1.0",
        "duraton = 1.0",
        r"loads\.drive\.curve\.duraton: unknown key, did you mean 'duration'; possible here: height, start, duration",
    ),
    "missing key of a curve": (
        'type = "smooth-step", duration = 1.0',
        'type = "sine"',
        r"loads\.drive\.curve\.frequency: this key is missing; needed or possible here: amplitude, frequency, phase",
    ),
    "curve without type": (
        'type = "smooth-step", ',
        "",
        r"loads\.drive\.curve: a time curve is a table with a `type`, one of: .*smooth-step",
    ),
    "misspelt key of the stabilisation": (
        "step = 0.01",
        "step = 0.01\nbaumgarte = { dampin = 1.0 }",
        r"solver\.baumgarte\.dampin: unknown key, did you mean 'damping'; possible here: damping, stiffness",
    ),
    "one body of a joint": ('["rod", "ground"]', '["rod"]', r"joints\.hinge\.bodies\.1: this entry is missing"),
    "body called ground": ("rod = {", "ground = {", r"a body cannot be called 'ground'"),
    "name with a dot": ("A = [1.0, 0.0]", 'A = [1.0, 0.0]\n"a.b" = [0.0, 1.0]', r"points\.'a\.b' is no legal name"),
    "torque against itself": ('body = "rod"', 'body = "ground"', r"loads\.drive: a torque on 'ground' .* has no effect"),
    "response of a missing body": (
        "[design]",
        '[responses]\nturn = { type = "rotation", body = "rood", point = "O" }\n[design]',
        r"responses\.turn names body 'rood', which does not exist, did you mean 'rod'; bodies of the scene: rod, ground",
    ),
    "response at a missing point": (
        "[design]",
        '[responses]\nturn = { type = "rotation", body = "rod", point = "Z" }\n[design]',
        r"responses\.turn names point 'Z', which does not exist; points of the scene: O, A",
    ),
    "integral over a missing joint": (
        "[design]",
        '[responses]\nf = { type = "time-integral", of = { type = "joint-force", joint = "J", component = "x" } }\n[design]',
        r"responses\.f names joint 'J', which does not exist; joints of the scene: hinge",
    ),
    "missing key of an integrand": (
        "[design]",
        '[responses]\nturn = { type = "time-integral", of = { type = "rotation", body = "rod" } }\n[design]',
        r"responses\.turn\.of\.point: this key is missing; needed or possible here: time, body, point",
    ),
    "unknown curve": (
        'type = "smooth-step"',
        'type = "rampp"',
        r"loads\.drive\.curve: type = 'rampp' is no kind of time curve, did you mean 'ramp'; available: .*smooth-step",
    ),
    "misspelt solver key": ("end_time", "endtime", r"solver\.endtime: unknown key, did you mean 'end_time'"),
    "unknown scheme": (
        "step = 0.01",
        'step = 0.01\nscheme = "newmark"',
        r"solver\.scheme: .*'arnold-bruels' or 'paper'.*'newmark'",
    ),
    "rho above one": ("step = 0.01", "step = 0.01\nrho_inf = 1.5", r"solver\.rho_inf: .*less than or equal to 1.*1\.5"),
    "group that is no table": ('[design]\nM = "loads.drive.torque"', "[design]\nM = 3", r"design\.M"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_in_a_scene_file_names_file_key_and_what_is_possible(file, mistake):
    old, new, message = MISTAKES[mistake]
    with pytest.raises(InputError, match=rf"(?s)pendulum\.toml: .*({message})"):
        compile_scene(read_scene(file(old, new)))


def test_all_mistakes_of_a_file_are_reported_at_once(tmp_path):
    path = tmp_path / "pendulum.toml"
    path.write_text(TEXT.replace("torque = 2.0", "torqe = 2.0").replace("area", "aera").replace("end_time", "endtime"))
    with pytest.raises(InputError) as error:
        read_scene(path)
    for key in ("loads.drive.torqe", "bodies.rod.aera", "solver.endtime"):
        assert key in str(error.value)


def test_a_missing_scene_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"absent\.toml' cannot be read \(No such file"):
        read_scene(tmp_path / "absent.toml")


@pytest.mark.parametrize(
    ("path", "named"), [("morphing_wing/scene.tml", "scene.toml"), ("morphing_wings/scene.toml", "morphing_wing")]
)
def test_a_path_that_leads_nowhere_is_told_what_was_probably_meant(path, named):
    with pytest.raises(InputError, match=rf"cannot be read \(No such file or directory, did you mean '{named}'\)"):
        read_scene(WING.parent / path)


def test_a_reduced_model_in_place_of_a_scene_is_told_as_what_it_is():
    with pytest.raises(InputError, match=r"skin\.h5' holds numbers in HDF5.*is not a scene in TOML"):
        read_scene(WING / "skin.h5")


def test_a_folder_in_place_of_a_scene_is_told_with_what_is_in_it():
    with pytest.raises(InputError, match=r"a folder.*Give the path of a scene in TOML; in this folder there are: .*scene\.toml"):
        read_scene(WING)


def test_what_is_no_toml_by_its_name_either_is_taken_for_something_else(tmp_path):
    (tmp_path / "body.msh").write_text("$MeshFormat")
    with pytest.raises(InputError, match=r"Fix that line, or give the path of a scene in TOML\."):
        read_scene(tmp_path / "body.msh")


@pytest.mark.parametrize("content", [b"units = \n", b"\xff\xfe\x00", b"[points]\nA = [1, 2\n"])
def test_a_scene_file_that_is_no_toml_is_named(tmp_path, content):
    (tmp_path / "broken.toml").write_bytes(content)
    with pytest.raises(InputError, match=r"(?s)broken\.toml.*not readable as TOML.*Fix that line"):
        read_scene(tmp_path / "broken.toml")


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("points.Q.x", "1", r"pendulum\.toml: 'points\.Q\.x' leads nowhere: there is no 'Q'; possible here: O, A"),
        ("points.A.z", "1", r"leads nowhere: there is no 'z'; possible here: x, y"),
        ("points.A.x.y", "1", r"leads nowhere"),
        ("loads.drive.torqe", "1", r"loads\.drive\.torqe.*did you mean 'torque'"),
        ("solver.stepp", "1", r"solver\.stepp.*did you mean 'step'"),
        ("loads.drive.torque", "strong", r"loads\.drive\.torque.*given: 'strong'"),
        ("points.Ax", "1", r"'points\.Ax' leads nowhere: there is no 'Ax', did you mean 'A'; possible here: O, A"),
        ("nonsense", "1", r"'nonsense' leads nowhere: there is no 'nonsense'; possible here: .*points"),
    ],
)
def test_an_override_that_leads_nowhere_says_what_is_possible(file, key, value, message):
    with pytest.raises(InputError, match=message):
        read_scene(file(), {key: value})


def test_an_override_reaches_the_keys_at_the_top(file):
    assert read_scene(file(), {"units": '"mm-t-s"'}).units == "mm-t-s"


def test_an_override_replaces_the_number_that_its_path_names(file):
    changes = {
        "points.A.x": "1.5",
        "loads.drive.torque": "7",
        "solver.baumgarte.damping": "3.0",
        "bodies.rod.between": '["A", "O"]',
    }
    scene = read_scene(file(), changes)
    assert scene.number("points.A.x") == 1.5
    assert scene.number("loads.drive.torque") == 7.0
    assert scene.solver.baumgarte.damping == 3.0
    assert scene.bodies["rod"].between == ("A", "O")


# --- design variables -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["thickness", "points.A.z", "loads.drive"])
def test_an_unknown_design_variable_lists_the_available_ones(file, name):
    with pytest.raises(
        InputError, match=r"unknown design variable .*short names of the scene: M; paths: .*points\.A\.x, .*loads\.drive\.torque"
    ):
        compile_scene(read_scene(file()), [name])


@pytest.mark.parametrize(("letter", "number"), [("x", 0), ("y", 1)])
def test_a_component_of_a_planar_velocity_is_not_taken_for_its_rotation(letter, number):
    with pytest.raises(InputError, match=rf"'bodies\.mass\.velocity\.{letter}', did you mean 'bodies\.mass\.velocity\.{number}'"):
        fast_pendulum().design_variables([f"bodies.mass.velocity.{letter}"])


def test_a_design_entry_that_leads_nowhere_is_refused(file):
    with pytest.raises(
        InputError, match=r"design\.M: the path 'loads\.motor\.torque' .*leads nowhere.*loads\.drive\.torque.*\(line \d+\)"
    ):
        read_scene(file('M = "loads.drive.torque"', 'M = "loads.motor.torque"'))


def test_a_parameter_of_the_skin_that_does_not_exist_lists_those_that_do():
    scene = read_scene(WING / "scene.toml")
    with pytest.raises(InputError, match=r"bodies\.skin\.thickness"):
        compile_scene(scene, ["bodies.skin.tickness"])
    with pytest.raises(InputError, match=r"no key 'tickness', did you mean 'thickness', .*; parameters: .*thickness"):
        compile_scene(read_scene(WING / "scene.toml", {"bodies.skin.tickness": "1.5"}))


def test_a_misspelt_key_of_a_flexible_body_is_told_beside_its_own_keys():
    with pytest.raises(InputError, match=r"bodies\.skin has no key 'frams', did you mean 'frames', .*Keys: .*frames"):
        compile_scene(read_scene(WING / "scene.toml", {"bodies.skin.frams": "4"}))


def test_a_design_variable_that_would_tear_a_joint_at_the_start_is_refused():
    scene = pendulum(joints={"link": Distance(bodies=("rod", "ground"), points=("A", "C"), length=0.5)})
    with pytest.raises(InputError, match=r"'joints\.link\.length' would violate distance of joint 'link' at the start"):
        simulate(compile_scene(scene, ["joints.link.length"]))


# --- joints that cannot be ------------------------------------------------------------------------------------------------------


def test_redundant_joints_are_named():
    twice = pendulum(joints={"again": Revolute(bodies=("rod", "ground"), point="O")})
    for solve in (simulate, solve_statics):
        with pytest.raises(
            SingularSystemError,
            match=r"joint '(hinge|again)'.*joint '(hinge|again)'.*repeat or contradict each other.*Remove one",
        ):
            solve(compile_scene(twice))


def test_contradictory_joints_are_named():
    locked = pendulum(
        joints={
            "weld": RigidJoint(bodies=("rod", "ground"), point="A"),
            "drive": AngleDriver(bodies=("rod", "ground"), point="O", curve=SmoothStep(height=1.0)),
        }
    )
    with pytest.raises(SingularSystemError, match=r"constraints .*repeat or contradict each other"):
        simulate(compile_scene(locked))


def test_only_the_joints_at_fault_are_named():
    """A second pendulum next to the doubled hinge is innocent."""
    other = {"other": Rod(between=("B", "D"), area=1.0, density=1.0)}
    points = {"B": Point(x=3.0, y=0.0), "D": Point(x=4.0, y=0.5)}
    joints = {"innocent": Revolute(bodies=("other", "ground"), point="B"), "again": Revolute(bodies=("rod", "ground"), point="O")}
    with pytest.raises(SingularSystemError) as error:
        simulate(compile_scene(pendulum(points=points, bodies=other, joints=joints)))
    assert "innocent" not in str(error.value)


def test_a_joint_that_is_open_at_the_start_is_named_with_its_gap():
    scene = pendulum(joints={"link": Distance(bodies=("rod", "ground"), points=("A", "C"), length=0.7)})
    with pytest.raises(InputError, match=r"inconsistent start: distance of joint 'link' is violated by -0\.2 m at t = 0"):
        simulate(compile_scene(scene))


def test_a_free_mechanism_has_no_static_state_and_the_free_body_is_named():
    with pytest.raises(SingularSystemError, match=r"nothing determines .*rotation of body 'rod'.*free to move.*Add a joint"):
        solve_statics(compile_scene(pendulum(loads={"gravity": Gravity(acceleration=(0.0, 0.0))})))


@pytest.mark.parametrize(
    ("removed", "moving", "ways"),
    [  # Gruebler: of n bodies in the plane with j pins 3 n - 2 j ways; the skin is held by its clamp, and counts as the ground
        ("A", "'body2', 'body3', 'body4' and 'body5'", "1 way,"),
        ("AE", "'body2', 'body3', 'body4' and 'body5'", "3 ways,"),
        ("ACE", "'body2', 'body3', 'body4' and 'body5'", "5 ways,"),
    ],
)
def test_bodies_that_a_removed_support_sets_free_are_counted_and_named(removed, moving, ways):
    scene = read_scene(Path(__file__).parents[2] / "models" / "morphing_wing" / "scene.toml")
    joints = {name: joint for name, joint in scene.joints.items() if name not in removed}
    system = compile_scene(scene.model_copy(update={"joints": joints}))
    with pytest.raises((ConvergenceError, SingularSystemError), match=f"{moving} can move freely in {ways} which no joint"):
        solve_statics(system)
    drawn = free_motion_states(system)
    assert len(drawn.names) == 1 + int(ways[0])
    swing = free_motion_states(system, 20)
    np.testing.assert_allclose(swing.q[[int(time) for time in farthest(swing, 20)]], drawn.q, atol=1e-12)  # sin(pi / 2) is 1
    assert np.abs(np.diff(swing.q, axis=0)).max(axis=1).min() > 0
    padded = np.hstack([drawn.q, np.zeros((len(drawn.q), system.n - system.n_q))])
    terms = [system.evaluate(system.inputs(0.0, np.array([0, 0, 1.0])), q, 0 * q, 0 * q) for q in padded]
    gaps = [np.abs(each.applied[system.n_q :] * system.weights[system.n_q :]).max() for each in terms]
    assert max(gaps) < 0.1**2  # joints hold to first order of the tenth that is drawn
    with pytest.raises(InputError, match="nothing can move freely"):
        free_motion_states(compile_scene(scene))


# --- points and models of flexible bodies --------------------------------------------------------------------------------------


def test_a_grip_off_the_interface_points_lists_those_that_exist():
    with pytest.raises(InputError, match=r"point 'A' is not an interface point of flexible body 'skin'.*with one of: C, E, G"):
        compile_scene(read_scene(WING / "scene.toml", {"joints.C.point": '"A"'}))


def test_an_interface_point_that_does_not_exist_lists_those_that_do():
    with pytest.raises(InputError, match=r"flexible body 'skin' has no interface point 'Q'; available: C, E, G"):
        compile_scene(read_scene(WING / "scene.toml", {"points.C.interface": '"Q"'}))


def wing_without(folder: Path, *groups: str) -> Path:
    """A copy of the wing's scene whose reduced model lacks some groups."""
    for name in ("scene.toml", "skin.h5"):
        shutil.copy(WING / name, folder / name)
    with h5py.File(folder / "skin.h5", "a", libver="v110") as file:
        for group in groups:
            del file[group]
    return folder / "scene.toml"


def test_a_model_without_interface_points_says_so(tmp_path):
    with pytest.raises(InputError, match=r"flexible body 'skin' has no interface point '\w'; available: none\. Add it"):
        compile_scene(read_scene(wing_without(tmp_path, "interfaces")))


@pytest.mark.parametrize("changes", [{"bodies.skin.thickness": "1.6"}, {}])
def test_a_parameter_that_nobody_differentiated_by_is_neither_moved_nor_a_design_variable(tmp_path, changes):
    scene = read_scene(wing_without(tmp_path, "affine", "derivatives"), changes)
    design = [] if changes else ["bodies.skin.thickness"]
    with pytest.raises(InputError, match=r"'thickness' has no derivatives in reduced model 'skin\.h5'.*rerun preprocessing"):
        compile_scene(scene, design)


def test_an_interface_point_of_a_rigid_body_is_refused():
    with pytest.raises(InputError, match=r"points\.C is an interface point of body 'body2', which is not flexible"):
        compile_scene(read_scene(WING / "scene.toml", {"points.C.body": '"body2"'}))


def test_an_interface_point_of_a_missing_body_is_refused():
    with pytest.raises(
        InputError,
        match=r"points\.C names body 'skim', which does not exist, did you mean 'skin'; bodies of the scene: skin, body2",
    ):
        read_scene(WING / "scene.toml", {"points.C.body": '"skim"'})


def test_a_missing_model_file_is_named():
    with pytest.raises(ModelFileError, match=r"there is no reduced model .*absent\.h5"):
        compile_scene(read_scene(WING / "scene.toml", {"bodies.skin.model": '"absent.h5"'}))


def test_a_model_in_other_units_than_the_scene_is_refused(tmp_path):
    shutil.copy(WING / "skin.h5", tmp_path)
    (tmp_path / "scene.toml").write_text((WING / "scene.toml").read_text().replace('units = "mm-t-s"', 'units = "m-kg-s"'))
    with pytest.raises(InputError, match=r"skin\.h5.*mm-t-s.*m-kg-s|m-kg-s.*skin\.h5.*mm-t-s"):
        compile_scene(read_scene(tmp_path / "scene.toml"))


# --- curves ---------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [AngleDriver, PositionDriver])
def test_a_driver_refuses_a_curve_with_corners(kind):
    corner = Table(times=(0.0, 1.0, 2.0), values=(0.0, 1.0, 0.0), interpolation="linear")
    for curve in (corner, Sum(terms=(Constant(value=1.0), corner))):
        with pytest.raises(ValidationError, match="a driver needs a curve with a second derivative; a table of straight lines"):
            kind(bodies=("rod", "ground"), point="A", curve=curve)


def test_a_driver_with_corners_in_a_file_names_the_key(file):
    table = '{ type = "table", times = [0.0, 1.0], values = [0.0, 1.0], interpolation = "linear" }'
    driver = f'drive = {{ type = "angle-driver", bodies = ["rod", "ground"], point = "O", curve = {table} }}\n\n[loads]'
    with pytest.raises(
        InputError, match=r"pendulum\.toml: joints\.drive\.curve: .*a driver needs a curve with a second derivative"
    ):
        read_scene(file("[loads]", driver))


@pytest.mark.parametrize(
    ("times", "values"), [((0.0, 1.0), (1.0,)), ((0.0, 0.0), (1.0, 2.0)), ((1.0, 0.0), (1.0, 2.0)), ((0.0,), (1.0,))]
)
def test_a_table_needs_increasing_times_and_as_many_values(times, values):
    with pytest.raises(ValidationError, match=r"as many of each|times must increase|at least 2"):
        Table(times=times, values=values)


# --- steps that are too large, and Newton's failure -----------------------------------------------------------------------------


def test_a_step_larger_than_the_whole_time_is_refused():
    with pytest.raises(InputError, match=r"solver\.step = 2 is larger than solver\.end_time = 1.*resolves the motion"):
        simulate(compile_scene(pendulum()), RunOptions(end_time=1.0, step=2.0))


def fast_pendulum() -> Scene:
    """One that turns ten times per second."""
    points = {"P": Point(x=1.0, y=0.0), "O": Point(x=0.0, y=0.0)}
    mass = Rigid(mass=1.0, inertia=1.0, center="P", velocity=(0.0, 63.0, 0.0))
    link = Distance(bodies=("mass", "ground"), points=("P", "O"))
    return Scene(units="m-kg-s", points=points, bodies={"mass": mass}, joints={"link": link})


@pytest.mark.parametrize("scheme", ["paper", "arnold-bruels"])
@pytest.mark.parametrize("step", [0.05, 0.1, 0.3])
def test_a_step_too_coarse_for_the_motion_is_refused_not_answered(scheme, step):
    """Half a turn per step and more; a result would be nonsense."""
    with pytest.raises(
        ConvergenceError,
        match=r"Newton stopped at t = .*Try a smaller solver\.step|joints came apart: .*joint 'link'.*Try a tenth",
    ):
        simulate(compile_scene(fast_pendulum()), RunOptions(end_time=3.0, step=step, scheme=scheme))


def test_newtons_failure_names_time_equation_and_remedy():
    scene = read_scene(WING / "scene.toml", {"loads.drive.torque": "4.2e6"})
    message = (
        r"Newton stopped at t = [\d.]+ after \d+ iterations: "
        r".*largest in .* of body '.*'\. Try a smaller solver\.step \(now 0\.05\)"
    )
    with pytest.raises(ConvergenceError, match=message):
        simulate(compile_scene(scene))


def test_too_few_iterations_are_a_failure_too():
    with pytest.raises(ConvergenceError, match=r"after 1 iterations: correction .* > 1\.0e-10"):
        simulate(compile_scene(pendulum()), RunOptions(end_time=0.1, step=0.01, max_iterations=1))


def test_a_driver_into_a_dead_centre_is_refused():
    """A slider-crank driven by its slider beyond its reach."""
    points = {"T": Point(x=0.5, y=0.5), "X": Point(x=1.5, y=0.0), "O": Point(x=0.0, y=0.0)}
    bodies = {"crank": Rod(between=("O", "T"), area=1.0, density=1.0), "link": Rod(between=("T", "X"), area=1.0, density=1.0)}
    joints = {
        "O": Revolute(bodies=("crank", "ground"), point="O"),
        "T": Revolute(bodies=("crank", "link"), point="T"),
        "X": PositionDriver(bodies=("link", "ground"), point="X", axis=(1.0, 0.0), curve=SmoothStep(height=1.0)),
        "Y": PositionDriver(bodies=("link", "ground"), point="X", axis=(0.0, 1.0), curve=Constant(value=0.0)),
    }
    scene = Scene(units="m-kg-s", points=points, bodies=bodies, joints=joints)
    with pytest.raises((ConvergenceError, SingularSystemError), match=r"t = 0\.\d+|joints came apart"):
        simulate(compile_scene(scene), RunOptions(end_time=1.0, step=0.01))
    with pytest.raises((ConvergenceError, SingularSystemError)):
        solve_statics(compile_scene(scene))


def test_a_curve_that_starts_with_a_jump_is_an_inconsistent_start():
    drive = AngleDriver(bodies=("rod", "ground"), point="O", curve=Sine(frequency=1.0, phase=np.pi / 2))
    with pytest.raises(InputError, match=r"inconsistent start: rotation of joint 'drive' is violated by -1 rad at t = 0"):
        simulate(compile_scene(pendulum(joints={"drive": drive})))


# --- what is refused before anything runs -------------------------------------------------------------------------------------


def test_a_mistake_is_told_in_one_line_without_the_whole_scene(file):
    with pytest.raises(InputError) as caught:
        read_scene(file('body = "rod"', 'body = "rood"'))
    assert str(caught.value).startswith("pendulum.toml: loads.drive names body 'rood'")
    assert "Value error" not in str(caught.value)
    assert "given" not in str(caught.value)


def test_an_empty_scene_is_refused():
    with pytest.raises(InputError, match=r"no body, so nothing can move.*\[bodies\]"):
        compile_scene(Scene(units="m-kg-s", bodies={}))


@pytest.mark.parametrize("parameter", ["thickness", "youngs_modulus", "density", "width"])
@pytest.mark.parametrize("value", ["-1.0", "0.0"])
def test_a_skin_needs_positive_parameters(parameter, value):
    scene = read_scene(WING / "scene.toml", {f"bodies.skin.{parameter}": value})
    with pytest.raises(InputError, match=rf"bodies\.skin\.{parameter} = -?\d must be a positive number"):
        compile_scene(scene)


def test_a_grounded_skin_has_no_velocity():
    with pytest.raises(InputError, match=r"bodies\.skin: a grounded body cannot have a `velocity`; write frame = .moving."):
        read_scene(WING / "scene.toml", {"bodies.skin.velocity": "[1.0, 0.0, 0.0]"})
    assert not [path for path in read_scene(WING / "scene.toml").available_paths() if path.startswith("bodies.skin.velocity")]


COINCIDENT = {
    "rod": {"bodies": {"other": Rod(between=("A", "B"), area=1.0, density=1.0)}},
    "distance": {"joints": {"other": Distance(bodies=("rod", "ground"), points=("A", "B"))}},
    "spring": {"loads": {"other": SpringDamper(bodies=("rod", "ground"), points=("A", "B"), stiffness=1.0)}},
}


@pytest.mark.parametrize("kind", COINCIDENT)
def test_points_at_the_same_place_have_no_direction(kind):
    scene = pendulum(points={"B": Point(x=1.0, y=0.0)}, **COINCIDENT[kind])
    with pytest.raises(InputError, match=r"other leads from point 'A' to point 'B', which are at the same place"):
        compile_scene(scene)


def test_loads_without_effect_are_refused():
    with pytest.raises(ValidationError, match="force on the ground has no effect"):
        PointForce(body="ground", point="A", force=(1.0, 0.0))
    with pytest.raises(ValidationError, match="a spring-damper between two points of the ground has no effect"):
        SpringDamper(bodies=("ground", "ground"), points=("A", "O"), stiffness=1.0)
    with pytest.raises(ValidationError, match="acts between two different bodies"):
        RotationalSpringDamper(bodies=("rod", "rod"), point="A", stiffness=1.0)
    with pytest.raises(ValidationError, match="a spring-damper has no effect without stiffness or damping; give one of them"):
        SpringDamper(bodies=("rod", "ground"), points=("A", "O"), length=2.0)
    with pytest.raises(ValidationError, match="a rotational-spring-damper has no effect without stiffness or damping"):
        RotationalSpringDamper(bodies=("rod", "ground"), point="A", rest_angle=0.1)
    with pytest.raises(ValidationError, match="a bushing has no effect without stiffness, damping, rotational_stiffness or rot"):
        Bushing(bodies=("rod", "ground"), point="A")


def test_a_spring_within_a_rigid_body_is_doubted():
    spring = SpringDamper(bodies=("rod", "rod"), points=("A", "O"), stiffness=1.0)
    (caution,) = cautions_of_scene(pendulum(loads={"spring": spring}))
    assert (caution.code, caution.doubt) == ("load-within-body", True)
    assert cautions_of_scene(pendulum(loads={"spring": spring.model_copy(update={"bodies": ("rod", "ground")})})) == []


@pytest.mark.parametrize(
    ("step", "message"), [(1e-9, "more than can be kept"), (1e-60, "more than can be kept"), (1e-7, r"need \d+ GB")]
)
def test_a_run_that_no_machine_can_hold_is_refused_before_it_starts(step, message):
    chain = {f"B{k}": Rod(between=("O", "A"), area=1.0, density=1.0) for k in range(20)}
    with pytest.raises(InputError, match=message):
        simulate(compile_scene(pendulum(bodies=chain)), RunOptions(end_time=1.0, step=step))


def test_a_time_between_two_steps_is_refused_before_the_run(file):
    response = '[responses]\nturn = { type = "rotation", body = "rod", point = "O", time = 0.123 }\n[design]'
    with pytest.raises(InputError, match=r"no time step at t = 0\.123; the nearest is 0\.12"):
        prepare(read_scene(file("[design]", response)))


def test_joints_without_stabilisation_are_told_from_a_step_too_large():
    options = RunOptions(end_time=2.0, step=0.02, baumgarte={"damping": 0.0, "stiffness": 0.0})
    with pytest.raises(ConvergenceError, match=r"joints came apart.*nothing pulls them back.*solver\.baumgarte"):
        simulate(compile_scene(fast_pendulum()), options)
