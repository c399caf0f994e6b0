"""Reduced beams in space and solids, whose elements are not kept: forces along them are in their verdict, by rules of slender bars."""

from __future__ import annotations

import numpy as np
import pytest

import ffrf
from preprocessing import build, save
from tests.models.spatial_chains import WHERE, chain_scene, save_chain
from toolkit.validity.bodies.bent_surfaces import bending

LENGTH, THICKNESS, WIDTH, YOUNG = 1.0, 0.01, 0.02, 1e9
SOFT, STIFF = (YOUNG * a * b**3 / 12 for a, b in ((WIDTH, THICKNESS), (THICKNESS, WIDTH)))
EULER = np.pi**2 * SOFT / 4


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """A straight cantilever along x, whose thinner side is y, by two bases."""
    found = {}
    full = tmp_path_factory.mktemp("full")
    save_chain(
        full, np.linspace([0.0, 0, 0], [LENGTH, 0, 0], 9), f'kind = "rectangle", thickness = {THICKNESS}, width = {WIDTH}', YOUNG
    )
    for kind in ("craig-bampton", "eigenmodes"):
        found[kind] = tmp_path_factory.mktemp(kind)
        basis = f'[basis]\nkind = "{kind}"\ncount = 4\n'
        (found[kind] / "frame.toml").write_text((full / "frame.toml").read_text() + basis)
        save(build(found[kind] / "frame.toml"), found[kind] / "beam.h5")
    return found


def loaded(folder, force):
    push = f'push = {{ type = "point-force", body = "beam", point = "tip", force = {[float(f) for f in force]} }}'
    run = ffrf.compile(chain_scene(folder, 'frame = "grounded"', f"[loads]\n{push}\n[responses]\n{WHERE}")).statics()
    return run, bending(run.solution, "beam")


@pytest.mark.parametrize("part", [0.02, 0.07, 0.3, 2.0])
def test_a_reduced_cantilever_has_the_load_of_euler(folders, part):
    run, found = loaded(folders["craig-bampton"], [-part * EULER, 0.0, 0.0])
    assert found.load == pytest.approx(part, rel=1e-9)
    assert [each.doubt for each in run.verdict.warnings if each.code == "critical-load"] == [part > 0.1] * (part > 0.05)


@pytest.mark.parametrize(("axis", "stiffness"), [(1, SOFT), (2, STIFF)])
@pytest.mark.parametrize("part", [0.1, -0.1, -4.0])
def test_its_deflections_are_off_by_what_the_force_along_it_does(folders, axis, stiffness, part):
    """2/5 of N L^2 / EI of the deflection by a force at the tip, whatever way it bends, which the rule for columns says with 1.3 % more."""
    force = np.array([-part * EULER, 0.0, 0.0])
    force[axis] = 2e-2 * EULER  # a deflection of 1.6 % of the length, which turns the bar for 0.6 of that
    run, found = loaded(folders["craig-bampton"], force)
    assert found.relative == pytest.approx(0.4 * abs(part) * EULER / stiffness, rel=0.02, abs=0.013)
    assert ("large-deformation" in run.verdict.codes) == (found.relative > 0.05)


@pytest.mark.parametrize("part", [0.02, 0.07, 0.3, 2.0])
def test_a_basis_without_stretch_has_it_too(folders, part):
    """By the force of the load itself, as no shape tells it."""
    run, found = loaded(folders["eigenmodes"], [-part * EULER, 0.0, 0.0])
    assert found.load == pytest.approx(part, rel=0.01)  # four modes bend a little less
    assert [each.doubt for each in run.verdict.warnings if each.code == "critical-load"] == [part > 0.1] * (part > 0.05)
