"""What a basis of few shapes does to frequencies, against all nodal coordinates."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ffrf
from preprocessing import build
from preprocessing.builders.frame_recipe import polygon_beam
from preprocessing.reduction.basis import BasisChoice
from tests.frames.test_cut_bodies import EI, SECTION
from tests.models.solid_pieces import bar_scene, save_bar, write_bar
from toolkit.analyses.modes import solve_modes, undeformed
from toolkit.reduced_model.file import load, save
from toolkit.scene.resolution import loaded
from toolkit.system.system import compile_scene
from toolkit.validity.bodies.few_shapes import left_out, raised_at_most, raised_by_grips

NODES = np.column_stack([np.linspace(0, 1, 13), np.zeros(13)])
SCENE = """units = "m-kg-s"
points.hub = { body = "beam", interface = "hub" }
points.tip = { body = "beam", interface = "tip" }
bodies.beam = { type = "flexible", model = "beam.h5"BODY }
responses.f1 = { type = "frequency" }
responses.f2 = { type = "frequency", number = 2 }
"""
PIN = 'joints.pin = { type = "revolute", bodies = ["beam", "ground"], point = "POINT" }\n'
FEW = [
    BasisChoice("static", derivative="frozen"),
    *(BasisChoice("craig-bampton", count=count, derivative="frozen") for count in (0, 2)),
]


def scene(folder: Path, basis: BasisChoice, body: str, more: str = ""):
    folder = folder / f"{basis.kind}-{basis.count}"
    folder.mkdir(exist_ok=True)
    beam = polygon_beam(NODES, SECTION, {"hub": 0.0, "tip": 1.0}, basis=basis, rotary_inertia=False)
    save(beam, folder / "beam.h5")
    (folder / "scene.toml").write_text(SCENE.replace("BODY", body) + more)
    return ffrf.read_scene(folder / "scene.toml")


def said(found) -> list:
    return [each for each in found.warnings if each.code == "left-out-shapes"]


@pytest.mark.parametrize(
    ("body", "more"),
    [
        (', frame = "grounded"', ""),
        (', frame = "grounded"', PIN.replace("POINT", "tip")),
        ("", PIN.replace("POINT", "hub")),
        ("", ""),
        (', frame = "grounded", thickness = 0.05, density = 700.0', ""),
    ],
)
def test_frequencies_are_too_high_by_no_more_than_is_told(tmp_path, body, more):
    """Of bodies that are held in any way, or not at all, and at other numbers; half as much of what is told is true at least, where it
    is much: the bound is no wild guess."""
    exact = solve_modes(undeformed(compile_scene(scene(tmp_path, BasisChoice("full"), body, more)))).frequencies
    worst = 0.0
    for basis in FEW:
        of_few = scene(tmp_path, basis, body, more)
        found = solve_modes(undeformed(compile_scene(of_few)))
        (known,) = left_out(loaded(of_few))
        seen = found.frequencies > 1e-6 * found.frequencies.max()
        true = found.frequencies[seen] / exact[: len(seen)][seen] - 1
        told = np.array([raised_at_most(each, known.slowest) for each in found.frequencies[seen]])
        assert np.all(true < told)
        worst = max(worst, float((true[told < 3] / told[told < 3]).max()))
        (caution,) = said(found.verdict)
        assert f"from {known.slowest:.4g} 1/s on" in caution.text
        assert not caution.doubt  # of all modes that there are
    assert worst > 0.5


def test_the_second_frequency_of_a_cantilever_without_modes_is_a_doubt(tmp_path):
    run = ffrf.compile(scene(tmp_path, BasisChoice("craig-bampton", count=0), ', frame = "grounded"')).statics()
    full = ffrf.compile(scene(tmp_path, BasisChoice("full"), ', frame = "grounded"')).statics()
    assert run.values["f2"] / full.values["f2"] > 1.5
    (caution,) = said(run.verdict)
    assert caution.doubt
    assert "f1 by up to 1.2%, f2 by up to" in caution.text
    assert not said(full.verdict)


def test_a_list_of_modes_is_doubted_as_responses_are_and_names_each_that_is_wrong(tmp_path):
    model = ffrf.compile(scene(tmp_path, BasisChoice("craig-bampton", count=0), ', frame = "grounded"'))
    first, two = (model.modes(count=count).verdict for count in (1, 2))
    (response,), (listed,) = (said(each) for each in (model.statics().verdict, two))
    assert not any(each.doubt for each in said(first))  # 1.2 % at most
    assert listed.doubt
    assert listed.text == response.text.replace("f1 by", "mode 1 by").replace("f2 by", "mode 2 by")


def test_eigenmodes_are_exact_alone_and_too_stiff_where_joints_pull_by_what_is_told(tmp_path):
    """Modes of the clamped body are its own; a joint at its tip bends it in all of them."""
    basis, full = BasisChoice("eigenmodes", count=4), BasisChoice("full")
    alone, exact = (ffrf.compile(scene(tmp_path, each, ', frame = "grounded"')).statics() for each in (basis, full))
    assert not said(alone.verdict)
    assert alone.values["f2"] == pytest.approx(exact.values["f2"], rel=1e-6)  # the round-off of so stiff a pencil
    pin = PIN.replace("POINT", "tip")
    few, exact = (ffrf.compile(scene(tmp_path, each, ', frame = "grounded"', pin)) for each in (basis, full))
    (caution,) = said(few.modes(count=3).verdict)
    assert not caution.doubt
    assert "joints or springs hold beam at tip, which moves in shapes that its basis leaves out" in caution.text
    true = few.modes(count=3).frequencies / exact.modes(count=3).frequencies - 1
    found = raised_by_grips(few.statics().solution, dict(zip("abc", few.modes(count=3).frequencies, strict=True)), slowest(few))
    assert [*found.values()] == pytest.approx(true, rel=0.05)
    assert f"mode 2 by about {found['b']:.1%}, mode 3 by about {found['c']:.1%}" in caution.text


def slowest(model) -> dict[str, float]:
    (known,) = left_out(loaded(model.scene))
    return {known.body: known.slowest}


@pytest.mark.parametrize(("count", "doubted"), [(2, True), (8, True), (20, False)])
def test_free_modes_that_a_clamp_holds_are_doubted_by_their_size(tmp_path, count, doubted):
    """They converge as slowly as the inverse of their number, though all that are left out are far faster."""
    clamp, few = PIN.replace("POINT", "hub").replace("revolute", "rigid"), BasisChoice("eigenmodes", boundary="free", count=count)
    model = ffrf.compile(scene(tmp_path, few, "", clamp))
    run = model.statics()
    true = run.values["f1"] / (3.5160153 / (2 * np.pi) * np.sqrt(EI / (SECTION.density * SECTION.width * SECTION.thickness))) - 1
    found = raised_by_grips(run.solution, {"f1": run.values["f1"]}, slowest(model))
    assert found["f1"] == pytest.approx(true, rel=0.1)
    assert any(each.doubt for each in said(run.verdict)) == doubted


def test_a_bar_that_swings_is_exact_in_few_modes_and_trusted(tmp_path):
    few = BasisChoice("eigenmodes", boundary="free", count=6)
    weight = 'loads.g = { type = "gravity", acceleration = [0.981, 0.0] }\n'
    path = scene(tmp_path, few, "", PIN.replace("POINT", "hub") + weight)
    run = ffrf.compile(path.model_copy(update={"responses": {"f1": path.responses["f1"]}})).statics()
    assert run.values["f1"] == pytest.approx(np.sqrt(1.5 * 0.981) / (2 * np.pi), rel=1e-3)  # it bends a little
    assert run.verdict.trusted


def test_free_modes_of_a_free_body_are_exact_and_not_doubted(tmp_path):
    """Against all coordinates, of one frame; a joint at a point that shapes move ends that."""
    found, few = [], BasisChoice("eigenmodes", boundary="free", count=6)
    for basis in (few, BasisChoice("full")):
        run = solve_modes(undeformed(compile_scene(scene(tmp_path, basis, ""))), 9)
        found.append(run.frequencies)
        assert not said(run.verdict)
    assert found[0][3:] == pytest.approx(found[1][3:], rel=1e-7)
    held = solve_modes(undeformed(compile_scene(scene(tmp_path, few, "", PIN.replace("POINT", "tip")))), 8)
    assert said(held.verdict)


def test_a_file_that_does_not_know_what_it_leaves_out_says_so(tmp_path):
    """One that an earlier version has written."""
    scene(tmp_path, FEW[1], ', frame = "grounded"')
    (path,) = tmp_path.glob("*/beam.h5")
    save(replace(load(path), left_out={}), path)
    (caution,) = said(ffrf.compile(ffrf.read_scene(path.parent / "scene.toml")).statics().verdict)
    assert "is not known: 'beam.h5' does not say what its basis leaves out. Build it again" in caution.text


def test_a_solid_in_pieces_knows_what_each_of_them_leaves_out(tmp_path):
    """Two pieces of a bar, cut in the scene or not, against the uncut bar with modes; the face between both makes some 1e-3 by itself."""
    asked = "[responses]\n" + "".join(f'f{k} = {{ type = "frequency", number = {k} }}\n' for k in (1, 4, 6))
    path = write_bar(tmp_path, 0)
    path.write_text(path.read_text().replace('basis.kind = "static"', 'basis = { kind = "craig-bampton", count = 12 }'))
    save(build(path), tmp_path / "bar.h5")
    fine = ffrf.compile(bar_scene(tmp_path, 'frame = "grounded"', asked)).statics().values
    slowest = save_bar(tmp_path, 2).left_out["interface"]
    for body in ('frame = "grounded"', 'frame = "grounded", frames = 2'):
        run = ffrf.compile(bar_scene(tmp_path, body, asked)).statics()
        for name, value in run.values.items():
            assert -2e-3 < value / fine[name] - 1 < raised_at_most(value, slowest) + 2e-3
        assert run.values["f6"] > 1.01 * fine["f6"]
        (caution,) = said(run.verdict)
        assert f"from {slowest:.4g} 1/s on" in caution.text
