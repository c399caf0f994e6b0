"""Designs that nobody differentiated by, or that mean two things at once, are refused by name; zeros that mean something are not."""

from __future__ import annotations

import numpy as np
import pytest

from preprocessing import build
from tests.reduced_model.test_element_variables import WING, write_wing
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.file import save
from toolkit.scene.resolution import loaded
from toolkit.system.system import compile_scene

CRAIG_BAMPTON = """[basis]
kind = "craig-bampton"
count = 4

[interface_points]"""


@pytest.fixture(scope="module")
def following(tmp_path_factory):
    """The wing with shapes that follow the design and the place of C, which is given by its x."""
    folder = tmp_path_factory.mktemp("following")
    path = write_wing(folder, "[interface_points]", CRAIG_BAMPTON)
    skin = folder / "skin.toml"
    skin.write_text(skin.read_text().replace("C = { node = 10 }", 'C = { x = 72.0, side = "upper" }'))
    save(build(skin), folder / "skin.h5")
    return path


def test_one_number_under_two_names_is_refused():
    with pytest.raises(InputError, match=r"'t_w' and 'bodies\.skin\.thickness' are the same number"):
        read_scene(WING / "scene.toml").design_variables(["t_w", "bodies.skin.thickness"])


def test_two_points_at_an_interface_that_the_shapes_follow_cannot_move(following):
    text = following.read_text().replace("[points]", '[points]\nC2 = { body = "skin", interface = "C" }')
    (following.parent / "two.toml").write_text(text)
    scene = read_scene(following.parent / "two.toml")
    with pytest.raises(InputError, match=r"points\.C and points\.C2 sit at the same interface point"):
        compile_scene(scene, ["points.C.arc_length"])


def test_a_written_place_that_the_shape_would_move_has_no_derivative_by_it(following):
    place = float(read_scene(following).number("points.C.arc_length"))
    scene = read_scene(following, {"points.C": f'{{ body = "skin", interface = "C", arc_length = {place!r} }}'})
    compile_scene(scene, ["bodies.skin.thickness", "points.C.arc_length"])
    with pytest.raises(InputError, match=r"interface point 'C', which the shape moves along the skin"):
        compile_scene(scene, ["bodies.skin.chord"])


def test_a_differentiated_basis_is_fixed_at_its_design_unless_the_tangent_is_wanted(following):
    with pytest.raises(InputError, match=r"'thickness' .* is fixed at 1\.5"):
        compile_scene(read_scene(following, {"bodies.skin.thickness": "1.6"}))
    scene = read_scene(following, {"bodies.skin.thickness": "1.6", "bodies.skin.extrapolation": "first-order"})
    assert loaded(scene).extrapolated() == {"skin": ["thickness"]}
    compile_scene(scene)


def test_a_grounded_body_about_mean_axes_is_refused(tmp_path):
    free = CRAIG_BAMPTON.replace('"craig-bampton"', '"eigenmodes"\nboundary = "free"')
    path = write_wing(tmp_path, "[interface_points]", free)
    with pytest.raises(InputError, match=r'floats about mean axes.*frame = "moving"'):
        compile_scene(read_scene(path))


@pytest.mark.parametrize("name", ["damping_mass", "damping_stiffness", "bump"])
def test_parameters_that_are_zero_are_differentiated(tmp_path, name):
    bump = "[shape.bump]\narc_length = 60.0\nhalf_width = 30.0\n\n[interface_points]"
    scene = read_scene(write_wing(tmp_path, "[interface_points]", bump), {"solver.end_time": "0.2"})
    path = f"bodies.skin.{name}"
    direct, stepped = (gradients_by(method, scene, [path], "transient").gradients for method in ("direct", "complex-step"))
    for response, slopes in direct.items():
        # a damping ratio of the slow motion acts 1e-6 of the value: then round-off of the value is what remains
        assert slopes[path] == pytest.approx(stepped[response][path], rel=1e-7)
    assert np.any([slopes[path] != 0 for slopes in direct.values()])


def test_negative_heights_are_no_mistake_but_negative_thickness_and_damping_are():
    for name, words in (("thickness", "must be a positive number"), ("damping_mass", "must be zero or positive")):
        with pytest.raises(InputError, match=words):
            compile_scene(read_scene(WING / "scene.toml", {f"bodies.skin.{name}": "-1.0"}))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"thickness_05": 2.0}, "has no parameter 'thickness_05'"),
        ({"thickness_5": -2.0}, "'thickness_5' cannot be -2"),
        ({"thickness_5": float("nan")}, "'thickness_5' cannot be nan"),
        ({"thickness_30": 2.0}, "has no parameter 'thickness_30'"),
        ({"thickness_nose": 2.0}, "has no parameter 'thickness_nose'"),
    ],
)
def test_parameters_of_single_elements_are_checked(tmp_path, values, words):
    path = write_wing(tmp_path, 'clamp = "F"', 'separate = ["thickness"]\nclamp = "F"')
    with pytest.raises(InputError, match=words):
        build(path.with_name("skin.toml"), values=values)


def test_a_group_without_a_quantity_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"groups\.nose: a group needs a quantity"):
        write_wing(tmp_path, "[interface_points]", "[groups.nose]\nelements = [1, 5]\n\n[interface_points]")
