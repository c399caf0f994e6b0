"""The sections of beams in a reduced model are those of their description, at every design, in any units; older files are told apart."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from preprocessing.builders.build_model import build
from toolkit.foundation.errors import ModelFileError
from toolkit.reduced_model.conversion import converted_model
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.file import load, save

MODELS = Path(__file__).parents[2] / "models"
STEP = 1e-30
FRAME = """units = "m-kg-s"
dimension = {dimension}
shear = {shear}
clamp = ["A"]
nodes = {{ A = {A}, B = {B} }}
beams = [{{ from = "A", to = "B", section = "s", elements = 2 }}]
sections.s = {section}
materials.m = {{ youngs_modulus = 2e11, density = 7800.0, poisson_ratio = 0.3 }}
interface_points.B = {{ node = "B" }}
{basis}
"""
PLANE = {"dimension": 2, "A": [0.0, 0.0], "B": [1.0, 0.2]}
SPACE = {"dimension": 3, "A": [0.0, 0.0, 0.0], "B": [1.0, 0.2, 0.3]}
BAR = '{ kind = "rectangle", thickness = 0.02, width = 0.05, material = "m" }'
PIPE = '{ kind = "tube", diameter = 0.06, wall = 0.004, material = "m", shear_factor = 0.5 }'
FEW = '[basis]\nkind = "craig-bampton"\ncount = 2'


def bar(p) -> dict:
    """Closed forms of a rectangle that bends in the plane."""
    E, t, b = p["youngs_modulus_m"], p["thickness_s"], p["width_s"]
    return {
        "stress_per_strain": E,
        "axial_stiffness": E * t * b,
        "bending_stiffness": E * b * t**3 / 12,
        "shear_stiffness": 5 / 6 * t * b * E / (2 * (1 + p["poisson_ratio_m"])),
        "torsional_stiffness": 0.0,
        "mass_per_length": p["density_m"] * t * b,
    }


def pipe(p) -> dict:
    """Closed forms of a tube in space."""
    E, outer, inner = p["youngs_modulus_m"], p["diameter_s"], p["diameter_s"] - 2 * p["wall_s"]
    area, moment, shear = (
        np.pi / 4 * (outer**2 - inner**2),
        np.pi / 64 * (outer**4 - inner**4),
        E / (2 * (1 + p["poisson_ratio_m"])),
    )
    return {
        "stress_per_strain": E,
        "axial_stiffness": E * area,
        "bending_stiffness": E * moment,
        "shear_stiffness": 0.5 * shear * area,
        "torsional_stiffness": 2 * shear * moment,
        "mass_per_length": p["density_m"] * area,
    }


CASES = {
    "bar": ({**PLANE, "section": BAR, "shear": "true", "basis": ""}, bar),
    "bar of few shapes": ({**PLANE, "section": BAR, "shear": "true", "basis": FEW}, bar),
    "pipe": ({**SPACE, "section": PIPE, "shear": "true", "basis": ""}, pipe),
    "pipe of few shapes": ({**SPACE, "section": PIPE, "shear": "true", "basis": FEW}, pipe),
}


@pytest.fixture(params=CASES, scope="module")
def case(request, tmp_path_factory):
    content, closed = CASES[request.param]
    path = tmp_path_factory.mktemp("sections") / "frame.toml"
    path.write_text(FRAME.format(**content))
    save(build(path), path.with_suffix(".h5"))
    return load(path.with_suffix(".h5")), closed


def test_sections_are_those_of_the_description_and_follow_every_number(case):
    model, closed = case
    values = {**model.nominal, "youngs_modulus_m": 1.7e11, "density_m": 5000.0}
    for moved in model.parameters:
        start = (
            dict(model.nominal) if moved == "poisson_ratio_m" else values
        )  # by which there are derivatives, at the nominal design
        stepped = {**start, moved: start[moved] + STEP * 1j}
        design, expected = DesignPoint(model, stepped), closed(stepped)
        for name, value in expected.items():
            found = design.value(f"sections.{name}")
            np.testing.assert_allclose(found.real, np.real(value), rtol=1e-12)
            np.testing.assert_allclose(found.imag / STEP, np.imag(value) / STEP, rtol=1e-10, err_msg=f"{name} by {moved}")


def test_fibres_are_where_the_stress_is_told(case):
    """The surface of the description: both sides of the bar, eight places round the pipe."""
    model, _ = case
    distance = model.sections.fibre_distance
    if model.dimension == 2:
        np.testing.assert_allclose(distance[:, 0], -model.stress.fibre * 0.01, rtol=1e-12)
    else:
        np.testing.assert_allclose(np.linalg.norm(distance, axis=1), 0.03, rtol=1e-12)
        assert len(distance) == 2 * 8 * 2


def test_sections_in_other_units_are_the_same_beams(case):
    model, _ = case
    other, mine = converted_model(model, "mm-t-s").sections, model.sections
    scales = {
        "axial_stiffness": 1.0,
        "bending_stiffness": 1e6,
        "mass_per_length": 1e-6,
        "fibre_distance": 1e3,
        "stress_per_strain": 1e-6,
    }
    for name, scale in scales.items():
        np.testing.assert_allclose(getattr(other, name), scale * getattr(mine, name), rtol=1e-12)


def test_the_modulus_of_plane_strain_follows_poissons_ratio(tmp_path):
    """E / (1 - nu^2): skins that are kept from contracting along the span."""
    text = (MODELS / "morphing_wing" / "skin.toml").read_text()
    (tmp_path / "skin.toml").write_text(text.replace("poisson_ratio = 0.35", 'poisson_ratio = 0.35\nstate = "plane-strain"'))
    for name in ("high_speed.dat", "low_speed.dat"):
        (tmp_path / name).write_bytes((MODELS / "morphing_wing" / name).read_bytes())
    skin, nu = build(tmp_path / "skin.toml"), 0.35 + STEP * 1j
    found = DesignPoint(skin, {"poisson_ratio": nu}).value("sections.stress_per_strain")
    expected = skin.nominal["youngs_modulus"] / (1 - nu**2)
    np.testing.assert_allclose(found.real, expected.real, rtol=1e-12)
    np.testing.assert_allclose(found.imag, expected.imag, rtol=1e-10)


def with_version_2(path: Path, source: Path) -> Path:
    """A model as earlier versions wrote it."""
    path.write_bytes(source.read_bytes())
    with h5py.File(path, "a", libver="v110") as file:
        file.attrs["schema_version"] = 2
        for name in ("sections", "section_derivatives", "section_affine"):
            if name in file:
                del file[name]
        contents = [name for name in file.attrs["contents"].decode().splitlines() if not name.startswith("section_")]
        file.attrs["contents"] = np.bytes_("\n".join(contents).encode())
    return path


def test_a_solid_of_the_version_before_is_read(tmp_path):
    old = load(with_version_2(tmp_path / "body.h5", MODELS / "bracket" / "body.h5"))
    np.testing.assert_array_equal(old.invariants.stiffness, load(MODELS / "bracket" / "body.h5").invariants.stiffness)


@pytest.mark.parametrize("model", ["morphing_wing/skin.h5", "spinning_beam/frame.h5"])
def test_beams_of_the_version_before_are_refused_in_words(tmp_path, model):
    with pytest.raises(ModelFileError, match=r"reads version 3: it does not hold the sections of its beams\. Build it again"):
        load(with_version_2(tmp_path / "old.h5", MODELS / model))


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("axial_stiffness", lambda found: -found, r"sections/axial_stiffness holds numbers that are not positive"),
        ("axis", lambda found: found[1:], r"sections/\w+ has shape \(30,.*instead of \(29"),
        ("axis", lambda found: 0 * found, r"sections/axis runs along an element, across which it should lie"),
        ("shear_stiffness", lambda found: found - 1.0, r"sections/shear_stiffness holds negative numbers"),
    ],
)
def test_sections_that_no_beam_has_are_refused(tmp_path, name, change, words):
    path = tmp_path / "skin.h5"
    path.write_bytes((MODELS / "morphing_wing" / "skin.h5").read_bytes())
    with h5py.File(path, "a", libver="v110") as file:
        value = change(file[f"sections/{name}"][()])
        del file[f"sections/{name}"]
        file[f"sections/{name}"] = value
    with pytest.raises(ModelFileError, match=words):
        load(path)
