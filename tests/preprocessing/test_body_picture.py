"""The picture of a body: what it shows, that its words lie apart, and what it refuses."""

import json
import re
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from preprocessing.builders.frame_recipe import polygon_beam
from preprocessing.commands.body_picture import MOST_OF_A_KIND, body_shape, labels_at, marks_of, picture_of, save_picture
from preprocessing.commands.cli import app
from preprocessing.elements.section import Section
from toolkit.reduced_model.composition import KeptMass, PlaceOfNodes, read_composition
from toolkit.reduced_model.file import load, save
from toolkit.reduced_model.model import ReducedModel

MODELS = Path(__file__).parents[2] / "models"


def model_of(name: str) -> ReducedModel:
    """A model of every kind, with groups and a mass."""
    if name == "rod":
        return polygon_beam(np.array([[0, 0], [1, 0.2], [2, 0]]), Section(2e11, 7800.0, 0.02, 0.05), {"root": 0.0, "tip": 2.0})
    found = load(MODELS / name / "body.h5")
    here = found.interfaces["pin"].position[0, :, 0].tolist()
    groups = {f"$\\frac{{{k}": PlaceOfNodes([x + 0.1 * k for x in here], 7) for k in range(MOST_OF_A_KIND + 3)}
    kept = replace(
        read_composition({}, found.dimension), nodes=9, groups=groups, masses=[KeptMass(1e-6, here, 2, "MASS, line 4")]
    )
    return replace(found, composition=kept.attributes())


@pytest.mark.parametrize("name", ["rod", "bracket", "spatial_bracket"])
def test_words_lie_apart_and_within_the_picture(name):
    model = model_of(name)
    figure = picture_of(model, "arm")
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in [*figure.texts, *figure.legends[0].get_texts()]]
    sheet = figure.bbox
    assert len(boxes) > 5
    for box in boxes:
        assert sheet.x0 <= box.x0 < box.x1 <= sheet.x1
        assert sheet.y0 <= box.y0 < box.y1 <= sheet.y1
    assert not [pair for pair in combinations(boxes, 2) if pair[0].overlaps(pair[1])]
    told = [text.get_text() for text in figure.legends[0].get_texts()]
    marks, _ = marks_of(model)
    assert all(re.match(rf"{number}  .*\n.*\(", text) for number, text in zip(range(1, len(marks) + 1), told, strict=False))
    assert name == "rod" or "and 3 more groups" in told


def test_all_axes_have_one_scale_and_the_marks_are_where_the_places_are():
    flat = picture_of(model_of("bracket"), "arm").axes[0]
    assert flat.get_aspect() == 1.0
    assert flat.get_xlabel() == "x in mm"
    solid = picture_of(model_of("spatial_bracket"), "arm").axes[0]
    widths = np.array([np.ptp(limits) for limits in (solid.get_xlim(), solid.get_ylim(), solid.get_zlim())])
    np.testing.assert_allclose(solid._box_aspect / widths, (solid._box_aspect / widths)[0])
    shown = {
        tuple(np.round([float(x[0]) for x in each._offsets3d], 6)) for each in solid.collections if hasattr(each, "_offsets3d")
    }
    assert (90.0, 0.0, 60.0) in {tuple(np.round(place, 3) + 0.0) for place in shown}


def test_the_surface_of_a_solid_and_the_outline_of_a_plate_are_those_of_the_body():
    solid, plate = (body_shape(model_of(name)) for name in ("spatial_bracket", "bracket"))
    volume = np.einsum("ti,ti->", solid.triangles[:, 0], np.cross(solid.triangles[:, 1], solid.triangles[:, 2])) / 6
    assert volume == pytest.approx(30939.3, rel=2e-3)  # of the curved elements
    x, y = np.stack(plate.lines)[:, :, 0], np.stack(plate.lines)[:, :, 1]
    assert [x.min(), x.max(), y.min(), y.max()] == pytest.approx([-20.0, 133.0, -20.0, 20.0], abs=0.01)


def test_numbers_that_would_overlap_share_a_frame():
    found = labels_at([(100.0, 100.0), (300.0, 100.0), (101.0, 103.0), (112.0, 100.0)], 1000.0)
    assert [(each.text, each.place) for each in found] == [("1, 3, 4", (106.0, 106.0)), ("2", (306.0, 106.0))]
    (one,) = labels_at([(100.0, 100.0)] * 9, 120.0)
    assert one.text == "1-9"
    assert one.place[0] + one.width <= 120.0


FRAME = """units = "m-kg-s"
clamp = ["A"]
nodes = { A = [0, 0, 0], B = [0, 0, 2] }
beams = [{ from = "A", to = "B", elements = 2, section = "tube" }]
interface_points = { tip = { node = "B" } }
sections = { tube = { kind = "tube", material = "steel", diameter = 0.1, wall = 0.01 } }
materials = { steel = { youngs_modulus = 210e9, density = 7800.0, poisson_ratio = 0.3 } }
"""


def test_the_command_draws_a_picture_and_replaces_its_own_alone(tmp_path):
    (tmp_path / "frame.toml").write_text(FRAME)
    words, picture = [str(tmp_path / "frame.toml"), "--picture"], tmp_path / "frame.png"
    for _ in ("built", "up to date"):
        done = CliRunner().invoke(app, [*words, str(picture), "--json"])
        assert json.loads(done.stdout)["picture"] == str(picture)
        with Image.open(picture) as image:
            assert image.size == (1650, 960)
            assert len(image.convert("RGB").getcolors(100_000)) > 50
    picture.write_bytes(b"a photograph")
    for name, message in {
        "frame.png": "this program has not drawn it. Name another file, or replace it with --overwrite.",
        "frame.jpg": "does not end in .png. Name a picture, for example --picture body.png.",
    }.items():
        done = CliRunner().invoke(app, [*words, str(tmp_path / name)])
        assert done.exit_code == 1
        assert message in done.stderr
    assert picture.read_bytes() == b"a photograph"
    assert CliRunner().invoke(app, [*words, str(picture), "--overwrite"]).exit_code == 0
    both = CliRunner().invoke(app, [*words, str(picture), "--extrude", str(tmp_path / "solid.msh")])
    assert "--extrude builds none. Leave one of them out." in both.stderr


def test_names_in_letters_that_the_font_lacks_are_drawn_without_a_warning(tmp_path):
    rod = model_of("rod")
    rod = replace(rod, interfaces={"\u6f22\u5b57": rod.interfaces["tip"]}, composition={})
    save_picture(rod, "rod", tmp_path / "rod.png")
    save(rod, tmp_path / "rod.h5")
    assert (tmp_path / "rod.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
