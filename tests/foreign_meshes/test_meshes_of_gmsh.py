"""All files that gmsh writes of five meshes: each is read right, or refused by name; gmsh itself says what is right."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from preprocessing.mesh.mesh_file import read_mesh
from preprocessing.mesh.solid_mesh import SolidMesh
from tests.foreign_meshes.gmsh_files import NAMES, SHAPES, Truth, in_order, meshed, written
from tests.foreign_meshes.sizes import size
from toolkit.foundation.errors import InputError

pytestmark = pytest.mark.usefixtures("read_here")

NUMBERED = {"body": "physical {} 1", "left": "physical {} 2", "right": "physical {} 3"}
GROUPED = {
    "msh1": ("msh", {"Mesh_MshFileVersion": 1.0}),
    "msh2": ("msh", {"Mesh_MshFileVersion": 2.2}),
    "msh2 binary": ("msh", {"Mesh_MshFileVersion": 2.2, "Mesh_Binary": 1}),
    "msh2 parametric": ("msh", {"Mesh_MshFileVersion": 2.2, "Mesh_SaveParametric": 1}),
    "msh4": ("msh", {}),
    "msh4 binary": ("msh", {"Mesh_Binary": 1}),
    "msh4 parametric": ("msh", {"Mesh_SaveParametric": 1}),
    "msh4 parametric binary": ("msh", {"Mesh_SaveParametric": 1, "Mesh_Binary": 1}),
    "msh4 all": ("msh", {"Mesh_SaveAll": 1}),
    "unv": ("unv", {}),
    "med": ("med", {}),
}
"""Files whose groups are read."""
PLAIN = {
    "msh2 all": ("msh", {"Mesh_MshFileVersion": 2.2, "Mesh_SaveAll": 1}),  # gmsh leaves the groups out
    "vtk": ("vtk", {}),
    "vtk binary": ("vtk", {"Mesh_Binary": 1}),
}
"""Files of which all but groups is read."""
LINEAR_ONLY = {"mesh": ("mesh", {}), "su2": ("su2", {})}
"""The same, where quadratic elements are refused."""
OTHER_READERS = {
    "inp": ("inp", {}),
    "bdf": ("bdf", {}),
    "bdf free": ("bdf", {"Mesh_BdfFieldFormat": 0}),
    "bdf long": ("bdf", {"Mesh_BdfFieldFormat": 2}),
}
"""Decks, whose readers have tests of their own: read right, or refused."""
REFUSED = (
    *(
        "stl",
        "off",
        "ply2",
        "obj",
        "wrl",
        "x3d",
        "p3d",
        "ir3",
        "diff",
        "key",
        "rad",
        "celum",
        "neu",
        "mail",
        "m",
        "pos",
    ),
    *("cgns", "dat"),
)


@pytest.fixture(scope="module", params=SHAPES)
def files(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Truth]:
    """Files of one mesh in all formats, and what is right."""
    folder = tmp_path_factory.mktemp(request.param)
    with meshed(request.param) as (gmsh, right):
        for name, (ending, options) in {**GROUPED, **PLAIN, **LINEAR_ONLY, **OTHER_READERS}.items():
            written(gmsh, folder / f"{name}.{ending}", **options)
        written(gmsh, folder / "msh40.msh", Mesh_MshFileVersion=4.0)
        for ending in REFUSED:
            written(gmsh, folder / f"{ending}.{ending}")
    return folder, right


def is_right(mesh: SolidMesh, right: Truth) -> bool:
    """Number of elements by kind, of nodes, and the area or volume."""
    counted = {kind: len(block) for kind, block in mesh.blocks.items()} == {right.kind: right.elements}
    return counted and len(mesh.nodes) == right.nodes and abs(size(mesh.nodes, mesh.blocks) - right.size) < 1e-9


def names_in(name: str, right: Truth) -> dict[str, str]:
    """How the groups are called in a file."""
    if name == "msh1":
        words = {2: ("surface", "curve"), 3: ("volume", "surface")}[right.dimension]
        return {each: text.format(words[each != "body"]) for each, text in NUMBERED.items()}
    if name == "unv":
        return {each: text.replace(" ", "_") for each, text in NAMES.items()}
    if name == "med" and right.dimension == 2:
        return {**NAMES, "left": "G_1D_-2"}  # gmsh loses the name of a group against its direction
    return NAMES


@pytest.mark.parametrize("name", GROUPED)
def test_elements_and_groups_are_read_as_gmsh_has_them(files, name):
    folder, right = files
    mesh = read_mesh(folder / f"{name}.{GROUPED[name][0]}")
    assert is_right(mesh, right)
    for each, called in names_in(name, right).items():
        np.testing.assert_array_equal(in_order(mesh.nodes[mesh.groups[called]]), right.groups[NAMES[each]])
    assert set(mesh.groups) == set(names_in(name, right).values())


@pytest.mark.parametrize("name", PLAIN)
def test_elements_of_formats_without_groups_are_read_as_gmsh_has_them(files, name):
    folder, right = files
    mesh = read_mesh(folder / f"{name}.{PLAIN[name][0]}")
    assert is_right(mesh, right)
    assert not any(map(len, mesh.groups.values()))


@pytest.mark.parametrize("name", LINEAR_ONLY)
def test_quadratic_elements_of_medit_and_su2_are_refused(files, name):
    folder, right = files
    path = folder / f"{name}.{LINEAR_ONLY[name][0]}"
    if right.kind in ("quad8", "tetra10") or (name, right.kind) == ("mesh", "wedge"):  # of which gmsh writes the surface only
        with pytest.raises(InputError, match=r"cannot be read|triangles or quadrilaterals only"):
            read_mesh(path)
    else:
        assert is_right(read_mesh(path), right)


@pytest.mark.parametrize("name", OTHER_READERS)
def test_decks_of_gmsh_are_read_right_or_refused(files, name):
    folder, right = files
    try:
        mesh = read_mesh(folder / f"{name}.{OTHER_READERS[name][0]}")
    except InputError as error:
        assert f"{name}.{OTHER_READERS[name][0]}" in str(error)  # noqa: PT017 (both are right)
    else:
        assert is_right(mesh, right)


@pytest.mark.parametrize("ending", REFUSED)
def test_formats_that_hold_no_mesh_of_a_body_or_are_not_read_are_refused(files, ending):
    for path in [files[0] / f"{ending}.{ending}"] if ending != "celum" else sorted(files[0].glob("celum.celum_?")):
        assert path.exists()
        with pytest.raises(InputError, match=rf"{path.name}' (is in the format|cannot be read)"):
            read_mesh(path)


def test_the_version_of_gmsh_that_is_not_read_is_named(files):
    with pytest.raises(InputError, match=r"another version than 1, 2 or 4\.1.*gmsh in\.msh -save -format msh41"):
        read_mesh(files[0] / "msh40.msh")


@pytest.fixture(
    params=[{"Mesh_MshFileVersion": 2.2}, {}, {"Mesh_Binary": 1}, {"Mesh_MshFileVersion": 2.2, "Mesh_Binary": 1}], ids=str
)
def options(request: pytest.FixtureRequest) -> dict[str, float]:
    return request.param


@pytest.mark.parametrize("kind", ["triangle", "tetra"])
def test_partitioned_meshes_are_whole(tmp_path, kind, options):
    with meshed(kind, partitions=3) as (gmsh, right):
        path = written(gmsh, tmp_path / "parts.msh", Mesh_PartitionCreateGhostCells=1, **options)
    with meshed(kind) as (_, right):
        mesh = read_mesh(path)
    assert is_right(mesh, right)
    for name in NAMES.values():
        np.testing.assert_array_equal(in_order(mesh.nodes[mesh.groups[name]]), right.groups[name])


@pytest.mark.parametrize("kind", ["wedge15", "hexahedron20", "hexahedron27"])
@pytest.mark.parametrize("ending", ["msh", "unv", "vtk", "med"])
def test_nodes_between_corners_are_where_their_kind_has_them(tmp_path, kind, ending):
    from preprocessing.foreign_files.contents import MeshContents
    from preprocessing.foreign_files.mesh_reader import mesh_contents

    with meshed("wedge" if kind == "wedge15" else "hexahedron") as (gmsh, _):
        gmsh.option.setNumber("Mesh.SecondOrderIncomplete", kind != "hexahedron27")
        gmsh.model.mesh.setOrder(2)
        path = written(gmsh, tmp_path / f"body.{ending}")
    if (kind, ending) == ("hexahedron27", "unv"):  # there is none in a universal file
        with pytest.raises(InputError, match="an element of descriptor 94 has not its 4 nodes"):
            mesh_contents(str(path))
        return
    found = MeshContents.received(mesh_contents(str(path)))
    (nodes,) = [block for each, block in found.cells if each == kind]
    for place, ends in MIDDLES[kind].items():
        np.testing.assert_allclose(found.points[nodes[:, place]], found.points[nodes[:, ends]].mean(axis=1), atol=1e-12)


WEDGE = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]
BRICK = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
FACES = [(0, 3, 4, 7), (1, 2, 5, 6), (0, 1, 4, 5), (2, 3, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7), tuple(range(8))]
MIDDLES = {
    "wedge15": dict(enumerate(WEDGE, 6)),
    "hexahedron20": dict(enumerate(BRICK, 8)),
    "hexahedron27": dict(enumerate(BRICK + FACES, 8)),
}
"""Kind -> place of a node in it, and the corners in whose middle it is."""
