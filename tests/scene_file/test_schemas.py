"""The JSON schemas for editors are those of the classes, accept what the program accepts, and refuse what it refuses."""

from __future__ import annotations

import json
import runpy
import tomllib
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft7Validator

from preprocessing.builders.skin_recipe import SkinRecipe
from tests.models.cases import KINDS, Case
from tests.models.scenes import hanging_skin
from toolkit.components.bodies.body import PlanarBody
from toolkit.components.joints.joint import Joint
from toolkit.components.loads.gravity import Gravity
from toolkit.files.scene_reader import read_scene, scene_from_table
from toolkit.foundation.errors import InputError
from toolkit.scene.kinds import kinds_of

ROOT = Path(__file__).parents[2]
FILES = sorted(ROOT.glob("models/*/*.toml"))
SCENE = ROOT / "models" / "morphing_wing" / "scene.toml"
SKIN = ROOT / "models" / "morphing_wing" / "skin.toml"


def schema(name: str) -> dict[str, Any]:
    return json.loads((ROOT / "schemas" / f"{name}.json").read_text())


def complaints(table: dict[str, Any], name: str) -> list[str]:
    """What the schema has against a table."""
    return [error.message for error in Draft7Validator(schema(name)).iter_errors(table)]


@pytest.mark.parametrize("name", ["scene", "skin", "body", "frame", "study"])
def test_the_shipped_schema_is_valid_and_freshly_written(name):
    texts = runpy.run_path(str(ROOT / "schemas" / "write_schemas.py"))["texts"]
    assert (ROOT / "schemas" / f"{name}.json").read_text() == texts[name], "run: python schemas/write_schemas.py"
    Draft7Validator.check_schema(schema(name))


@pytest.mark.parametrize("name", ["plane", "space"])
def test_type_checkers_see_the_names_that_scenes_in_python_are_made_of(name):
    stub = runpy.run_path(str(ROOT / "schemas" / "write_schemas.py"))["stubs"][name]
    assert (ROOT / "toolkit" / "api" / f"{name}.pyi").read_text() == stub, "run: python schemas/write_schemas.py"
    assert f"import {'Spatial' * (name == 'space')}Revolute as Revolute" in stub


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_every_file_of_the_models_names_its_schema_and_meets_it(path):
    first = path.read_text().splitlines()[0]
    assert first == f"#:schema ../../schemas/{path.stem}.json"
    assert (path.parent / first.split()[1]).exists()
    assert complaints(tomllib.loads(path.read_text()), path.stem) == []


def written(component: Any) -> dict[str, Any]:
    """A component as it stands in a file."""
    given = {key: value for key, value in component.model_dump(mode="json").items() if value is not None}
    return {"type": component.kind, **given}


@pytest.mark.parametrize(("kind", "numbers"), [kind[1:] for kind in KINDS], ids=[kind[0] for kind in KINDS])
def test_every_joint_and_load_meets_the_schema(kind, numbers):
    group = "joint" if issubclass(kind, Joint) else "load"
    component = kind(**Case("", kind, numbers, ("a", "b"), ("P", "Q"), "P")._places(), **numbers)
    assert complaints({"units": "m-kg-s", "bodies": {}, f"{group}s": {"component": written(component)}}, "scene") == []


def test_every_body_response_and_point_of_a_rich_scene_meets_the_schema():
    scene = hanging_skin()
    table: dict[str, Any] = {"units": scene.units, "solver": scene.solver.model_dump(mode="json", exclude_none=True)}
    for group in ("bodies", "loads", "joints", "responses"):
        table[group] = {name: written(part) for name, part in getattr(scene, group).items()}
    table["responses"]["energy"]["of"] = {"type": "kinetic-energy"}  # it holds a response, which a file writes as a table
    table["points"] = {name: point.model_dump(exclude_none=True) for name, point in scene.points.items()}
    table["points"] = {name: [at["x"], at["y"]] if "x" in at else at for name, at in table["points"].items()}
    assert complaints(table, "scene") == []


def test_the_schema_says_what_numbers_measure_as_the_program_reads_it():
    kinds = schema("scene")["$defs"]
    assert kinds["body-rigid"]["properties"]["inertia"]["description"] == "mass length^2"
    assert kinds["joint-angle-driver"]["properties"]["curve"]["description"] == "angle"
    assert "description" not in kinds["joint-slider"]["properties"]["axis"]


def test_kinds_of_users_and_tests_stay_out_of_the_shipped_schema():
    type("Stray", (Gravity,), {"kind": "test-stray", "__module__": __name__})
    type("StrayBody", (PlanarBody,), {"kind": "test-stray-body", "__module__": __name__})
    assert "test-stray" in kinds_of(2)["loads"]
    assert "test-stray-body" in kinds_of(2)["bodies"]
    texts = runpy.run_path(str(ROOT / "schemas" / "write_schemas.py"))["texts"]
    assert "test-stray" not in texts["scene"]


WRONG = {
    "missing units": lambda table: table.pop("units"),
    "unknown units": lambda table: table.update(units="inch"),
    "unknown table": lambda table: table.update(joint={}),
    "point with three coordinates": lambda table: table["points"].update(A=[1.0, 2.0, 3.0]),
    "unknown kind of body": lambda table: table["bodies"]["body2"].update(type="rood"),
    "body without a kind": lambda table: table["bodies"]["body2"].pop("type"),
    "negative area": lambda table: table["bodies"]["body2"].update(area=-1.0),
    "unknown key of a joint": lambda table: table["joints"]["A"].update(pont="A"),
    "joint of three bodies": lambda table: table["joints"]["A"].update(bodies=["a", "b", "c"]),
    "word for a number": lambda table: table["loads"]["drive"].update(torque="much"),
    "curve without a type": lambda table: table["loads"]["drive"].update(curve={"duration": 1.0}),
    "integral of a number": lambda table: table["responses"].update(sum={"type": "time-integral", "of": 3.0}),
    "damping of more than one": lambda table: table["solver"].update(rho_inf=1.5),
}


@pytest.mark.parametrize("case", WRONG)
def test_schema_and_program_refuse_the_same_wrong_scenes(case):
    table = tomllib.loads(SCENE.read_text())
    WRONG[case](table)
    assert complaints(table, "scene") != []
    with pytest.raises(InputError):
        scene_from_table(table, SCENE)


WRONG_SKINS = {
    "unknown key": ("thickness = 1.5", "thickness = 1.5\nthikness = 2.0"),
    "missing key": ("chord = 550.0", ""),
    "negative number": ("thickness = 1.5", "thickness = -1.5"),
    "one element": ("elements = 30", "elements = 1"),
    "unknown side": ('side = "upper"', 'side = "top"'),
}


@pytest.mark.parametrize("case", WRONG_SKINS)
def test_schema_and_program_refuse_the_same_wrong_skins(case, tmp_path):
    old, new = WRONG_SKINS[case]
    wrong = SKIN.read_text().replace(old, new)
    (tmp_path / "skin.toml").write_text(wrong)
    assert complaints(tomllib.loads(wrong), "skin") != []
    with pytest.raises(InputError):
        SkinRecipe.read(tmp_path / "skin.toml")


def test_the_first_line_is_no_hindrance_to_the_program():
    assert read_scene(SCENE).units == SkinRecipe.read(SKIN).file.units == "mm-t-s"
