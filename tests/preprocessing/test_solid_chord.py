"""Solids whose frame goes through two interface points: against beams, and their derivatives against models built afresh."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from preprocessing import build
from tests.models.solid_bodies import DENSITY, MODULUS, WIDTH, box, compliance, frequencies, rectangle, write_body
from tests.preprocessing.test_frame_models import rate
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.file import load, save
from toolkit.reduced_model.model import Chord, ReducedModel, chord_of

pytestmark = pytest.mark.usefixtures("read_here")

LENGTH, HEIGHT = 1.0, 0.04
ON_CHORD = 'kind = "craig-bampton"\ncount = 2\nchord = ["hub", "tip"]'
MESHES = {
    "plane": lambda: rectangle("quad8", (20, 1), LENGTH, HEIGHT),
    "space": lambda: box("hexahedron20", (12, 1, 1), (LENGTH, WIDTH, HEIGHT)),
}


def body(folder: Path, where: str, basis: str = ON_CHORD, tie: str = "averaged", hub: str = "averaged", more: str = "") -> Path:
    """A bar from the origin along x that nothing clamps."""
    path = write_body(folder, MESHES[where](), basis, poisson_ratio=0.0, tie=tie, more=more)
    lines = path.read_text().split("\n")
    at = lines.index("[clamp]")
    del lines[at : at + 2]
    lines.insert(lines.index("[interface_points.hub]") + 1, f'tie = "{hub}"')
    path.write_text("\n".join(lines))
    return path


@pytest.mark.parametrize("where", MESHES)
@pytest.mark.parametrize("ties", [("averaged", "averaged"), ("rigid", "averaged"), ("averaged", "rigid"), ("rigid", "rigid")])
def test_a_bar_on_two_pins_bends_and_vibrates_as_a_beam(where, ties, tmp_path):
    save(build(body(tmp_path, where, hub=ties[0], tie=ties[1])), tmp_path / "body.h5")
    model = load(tmp_path / "body.h5")
    assert chord_of(model.reference_condition) == Chord("hub", "tip")
    first, second = (model.interfaces[name].here for name in ("hub", "tip"))
    assert np.abs(first[0][:, 1:]).max() == 0
    assert np.abs(second[0][1:, 1:]).max() < 1e-9  # of shapes of size one
    if model.dimension == 3:
        assert np.abs(first[1][0, 1:]).max() < 1e-9
    # rotation of an end under a couple there, L / 3 EI, with 1 / (G A_s L) for shear, of the order of (height / length)^2
    turn = compliance(model)[2 if model.dimension == 2 else 4, 2 if model.dimension == 2 else 4]
    assert turn == pytest.approx(LENGTH / (3 * MODULUS * WIDTH * HEIGHT**3 / 12), rel=1e-2)
    bending = (np.pi / LENGTH) ** 2 * np.sqrt(MODULUS * HEIGHT**2 / 12 / DENSITY) / (2 * np.pi)
    assert frequencies(model)[0] == pytest.approx(
        bending, rel=2e-2
    )  # shear, rotary inertia, and two modes beside the static ones


def responses(model: ReducedModel) -> np.ndarray:
    """What no choice of coordinates within the span changes: compliances of the tip, and frequencies."""
    return np.concatenate([1e7 * compliance(model).ravel(), frequencies(model)[:3]])


@pytest.mark.parametrize("tie", ["averaged", "rigid"])
def test_shapes_on_a_chord_that_a_shape_variable_turns_follow_it(tie, tmp_path):
    """Against central differences of models built afresh, of fourth order: the tip moves across the chord."""
    mesh = MESHES["space"]()
    field = np.zeros_like(mesh.nodes)
    field[:, 1], field[:, 2] = 0.3 * mesh.nodes[:, 0], mesh.nodes[:, 0] * (1 + mesh.nodes[:, 0])
    np.save(tmp_path / "bow.npy", field)
    path = body(tmp_path, "space", tie=tie, hub=tie, more='\n[shape_variables.bow]\nfield = "bow.npy"\n')
    model, step = build(path), 1e-2
    fresh = {k: responses(build(path, values={"bow": k * step})) for k in (-2, -1, 1, 2)}
    expected = (8 * (fresh[1] - fresh[-1]) - fresh[2] + fresh[-2]) / (12 * step)
    h = 1e-6  # of the model's own tangent, whose error of second order is far below
    found = (responses(tangent(model, h)) - responses(tangent(model, -h))) / (2 * h)
    scale = np.abs(fresh[1]).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-5 * scale)  # (1e-2)^4, and round-off over h
    assert np.abs(expected).max() > 1e-2 * scale


def tangent(model: ReducedModel, h: float) -> ReducedModel:
    """The model with all arrays moved along their derivatives by the shape variable."""
    items = {name: getattr(model.invariants, name) + h * rate(model, name, "bow") for name in ("stiffness", "second_moment")}
    points = {
        name: replace(
            point,
            position=point.position + h * rate(model, f"interfaces.{name}.position", "bow"),
            rotation=point.rotation + h * rate(model, f"interfaces.{name}.rotation", "bow"),
        )
        for name, point in model.interfaces.items()
    }
    return replace(model, invariants=replace(model.invariants, **items), interfaces=points)


def test_wrong_chords_of_solids_are_refused(tmp_path):
    for basis, message in (
        ('kind = "full"\nchord = ["hub", "tip"]', "a solid on a chord cannot have a basis of kind 'full'"),
        ('kind = "eigenmodes"\ncount = 3\nchord = ["hub", "tip"]', "a solid on a chord cannot have a basis of kind 'eigenmodes'"),
        ('kind = "static"\nchord = ["hub", "end"]', "basis.chord: there is no interface point 'end'; there are hub, tip"),
    ):
        with pytest.raises(InputError, match=message):
            build(body(tmp_path, "plane", basis))
    with pytest.raises(InputError, match="a body has its frame either on a chord or at a clamp"):
        build(write_body(tmp_path, MESHES["plane"](), ON_CHORD))
