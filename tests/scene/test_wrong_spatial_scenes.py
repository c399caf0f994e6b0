"""What users get wrong in scenes in space, and what the toolkit and its schema say about it."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft7Validator

from tests.models.spatial_cases import KINDS, SpatialCase
from tests.models.spatial_every_number import SCENES
from toolkit.analyses.sensitivity.preparation import prepare
from toolkit.components.joints.joint import Joint
from toolkit.files.results import table_of
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError

DOOR = """units = "m-kg-s"
dimension = 3

[points]
hinge = [0.0, 0.0, 1.0]
middle = [0.4, 0.0, 1.0]
edge = [0.8, 0.0, 1.0]
wall = [0.0, 0.5, 1.0]

[bodies]
door = { type = "rigid", mass = 20.0, inertia = [7.0, 8.0, 1.1], center = "middle" }

[joints]
hinge = { type = "revolute", bodies = ["door", "ground"], point = "hinge", axis = [0.1, 0.0, 1.0] }

[loads]
weight = { type = "gravity", acceleration = [0.0, 0.0, -9.81] }
spring = { type = "spring-damper", bodies = ["door", "ground"], points = ["edge", "wall"], stiffness = 30.0, damping = 3.0, length = 0.5 }

[responses]
energy = { type = "kinetic-energy" }
edge = { type = "displacement", body = "door", point = "edge", component = "z" }

[design]
lift = "points.wall.z"
g = "loads.weight.acceleration.z"

[solver]
end_time = 0.1
step = 0.01
"""
SCHEMA = json.loads((Path(__file__).parents[2] / "schemas" / "scene.json").read_text())


def complaints(table: dict[str, Any]) -> list[str]:
    """What the schema has against a scene."""
    return [error.message for error in Draft7Validator(SCHEMA).iter_errors(table)]


def refused(text: str, folder: Path, message: str) -> None:
    """The program refuses a scene with a message."""
    path = folder / "door.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        prepare(read_scene(path))


def test_the_door_meets_the_schema_and_its_numbers_have_paths(tmp_path):
    assert complaints(tomllib.loads(DOOR)) == []
    path = tmp_path / "door.toml"
    path.write_text(DOOR)
    changes = {"points.wall.z": "1.5", "loads.weight.acceleration.z": "-1.6", "joints.hinge.axis.0": "0.2", "g": "-1.7"}
    scene = read_scene(path, changes)
    wanted = {"points.wall.z": 1.5, "loads.weight.acceleration.2": -1.7, "joints.hinge.axis.x": 0.2}
    assert {name: scene.number(name) for name in wanted} == wanted
    assert [each.path for each in scene.design_variables()] == ["points.wall.z", "loads.weight.acceleration.2"]


@pytest.mark.parametrize(("kind", "numbers"), [kind[1:] for kind in KINDS], ids=[kind[0] for kind in KINDS])
def test_every_joint_and_load_in_space_meets_the_schema(kind, numbers):
    group = "joints" if issubclass(kind, Joint) else "loads"
    component = kind(**SpatialCase("", kind, numbers, ("a", "b"), ("P", "Q"), "P").places(), **numbers)
    written = {"type": component.kind, **component.model_dump(mode="json", exclude_none=True)}
    assert complaints({"units": "m-kg-s", "dimension": 3, "bodies": {}, group: {"component": written}}) == []


@pytest.mark.parametrize("name", SCENES)
def test_scenes_with_every_kind_meet_the_schema_when_they_are_written(name, tmp_path):
    assert complaints(json.loads(json.dumps(table_of(SCENES[name](tmp_path))))) == []


WRONG = {
    "no dimension": ("dimension = 3\n", "", r"points\.hinge has 3 coordinates; a planar point has two, .* begins with dimension = 3"),
    "wrong dimension": ("dimension = 3", "dimension = 4", r"dimension = 4 is invalid.*Write dimension = 3"),
    "dimension in words": ("dimension = 3", 'dimension = "3"', r"dimension = '3' is invalid"),
    "two coordinates": ("[0.8, 0.0, 1.0]", "[0.8, 0.0]", r"points\.edge has 2 coordinates; a point in space has three, \[x, y, z\]"),
    "four coordinates": ("[0.8, 0.0, 1.0]", "[0.8, 0.0, 1.0, 2.0]", r"points\.edge has 4 coordinates; a point in space has three"),
    "planar joint": ('type = "revolute"', 'type = "slider"', r"joints\.hinge\.type = 'slider' is .* scenes with dimension = 2"),
    "unknown joint": ('type = "revolute"', 'type = "hinge"', r"joints\.hinge\.type = 'hinge' is unknown; available: .*universal"),
    "missing axis": (", axis = [0.1, 0.0, 1.0]", "", r"joints\.hinge\.axis: this key is missing"),
    "axis without direction": ("axis = [0.1, 0.0, 1.0]", "axis = [0, 0, 0.0]", r"joints\.hinge\.axis: an axis needs a direction"),
    "axis of two numbers": ("axis = [0.1, 0.0, 1.0]", "axis = [0.1, 0.0]", r"joints\.hinge\.axis\.2: this entry is missing"),
    "gravity of the plane": ("[0.0, 0.0, -9.81]", "[0.0, -9.81]", r"loads\.weight\.acceleration\.2: this entry is missing"),
    "one moment of inertia": ("[7.0, 8.0, 1.1]", "7.0", r"bodies\.door\.inertia"),
    "four moments of inertia": ("[7.0, 8.0, 1.1]", "[7.0, 8.0, 1.1, 0.0]", r"bodies\.door\.inertia\.4: this entry is missing"),
    "inertia of no body": ("[7.0, 8.0, 1.1]", "[7.0, 8.0, 20.0]", r"bodies\.door\.inertia: no body has these moments of inertia"),
    "frame that is not known": ('center = "middle"', 'center = "middle", frame = "fixed"', r"bodies\.door\.frame: .*'grounded'"),
    "turning frame without axis": ('center = "middle"', 'center = "middle", frame = "turning"', r"bodies\.door: `axis` belongs to"),
    "velocity of a turning frame": (
        'center = "middle"',
        'center = "middle", frame = "turning", axis = [0, 0, 1.0], velocity = [1.0, 0, 0]',
        r"bodies\.door: the origin of a frame = \"turning\" does not move",
    ),
    "planar velocity and omega": (
        'center = "middle"',
        'center = "middle", frame = "translating", angular_velocity = [0, 0, 1.0]',
        r"bodies\.door: a frame = \"translating\" does not turn",
    ),
    "planar key": ('center = "middle"', 'center = "middle", angle = 0.3', r"bodies\.door\.angle: unknown key"),
    "missing point of the frame": ('center = "middle"', 'center = "middle", origin = "nowhere"', r"'nowhere', which does not exist"),
    "rotation without axis": (
        '{ type = "kinetic-energy" }',
        '{ type = "rotation", body = "door", point = "edge" }',
        r"a rotation in space needs an `axis`",
    ),
}  # fmt: skip
NOT_OF_THE_SCHEMA = (
    "axis without direction", "inertia of no body", "turning frame without axis", "velocity of a turning frame",
    "planar velocity and omega", "missing point of the frame", "rotation without axis",
)  # fmt: skip
"""What no schema can say, because several keys or numbers belong together."""


@pytest.mark.parametrize("case", WRONG)
def test_wrong_scenes_in_space_are_refused_by_name(case, tmp_path):
    old, new, message = WRONG[case]
    assert old in DOOR
    refused(DOOR.replace(old, new, 1), tmp_path, message)


@pytest.mark.parametrize("case", [case for case in WRONG if case not in NOT_OF_THE_SCHEMA])
def test_the_schema_refuses_the_same_scenes(case):
    old, new, _ = WRONG[case]
    assert complaints(tomllib.loads(DOOR.replace(old, new, 1))) != []


def test_a_spatial_kind_in_a_planar_scene_is_told_where_it_belongs(tmp_path):
    text = """units = "m-kg-s"
points = { O = [0.0, 0.0], A = [1.0, 0.0] }
bodies = { rod = { type = "rod", between = ["O", "A"], area = 1.0, density = 1.0 } }
joints = { ball = { type = "spherical", bodies = ["rod", "ground"], point = "O" } }
"""
    refused(
        text,
        tmp_path,
        r"'spherical' is unknown; available: .* It belongs to scenes with dimension = 3, this one has dimension = 2",
    )


@pytest.mark.parametrize(("change", "message"), [
    ("points.wall.w", "there is no 'w'; possible here: x, y, z"),
    ("loads.weight.acceleration.3", "there is no '3'; possible here: x, y, z"),
])  # fmt: skip
def test_paths_that_lead_nowhere_are_refused(change, message, tmp_path):
    (tmp_path / "door.toml").write_text(DOOR)
    with pytest.raises(InputError, match=message):
        read_scene(tmp_path / "door.toml", {change: "1.0"})


def test_the_third_number_of_a_planar_velocity_is_no_z(tmp_path):
    text = """units = "m-kg-s"
points = { O = [0.0, 0.0], A = [1.0, 0.0] }
bodies = { rod = { type = "rod", between = ["O", "A"], area = 1.0, density = 1.0, velocity = [0.0, 0.0, 1.0] } }
"""
    (tmp_path / "rod.toml").write_text(text)
    assert read_scene(tmp_path / "rod.toml", {"bodies.rod.velocity.2": "3.0"}).number("bodies.rod.velocity.2") == 3.0
    with pytest.raises(InputError, match="no 'z'; possible here: 0 to 2"):
        read_scene(tmp_path / "rod.toml", {"bodies.rod.velocity.z": "3.0"})
