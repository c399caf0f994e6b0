"""Units of gradients: the labels of response and variable mean what their numbers do in every system of units."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.models.cases import write_models
from tests.models.every_number import SCENES
from tests.models.scenes import hanging_skin
from tests.models.spatial_cases import write_models as write_spatial_models
from tests.models.spatial_every_number import SCENES as SPATIAL_SCENES
from toolkit.files.gradient_units import (
    dimension_label,
    gradient_unit,
    gradient_units,
    number_dimension,
    per,
    response_dimension,
    variable_unit,
)
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.units import Dimension, factor
from toolkit.scene.scene import Scene

MODELS = Path(__file__).parents[2] / "models"
IN_SI = {
    "kg": 1.0, "t": 1e3, "m": 1.0, "mm": 1e-3, "s": 1.0, "N": 1.0, "Pa": 1.0, "MPa": 1e6, "J": 1.0, "mJ": 1e-3, "W": 1.0, "mW": 1e-3,
    "rad": 1.0, "1": 1.0,
}  # fmt: skip


def in_si(label: str) -> float:
    """What a label stands for in SI units: factors apart by spaces, each slash divides by what follows it, brackets hold together."""
    if " / " in label:
        above, _, below = label.partition(" / ")
        return in_si(above) / in_si(below.strip("()"))
    if "(" in label:
        return in_si(label.split("/", 1)[0]) / in_si(label.split("/", 1)[1].strip("()"))
    size = 1.0
    for k, part in enumerate(label.split("/")):
        for word in part.split():
            name, _, power = word.partition("^")
            size *= IN_SI[name] ** ((-1 if k else 1) * int(power or 1))
    return size


def scenes(folder: Path) -> list[Scene]:
    shipped = [read_scene(path) for path in sorted(MODELS.glob("*/scene.toml"))]
    return [*shipped, hanging_skin(), *(make(folder) for make in (*SCENES.values(), *SPATIAL_SCENES.values()))]


@pytest.mark.parametrize("system", ["mm-t-s", "m-kg-s"])
def test_every_label_stands_for_the_size_of_its_number(system, tmp_path):
    write_models(tmp_path)
    write_spatial_models(tmp_path)
    seen = set()
    for scene in scenes(tmp_path):
        for path in scene.available_paths():
            dimension = number_dimension(scene, path)
            assert in_si(dimension_label(dimension, system)) == pytest.approx(factor(dimension, system, "m-kg-s"), rel=1e-12), (
                path
            )
            if scene.units == system:
                label = variable_unit(scene, path)
                assert in_si(label) == pytest.approx(factor(dimension, system, "m-kg-s"), rel=1e-12), (path, label)
                seen.add(label)
            for name, response in scene.responses.items() if scene.units == system else ():
                own = factor(response_dimension(response), system, "m-kg-s") / factor(dimension, system, "m-kg-s")
                assert in_si(gradient_unit(scene, name, path)) == pytest.approx(own, rel=1e-12), (name, path)
    assert seen >= (
        {"mm", "MPa", "N mm", "t/mm^3", "mm/s^2"} if system == "mm-t-s" else {"N/m", "N s/m", "kg m^2", "rad/s", "N m/rad", "m/s"}
    )


def test_the_gradient_of_an_action_by_a_stiffness_is_no_action():
    scene = read_scene(MODELS / "slider_crank" / "scene.toml")
    assert gradient_unit(scene, "G", "k") == "J s / (N/m)"
    assert gradient_units(scene, {"G": ["c", "bodies.crank.inertia"]}) == {
        "G": {"c": "J s / (N s/m)", "bodies.crank.inertia": "J s / (kg m^2)"}
    }


def test_units_of_units():
    assert [per("MPa", "mm"), per("MPa", "N mm"), per("rad", ""), per("", "mm")] == ["MPa / mm", "MPa / (N mm)", "rad", "1 / mm"]
    assert dimension_label(Dimension(-1, 1, 2), "mm-t-s") == "1/MPa"
    assert dimension_label(Dimension(1, 0, -2), "m-kg-s") == "N/m"
    assert dimension_label(Dimension(0, 1, -2), "mm-t-s") == "mm/s^2"


def test_a_number_that_nobody_has_given_a_dimension_is_a_question_mark(monkeypatch):
    scene = read_scene(MODELS / "slider_crank" / "scene.toml")
    monkeypatch.setattr("toolkit.description.description.Description.quantity_of", lambda _self, _field: None)
    assert gradient_unit(scene, "G", "k") == "J s / ?"


def test_brackets_are_read_as_they_are_written():
    """Of this file's own reader."""
    assert in_si("J s / (N s/m)") == 1.0
    assert in_si("MPa / (t/mm^3)") == pytest.approx(1e6 / 1e12)
    assert re.match(r"1/\(N/m\)", dimension_label(Dimension(-1, 0, 2), "m-kg-s"))
    assert in_si("1/(N/mm)") == pytest.approx(1e-3)
