"""The wing with a thickness and a width of every element: 60 design variables of one reduced model, three ways; and groups of elements."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from preprocessing import build
from preprocessing.elements.section import distribute
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.sensitivity.preparation import values_of
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.design_point import DesignPoint, rates_at
from toolkit.reduced_model.file import load, save
from toolkit.scene.scene import Scene

WING = Path(__file__).parents[2] / "models" / "morphing_wing"
SHORT = {"solver.end_time": "0.4", "solver.step": "0.05", "loads.drive.curve.duration": "0.4"}
NAMES = [f"bodies.skin.{quantity}_{k}" for quantity in ("thickness", "width") for k in range(30)]
AGREEMENT = 1e-9
"""Of exact methods, relative to the largest derivative of the response by a variable of the same kind: round-off of the wing's states."""


def write_wing(folder: Path, old: str, new: str) -> Path:
    """The wing's project with a change of its skin file, built; its scene declares no design variables."""
    for name in ("high_speed.dat", "low_speed.dat"):
        shutil.copy(WING / name, folder / name)
    text, scene = (WING / "skin.toml").read_text(), (WING / "scene.toml").read_text()
    assert old in text
    (folder / "skin.toml").write_text(text.replace(old, new))
    (folder / "scene.toml").write_text(scene[: scene.index("[design]")] + scene[scene.index("[responses]") :])
    save(build(folder / "skin.toml"), folder / "skin.h5")
    return folder / "scene.toml"


@pytest.fixture(scope="module")
def wing(tmp_path_factory) -> Scene:
    folder = tmp_path_factory.mktemp("elements")
    return read_scene(write_wing(folder, 'clamp = "F"', 'separate = ["thickness", "width"]\nclamp = "F"'), SHORT)


@pytest.fixture(scope="module")
def exact(wing):
    return gradients_by("direct", wing, NAMES, "transient").gradients


def largest(slopes: dict[str, float], name: str) -> float:
    """Largest derivative by a variable of the same kind."""
    kind = name.rpartition("_")[0]
    return max(abs(slope) for other, slope in slopes.items() if other.startswith(kind))


def test_adjoint_equals_direct_for_every_thickness_and_width(wing, exact):
    other = gradients_by("adjoint", wing, NAMES, "transient").gradients
    for response, slopes in exact.items():
        assert len(slopes) == 60
        for name, slope in slopes.items():
            assert abs(slope - other[response][name]) < AGREEMENT * largest(slopes, name), (response, name)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_complex_step_in_all_of_them_equals_direct(wing, exact, seed):
    """One complex run along a random direction judges all 60 at once: errors of any of them would have to cancel in both directions."""
    sizes = {name: 1.5 if "thickness" in name else 1000.0 for name in NAMES}
    along = dict(zip(NAMES, np.random.default_rng(seed).normal(size=len(NAMES)), strict=True))
    stepped = wing
    for name in NAMES:
        stepped = stepped.with_number(name, sizes[name] + 1e-30j * along[name] * sizes[name])
    for response, value in values_of(stepped, "transient").items():
        parts = [slope * along[name] * sizes[name] for name, slope in exact[response].items()]
        assert abs(np.imag(value) / 1e-30 - sum(parts)) < AGREEMENT * np.abs(parts).max(), response


def test_the_same_change_of_all_elements_is_a_change_of_the_whole_skin(wing, exact):
    whole = gradients_by("direct", read_scene(WING / "scene.toml", SHORT), ["t_w", "bodies.skin.width"], "transient").gradients
    for response, slopes in exact.items():
        for kind, name in (("thickness", "t_w"), ("width", "bodies.skin.width")):
            parts = [slope for path, slope in slopes.items() if kind in path]
            # two models of different round-off, which the states of a full skin carry on with 1e-9
            assert abs(sum(parts) - whole[response][name]) < 1e-8 * max(abs(sum(parts)), np.abs(parts).max())


def test_another_thickness_of_every_element_needs_no_new_preprocessing(wing):
    """An optimiser's step: the polynomials against a model that is built afresh, to round-off of contractions."""
    values = {f"thickness_{k}": 1.5 + 0.02 * k for k in range(30)} | {"width_7": 800.0}
    fresh = build(wing.directory / "skin.toml", values=values).invariants
    moved = DesignPoint(load(wing.directory / "skin.h5"), values).invariants()
    for name, value in vars(fresh).items():
        np.testing.assert_allclose(getattr(moved, name), value, rtol=0, atol=1e-13 * np.abs(value).max())


def test_the_uniform_parameter_is_gone_where_every_element_has_its_own(wing):
    with pytest.raises(InputError, match=r"unknown design variable 'bodies\.skin\.thickness'.*thickness_0 \.\.\. .*thickness_29"):
        wing.design_variables(["bodies.skin.thickness"])


def test_a_group_has_its_own_thickness_and_the_rest_keeps_the_body_s(tmp_path):
    path = write_wing(tmp_path, "[interface_points]", "[groups.nose]\nelements = [10, 14]\nthickness = 1.2\n\n[interface_points]")
    model = load(path.with_name("skin.h5"))
    assert (model.nominal["thickness"], model.nominal["thickness_nose"]) == (1.5, 1.2)
    rates = [rates_at(DesignPoint(model), "stress_operator", {name: 0}) for name in ("thickness", "thickness_nose")]
    elements = [set(model.stress.element[each.entry // model.n_f]) for each in rates]
    assert elements == [set(range(10)) | set(range(15, 30)), set(range(10, 15))]


def test_a_tangent_that_leads_to_no_possible_stiffness_is_refused(tmp_path):
    """1 mm of a bump is nothing to the shape, but stretches the inextensible skin to first order."""
    bump = "[shape.bump]\narc_length = 140.0\nhalf_width = 30.0\n\n[interface_points]"
    model = load(write_wing(tmp_path, "[interface_points]", bump).with_name("skin.h5"))
    with pytest.raises(InputError, match=r"'bump' .* is fixed at 0: .* extrapolation = \"first-order\""):
        DesignPoint(model, {"bump": 1.0}).invariants()
    with pytest.raises(InputError, match=r"tangent in bump, the stiffness .* no longer positive definite.*craig-bampton"):
        DesignPoint(model, {"bump": 1.0}, first_order=True).invariants()
    DesignPoint(model, {"bump": 0.01}, first_order=True).invariants()


@pytest.mark.parametrize(
    ("elements", "words"),
    [((3, 30), "count from 0 to 29"), ((9, 4), "first and the last"), ((4, 6), "belongs to group 'nose' too")],
)
def test_groups_off_the_skin_or_in_each_other_are_refused(elements, words):
    class Group:
        values = {"thickness": 1.0}  # noqa: RUF012 (as the schema's class has it)

        def __init__(self, first, last):
            self.elements = (first, last)

    body = dict.fromkeys(("youngs_modulus", "density", "thickness", "width", "damping_mass", "damping_stiffness"), 1.0)
    with pytest.raises(InputError, match=words):
        distribute(body, {"nose": Group(5, 8), "other": Group(*elements)}, (), 30)
