"""skin.toml: what it may hold, and one message for every way in which it can be wrong."""

import re
from pathlib import Path

import pytest

from preprocessing.builders.skin_recipe import SkinRecipe
from toolkit.foundation.errors import InputError

EXAMPLE = (Path(__file__).parents[2] / "models" / "morphing_wing" / "skin.toml").read_text()


@pytest.fixture
def edited(tmp_path):
    """Write the example with one text replaced."""

    def write(old: str = "", new: str = "") -> Path:
        assert old in EXAMPLE
        path = tmp_path / "skin.toml"
        path.write_text(EXAMPLE.replace(old, new))
        return path

    return write


def test_example_is_read(edited):
    file = SkinRecipe.read(edited()).file
    assert (file.units, file.skin.elements, file.section.width, file.material.poisson_ratio) == ("mm-t-s", 30, 1000.0, 0.35)
    assert file.interface_points["C"].model_dump(exclude_none=True) == {"node": 10}


def test_damping_interface_points_and_spacing_may_be_left_out(edited):
    path = edited()
    path.write_text(EXAMPLE.split("[damping]")[0].replace('spacing = "equal"\n', "").replace("poisson_ratio = 0.35\n", ""))
    file = SkinRecipe.read(path).file
    assert (file.damping.mass, file.damping.stiffness, file.skin.spacing, file.interface_points) == (0, 0, "equal", {})


def test_whole_numbers_are_accepted_where_lengths_are_meant(edited):
    assert SkinRecipe.read(edited("chord = 550.0", "chord = 550")).file.airfoil.chord == 550


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "thickness = 1.5",
            "thicknes = 1.5",
            "section.thicknes: unknown key, did you mean 'thickness'; possible here: thickness, width. (line 20)",
        ),
        ("thickness = 1.5", "", "section.thickness: this key is missing; add it."),
        ("thickness = 1.5", "thickness = -1.5", "section.thickness: input should be greater than 0 (given: -1.5). (line 20)"),
        ("thickness = 1.5", "thickness = 0", "section.thickness: input should be greater than 0 (given: 0)."),
        ("thickness = 1.5", "thickness = inf", "section.thickness: input should be a finite number (given: inf)."),
        ("thickness = 1.5", 'thickness = "1.5"', "section.thickness: input should be a valid number (given: '1.5')."),
        ("elements = 30", "elements = 30.5", "skin.elements: input should be a valid integer (given: 30.5)."),
        ('side = "upper"', 'side = "top"', "skin.start.side: input should be 'upper' or 'lower' (given: 'top')."),
        ('units = "mm-t-s"', 'units = "mm"', "units: input should be 'mm-t-s' or 'm-kg-s' (given: 'mm')."),
        (
            "{ node = 10 }",
            "{ nod = 10 }",
            "interface_points.C.nod: unknown key, did you mean 'node'; possible here: node, arc_length, x, side.",
        ),
        (
            "{ node = 10 }",
            "{ node = 10, x = 3.0 }",
            "interface_points.C: give either node, or arc_length, or x with side (given: node, x)",
        ),
        ("{ node = 10 }", "{}", "interface_points.C: give either node, or arc_length, or x with side (given: nothing)"),
        ("{ node = 10 }", "{ node = -1 }", "interface_points.C.node: input should be greater than or equal to 0 (given: -1)."),
        (
            "[section]",
            "[profile]",
            "profile: unknown key; possible here: units, dimension, rotary_inertia, airfoil, skin, section",
        ),
        ("mass = 0.0", "mass = -1.0", "damping.mass: input should be greater than or equal to 0 (given: -1.0)."),
        (
            "thickness = 1.5",
            "thickness = 1e300",
            "section.thickness: numbers from 1e-20 to 1e+20 are valid; fix the exponent",
        ),
        (
            "thickness = 1.5",
            "thickness = 1e-30",
            "section.thickness: numbers from 1e-20 to 1e+20 are valid; fix the exponent",
        ),
        ('file = "high_speed.dat"', 'file = "a\\u0000b"', "airfoil.file: a file name cannot hold a zero byte"),
        ("poisson_ratio = 0.35", "poisson_ratio = 0.5", "material.poisson_ratio: input should be less than 0.5 (given: 0.5)."),
    ],
)
def test_wrong_key_is_named_with_what_would_be_right(edited, old, new, message):
    path = edited(old, new)
    with pytest.raises(InputError, match=re.escape(message)) as caught:
        SkinRecipe.read(path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize("name", ["a/b", "", " ", ".", "..", "a.b", "a\\u0000"])
def test_interface_names_that_no_file_or_path_can_hold_are_refused(edited, name):
    with pytest.raises(
        InputError, match=r"interface_points: this is no legal name of a point; use letters, digits and _ \(given: '"
    ):
        SkinRecipe.read(edited("C = {", f'"{name}" = {{'))


def test_byte_order_mark_is_skipped(edited):
    path = edited()
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert SkinRecipe.read(path).file.units == "mm-t-s"


def test_all_wrong_keys_are_reported_at_once(edited):
    path = edited("thickness = 1.5", "thickness = 0")
    path.write_text(path.read_text().replace("density = 2.7e-9", "density = 0"))
    with pytest.raises(InputError, match=r"(?s)section\.thickness.*material\.density"):
        SkinRecipe.read(path)


def test_file_that_is_missing_or_no_toml_is_named(tmp_path):
    with pytest.raises(InputError, match=r"none\.toml' cannot be read \(No such file or directory\)"):
        SkinRecipe.read(tmp_path / "none.toml")
    (tmp_path / "bad.toml").write_text("units = \n")
    with pytest.raises(InputError, match=r"bad\.toml' is not readable as TOML: Invalid value \(at line 1"):
        SkinRecipe.read(tmp_path / "bad.toml")
