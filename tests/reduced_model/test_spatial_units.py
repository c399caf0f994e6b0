"""Reduced models in space in other units: what preprocessing makes there, and the same model when they come back."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from preprocessing import build
from tests.models.spatial_cases import FRAME, write_models
from tests.scene_file.test_scene_units import arrays
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import LABELLED, factor
from toolkit.reduced_model.conversion import converted_model
from toolkit.reduced_model.dependence import scattered
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.file import load
from toolkit.reduced_model.model import ReducedModel

LENGTHS = ("thickness", "width", "diameter", "wall")


def millimetres() -> str:
    """The frame of the tests, its numbers written in mm, t, s."""
    by = {
        name: factor(LABELLED[label], "m-kg-s", "mm-t-s")
        for name, label in (("youngs_modulus", "stress"), ("density", "density"))
    }
    by |= dict.fromkeys(LENGTHS, factor(LABELLED["length"], "m-kg-s", "mm-t-s"))
    text = FRAME.replace("m-kg-s", "mm-t-s")
    for name, scale in by.items():
        text = re.sub(rf"{name} = ([\d.]+)", lambda found, name=name, scale=scale: f"{name} = {float(found[1]) * scale!r}", text)
    nodes = re.search(r"^nodes = .*$", text, re.MULTILINE)[0]
    scaled = re.sub(r"-?\d+\.\d+", lambda found: repr(1000 * float(found[0])), nodes)
    return text.replace(nodes, scaled)


def slope_of(model: ReducedModel, item: str, k: int) -> np.ndarray:
    """Derivative of an item by one parameter, flattened; zeros are not stored, be they exact or by round-off."""
    return scattered(*model.derivatives[item].by(k), model.item(item).size)


def test_a_converted_frame_is_the_one_that_preprocessing_makes_in_the_other_units(tmp_path):
    """Its rotations in rad included: the basis consists of nodal coordinates."""
    for name, text in (("m", FRAME), ("mm", millimetres())):
        (tmp_path / f"{name}.toml").write_text(text)
    found, made = converted_model(build(tmp_path / "m.toml"), "mm-t-s"), build(tmp_path / "mm.toml")
    assert found.nominal == pytest.approx(made.nominal, rel=1e-14)
    assert found.nominal_units == made.nominal_units
    steps = {name: 1.1 * value for name, value in made.nominal.items() if name.startswith(("width", "thickness", "density"))}
    changed = [DesignPoint(replace(each, derivatives={}), steps).invariants() for each in (found, made)]
    plain = [
        arrays((replace(each, affine=None, derivatives=None), inv)) for each, inv in zip((found, made), changed, strict=True)
    ]
    slopes = [
        [slope_of(each, item, k) for item in made.derivatives for k in range(len(made.parameters))] for each in (found, made)
    ]
    for one, other in [*zip(*plain, strict=True), *zip(*slopes, strict=True)]:
        # round-off of sums beside the largest entry of each array
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-12 * np.abs(other).max(initial=0))


@pytest.mark.parametrize("name", ["frame", "solid"])
def test_there_and_back_is_the_same_model(name, tmp_path):
    write_models(tmp_path)
    model = load(tmp_path / f"{name}.h5")
    back = converted_model(converted_model(model, "mm-t-s"), "m-kg-s")
    for one, other in zip(arrays(back), arrays(model), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-14)  # two multiplications of each number, and 1 / 1e-3 is rounded


def test_a_model_without_its_surface_is_refused(tmp_path):
    write_models(tmp_path)
    with pytest.raises(InputError, match="without its mesh or surface"):
        converted_model(load(tmp_path / "frame.h5", ("affine",)), "mm-t-s")
