"""Bodies of a bar of 4 x 1 x 0.5 m, 15600 kg, built of meshes in several formats, with the right place of their tip."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from preprocessing import build
from preprocessing.mesh.mesh_file import read_mesh
from tests.foreign_meshes.gmsh_files import written
from toolkit.foundation.errors import InputError

pytestmark = pytest.mark.usefixtures("read_here")

DATA = Path(__file__).parents[1] / "data" / "foreign_files" / "meshes"
BODY = """
units = "m-kg-s"
mesh = {{ file = "{file}" }}
material = {{ youngs_modulus = 210e9, density = 7800.0, poisson_ratio = 0.3 }}
clamp = {{ {clamp} }}
interface_points = {{ tip = {{ {tip} }} }}
basis = {{ kind = "static" }}
"""
BOXES = ("box = [0, 0, 0, 0, 1, 0.5]", 'box = [4, 0, 0, 4, 1, 0.5], tie = "rigid"')
BARS = {
    "voxels.vtk": (*BOXES, 15600.0, [4, 0.5, 0.25]),
    "partitioned_4.msh": ('group = "left"', 'group = "right"', 15600.0, [4, 0.5, 0.25]),
    "blanks.msh": ('group = "left side"', "group = \"right 'é' end\"", 15600.0, [4, 0.5, 0.25]),
    "negative_tags.msh": ('group = "left"', 'group = "right"', 15600.0, [4, 0.5, 0.25]),
    "one_volume.msh": ('group = "left"', 'group = "right"', 7800.0, [2, 0.5, 0.25]),
    "overlapping_2.msh": ('group = "left"', 'group = "outer"', 15600.0, [3, 0.5, 0.25]),
    "same_name.msh": ('group = "root (surface 3)"', 'group = "tip (surface 4)"', 15600.0, [4, 0.5, 0.25]),
}
"""File -> clamp, tip, mass, place of the tip; of an irregular mesh of a volume that is known to half a percent."""


@pytest.mark.parametrize("name", BARS)
def test_mass_and_tip_are_those_of_the_bar(tmp_path, name):
    clamp, tip, mass, place = BARS[name]
    (tmp_path / "body.toml").write_text(BODY.format(file=DATA / name, clamp=clamp, tip=tip))
    model = build(tmp_path / "body.toml")
    assert model.invariants.mass == pytest.approx(mass, rel=1e-12)
    np.testing.assert_allclose(model.interfaces["tip"].position[0, :, 0], place, atol=5e-3)


def test_a_name_of_two_dimensions_is_of_neither_alone(tmp_path):
    """Physical Surface "tip" is the end at x = 4, Physical Volume "tip" is the half from x = 2 on."""
    mesh = read_mesh(DATA / "same_name.msh")
    assert set(mesh.groups) == {"root (surface 3)", "tip (surface 4)", "root (volume 1)", "tip (volume 2)"}
    assert np.ptp(mesh.nodes[mesh.groups["tip (surface 4)"], 0]) == 0
    assert mesh.nodes[mesh.groups["tip (volume 2)"], 0].min() == 2
    assert any("'tip' is of groups of several dimensions (surface, volume)" in each for each in mesh.remarks)
    (tmp_path / "body.toml").write_text(BODY.format(file=DATA / "same_name.msh", clamp='group = "root"', tip='group = "tip"'))
    with pytest.raises(InputError, match=r"no group 'root'.*'root \(surface 3\)'"):
        build(tmp_path / "body.toml")


def opened(tmp_path: Path, name: str, order: int, dimension: int) -> Path:
    """The mesh of a script of gmsh, as `gmsh -2` or `gmsh -3` writes it."""
    from preprocessing.builders.curve_mesh import gmsh_model

    with gmsh_model("any") as gmsh:
        gmsh.option.restoreDefaults()
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.merge(str(DATA / name))
        save_all = gmsh.option.getNumber("Mesh.SaveAll")
        gmsh.model.mesh.generate(dimension)
        gmsh.model.mesh.setOrder(order)
        return written(gmsh, tmp_path / "body.msh", Mesh_SaveAll=save_all)


def test_a_group_of_curves_has_those_against_their_direction(tmp_path):
    """Physical Curve("held") = {-4, 5}: the left end, and the top from x = 0 to 20."""
    mesh = read_mesh(opened(tmp_path, "held.geo", 2, 2))
    x, y = mesh.nodes.T
    np.testing.assert_array_equal(mesh.groups["held"], np.flatnonzero((x == 0) | ((y == 10) & (x <= 20 + 1e-9))))


def test_all_elements_are_saved_with_the_groups_of_some(tmp_path):
    mesh = read_mesh(opened(tmp_path, "saveall.geo", 1, 3))
    np.testing.assert_array_equal(mesh.groups["root"], np.flatnonzero(mesh.nodes[:, 0] == 0))
    assert set(mesh.blocks) == {"tetra"}
