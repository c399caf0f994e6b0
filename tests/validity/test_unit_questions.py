"""Numbers that are likely to be in other units than the file says are questioned, those of materials that exist are not."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

from preprocessing.commands.cli import main
from tests.preprocessing.test_frame_models import BENT
from toolkit.components.bodies.rigid import Rigid, Rod, SpatialRigid, SpatialRod
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.spherical import Spherical
from toolkit.components.loads.gravity import Gravity, SpatialGravity
from toolkit.description.design import Point
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.verdict import Verdict
from toolkit.reduced_model.questions import material_questions
from toolkit.scene.scene import Scene
from toolkit.validity.scene_cautions import cautions_of_scene

MODELS = Path(__file__).parents[2] / "models"
WING, BRACKET = MODELS / "morphing_wing" / "scene.toml", MODELS / "spatial_bracket" / "scene.toml"
MATERIALS = {
    "silica aerogel": (1e5, 100.0),
    "polystyrene foam": (5e6, 25.0),
    "soft polyurethane foam": (5e4, 20.0),
    "balsa": (3e9, 150.0),
    "cork": (2e7, 180.0),
    "gelatine": (5e3, 1010.0),
    "muscle": (5e4, 1060.0),
    "silicone rubber": (1e6, 1200.0),
    "filled tyre rubber": (5e6, 1250.0),
    "rubber loaded with barite": (2e7, 2400.0),
    "polyethylene": (2e8, 920.0),
    "nylon": (2.5e9, 1140.0),
    "ice": (9e9, 917.0),
    "oak": (1.2e10, 700.0),
    "concrete": (3e10, 2400.0),
    "wet sand": (2e7, 2000.0),
    "glass": (7e10, 2500.0),
    "magnesium": (4.5e10, 1740.0),
    "aluminium": (7e10, 2700.0),
    "titanium": (1.14e11, 4430.0),
    "steel": (2.1e11, 7850.0),
    "lead": (1.6e10, 11340.0),
    "tungsten": (4.1e11, 19300.0),
    "osmium": (5.6e11, 22590.0),
    "beryllium": (2.87e11, 1850.0),
    "carbon fibre": (9e11, 2200.0),
    "diamond": (1.14e12, 3515.0),
    "tungsten carbide": (6.5e11, 15600.0),
}
"""Modulus in Pa and density in kg/m^3, from handbooks."""
TO_MM = (1e-6, 1e-12)


@pytest.mark.parametrize("units", ["m-kg-s", "mm-t-s"])
@pytest.mark.parametrize("material", MATERIALS)
def test_no_material_that_exists_is_questioned(material, units):
    modulus, density = (x * (1.0 if units == "m-kg-s" else by) for x, by in zip(MATERIALS[material], TO_MM, strict=True))
    values = {"youngs_modulus": modulus, "density": density, "density_nose": density, "youngs_modulus_nose": modulus}
    assert list(material_questions(values, units, "bodies.skin")) == []


WRONG = {
    "Pa in mm-t-s": ("mm-t-s", 70e9, 2.7e-9, ("youngs_modulus = 7e+10 MPa", "7e+10 reads as Pa", "MPa: 70000"), True),
    "kg/m3 in mm-t-s": ("mm-t-s", 70e3, 2700.0, ("density = 2700 t/mm^3", "2700 reads as kg/m^3", "t/mm^3: 2.7e-09"), True),
    "g/cm3 in mm-t-s": ("mm-t-s", 210e3, 7.85, ("density = 7.85 t/mm^3", "7.85 reads as g/cm^3", ": 7.85e-09"), True),
    "kg/mm3 in mm-t-s": ("mm-t-s", 210e3, 7.85e-6, ("density = 7.85e-06", "reads as kg/mm^3", ": 7.85e-09"), True),
    "kPa in mm-t-s": ("mm-t-s", 2.1e8, 7.85e-9, ("youngs_modulus = 2.1e+08 MPa", "reads as kPa", ": 210000"), True),
    "GPa in m-kg-s": ("m-kg-s", 210.0, 7850.0, ("youngs_modulus = 210 Pa", "210 reads as GPa", "Pa: 2.1e+11"), True),
    "t/mm3 in m-kg-s": ("m-kg-s", 210e9, 7.85e-9, ("density = 7.85e-09 kg/m^3", "reads as t/mm^3", ": 7850"), True),
    "MPa in m-kg-s": ("m-kg-s", 210e3, 7850.0, ("210000 Pa with a density", "softer than", "reads as MPa", "2.1e+11"), True),
    "MPa of aluminium": ("m-kg-s", 70e3, 2700.0, ("70000 Pa with a density", "softer than", "reads as MPa", "7e+10"), True),
    "GPa of aluminium": ("mm-t-s", 70.0, 2.7e-9, ("70 MPa with a density", "softer than", "reads as GPa", "of aluminium"), True),
    "no metal": ("mm-t-s", 30.0, 2.7e-9, ("30 MPa with a density", "softer than"), False),
    "g/cm3 in m-kg-s": ("m-kg-s", 210e9, 7.85, ("with a density of 7.85 kg/m^3", "stiffer", "reads as g/cm^3", ": 7850"), True),
    "no unit at all": ("m-kg-s", 1e30, 7850.0, ("youngs_modulus = 1e+30 Pa", "fix the exponent or the units"), True),
}
"""Units, modulus, density; what is said, and whether it is beyond any material."""


@pytest.mark.parametrize("case", WRONG)
def test_units_that_are_mixed_up_are_questioned_with_what_they_read_as(case):
    units, modulus, density, words, doubt = WRONG[case]
    (caution,) = material_questions({"youngs_modulus": modulus, "density": density}, units, "bodies.skin")
    assert caution.text.startswith("bodies.skin.")
    assert [word for word in words if word not in caution.text] == [], caution.text
    assert caution.doubt == doubt


def test_many_parameters_are_questioned_once():
    values = {f"youngs_modulus_{k}": 70e9 for k in range(30)}
    (caution,) = material_questions(values, "mm-t-s", "bodies.skin")
    assert "youngs_modulus_0 = 7e+10 MPa (so have 29 more parameters)" in caution.text


def test_numbers_of_order_one_make_no_doubt():
    cautions = list(material_questions({"youngs_modulus": 1.0, "density": 1.0}, "m-kg-s", "bodies.skin"))
    assert cautions
    assert Verdict.of(cautions).trusted


# --- scenes ---------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", sorted(MODELS.glob("*/scene.toml")), ids=lambda path: path.parent.name)
def test_the_models_are_not_questioned(path):
    assert cautions_of_scene(read_scene(path)) == []


def codes(scene: Scene) -> dict[str, bool]:
    return {caution.code: caution.doubt for caution in cautions_of_scene(scene)}


@pytest.mark.parametrize(
    ("scene", "key", "value", "code"),
    [
        (WING, "bodies.skin.youngs_modulus", "70e9", "unit-of-youngs-modulus"),
        (WING, "bodies.skin.density", "2700.0", "unit-of-density"),
        (WING, "bodies.body2.density", "2700.0", "unit-of-density"),
        (BRACKET, "bodies.bracket.youngs_modulus", "70e9", "unit-of-youngs-modulus"),
        (BRACKET, "bodies.bracket.density", "2700.0", "unit-of-density"),
    ],
)
def test_materials_of_a_scene_are_questioned(scene, key, value, code):
    (caution,) = cautions_of_scene(read_scene(scene, {key: value}))
    assert (caution.code, caution.doubt) == (code, True)
    assert caution.text.startswith(f"{key} = ")


def test_what_several_bodies_share_is_said_once():
    scene = read_scene(WING, {f"bodies.body{k}.density": "2700.0" for k in (2, 3, 4, 5)})
    assert [caution.text.split(" = ")[0] for caution in cautions_of_scene(scene)] == ["bodies.body2.density"]


def test_a_thickness_in_other_units_is_questioned():
    assert codes(read_scene(WING, {"bodies.skin.thickness": "1.5e-3"})) == {"unit-of-thickness": False}
    assert codes(read_scene(WING, {"bodies.skin.thickness": "1500.0"})) == {"unit-of-thickness": False}


def pendulum(dimension: int, units: str, gravity: float, **bodies: Any) -> Scene:
    """A body between O and P, a quarter of a metre apart, in the units."""
    size = 250.0 if units == "mm-t-s" else 0.25
    rest = (0.0,) * (dimension - 2)
    pin = Revolute if dimension == 2 else Spherical
    return Scene(
        units=units,  # type: ignore[arg-type]
        dimension=dimension,  # type: ignore[arg-type]
        points={
            n: Point(**dict(zip("xyz", (x, 0.0, *rest), strict=False))) for n, x in {"O": 0.0, "P": size, "Q": size / 2}.items()
        },
        bodies=bodies,
        joints={f"{name}{point}": pin(bodies=(name, "ground"), point=point) for name in bodies for point in "OP"},
        loads={"weight": (Gravity if dimension == 2 else SpatialGravity)(acceleration=(0.0, -gravity, *rest))},
    )


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(
    ("units", "gravity", "meant"),
    [("mm-t-s", 9.81, "9810 mm/s^2"), ("mm-t-s", 10.0, "9810 mm/s^2"), ("m-kg-s", 9810.0, "9.81 m/s^2")],
)
def test_the_gravity_of_other_units_is_questioned(dimension, units, gravity, meant):
    (caution,) = cautions_of_scene(pendulum(dimension, units, gravity))
    assert (caution.code, caution.doubt) == ("unit-of-gravity", gravity == 9.81)
    assert caution.text.endswith(f"that of the earth is {meant}.")


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(
    ("units", "gravity"), [("mm-t-s", 9810.0), ("m-kg-s", 9.81), ("m-kg-s", 1.62), ("m-kg-s", 274.0), ("mm-t-s", 3720.0)]
)
def test_gravity_of_the_earth_and_elsewhere_is_not(dimension, units, gravity):
    assert cautions_of_scene(pendulum(dimension, units, gravity)) == []


@pytest.mark.parametrize("dimension", [2, 3])
def test_rods_and_rigid_bodies_are_questioned(dimension):
    """An area in mm^2 among metres, a mass in kg and an inertia in kg m^2 among tonnes and millimetres."""
    rod = Rod if dimension == 2 else SpatialRod
    fat = rod(between=("O", "P"), area=100.0, density=7850.0)
    assert codes(pendulum(dimension, "m-kg-s", 9.81, rod=fat)) == {"unit-of-area": False}
    slim = rod(between=("O", "P"), area=1e-4, density=7850.0)
    assert codes(pendulum(dimension, "m-kg-s", 9.81, rod=slim)) == {}
    moments = 1e-2 if dimension == 2 else (1e-2, 1e-2, 1e-2)
    kind: Any = Rigid if dimension == 2 else SpatialRigid
    assert codes(pendulum(dimension, "mm-t-s", 9810.0, link=kind(mass=500.0, inertia=moments, center="Q"))) == {
        "unit-of-mass": False
    }
    assert codes(pendulum(dimension, "mm-t-s", 9810.0, link=kind(mass=5e-4, inertia=moments, center="Q"))) == {}
    large = 1e6 if dimension == 2 else (1e6, 1e6, 1e6)
    assert codes(pendulum(dimension, "mm-t-s", 9810.0, link=kind(mass=5e-4, inertia=large, center="Q"))) == {
        "unit-of-inertia": False
    }


# --- preprocessing --------------------------------------------------------------------------------------------------------------


def test_the_questions_are_asked_when_a_model_is_built(tmp_path, monkeypatch, capsys):
    def build(modulus: str) -> str:
        (tmp_path / "frame.toml").write_text(BENT.replace("2e11", modulus))
        monkeypatch.setattr(sys, "argv", ["ffrf-preprocess", str(tmp_path / "frame.toml")])
        with pytest.raises(SystemExit):
            main()
        return capsys.readouterr().err

    assert "2e11" in BENT
    assert build("2e11") == ""
    assert "warning: frame.youngs_modulus_steel = 2e+17 Pa: no material has that." in build("2e17")
