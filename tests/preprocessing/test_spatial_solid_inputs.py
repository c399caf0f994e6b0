"""Files that spatial bodies are made of: every format gives the same body, and invalid input is refused by name."""

from __future__ import annotations

from pathlib import Path

import gmsh
import meshio
import numpy as np
import pytest
from scipy import io, sparse

from preprocessing import build
from preprocessing.builders.body_recipe import BodyRecipe
from preprocessing.builders.discrete_body import discrete_body
from tests.models.solid_bodies import box, rectangle, write_body, write_mesh
from tests.preprocessing.test_solid_inputs import same
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.file import load, save

pytestmark = pytest.mark.usefixtures("read_here")

LENGTHS = (1.0, 0.3, 0.2)
MESH = box("hexahedron20", (3, 1, 1), LENGTHS)
LEFT, RIGHT = MESH.groups["left"].tolist(), MESH.groups["right"].tolist()
BASIS = 'kind = "craig-bampton"\ncount = 3'


@pytest.mark.parametrize("kind", ["tetra10", "hexahedron20", "hexahedron27", "wedge", "wedge15"])
def test_every_mesh_format_gives_the_same_body(kind, tmp_path):
    mesh = box(kind, (2, 1, 1), LENGTHS)
    path = write_body(tmp_path, mesh, 'kind = "static"')
    expected, text = build(path), path.read_text()
    for name in ("body.msh", "body.inp", "body.vtk"):
        if (kind, name) != ("hexahedron27", "body.inp"):  # Abaqus has no such element in meshio
            write_mesh(mesh, tmp_path / name)
            path.write_text(text.replace("body.vtu", name))
            same(expected, build(path), 1e-9)  # a text file's digits, 16 or fewer, times the condition of the stiffness


def test_nastran_mesh_of_linear_elements_gives_the_same_body(tmp_path):
    mesh = box("hexahedron", (4, 2, 1), (1.0, 0.5, 0.25))
    path = write_body(tmp_path, mesh, 'kind = "static"')
    expected = build(path)
    write_mesh(mesh, tmp_path / "body.bdf")
    path.write_text(path.read_text().replace("body.vtu", "body.bdf"))
    same(expected, build(path), 1e-5)  # numbers in fields of 8 or 16 characters


def test_saved_model_is_read_again_as_it_was(tmp_path):
    path = write_body(tmp_path, MESH, BASIS, more="\n[pressure_surfaces.top]\nbox = [0, -0.15, 0.1, 1, 0.15, 0.1]\n")
    model = build(path)
    save(model, tmp_path / "body.h5")
    again = load(tmp_path / "body.h5")
    same(model, again, 1e-15)
    assert again.dimension == 3
    assert again.surface.lines.shape == (0, 2)
    assert len(again.surface.position) == len(again.stress.element) == len(again.invariants.stress_operator)
    assert again.interfaces["tip"].position.shape == again.interfaces["tip"].rotation.shape == (1, 3, 1 + 6 + 3)
    assert set(again.nominal) == {"youngs_modulus", "density", "damping_mass", "damping_stiffness", "poisson_ratio"}
    np.testing.assert_allclose(again.surface_loads["top"].force, [0, 0, -0.3], atol=1e-15)
    np.testing.assert_allclose(again.surface_loads["top"].moment[2, :, 0], [-0.15, 0, -0.03], atol=1e-15)


@pytest.mark.parametrize("version", [2.2, 4.1])
@pytest.mark.parametrize("recombined", [False, True])
def test_physical_groups_of_gmsh_are_clamps_points_and_pressure_surfaces(version, recombined, tmp_path):
    """Tetrahedra of a box with a step of groups; or a box of two halves, one of tetrahedra meshed and one extruded to wedges."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.3)
        square = gmsh.model.occ.addRectangle(0, 0, 0, 1, 0.5)
        layers = {"numElements": [2], "recombine": True} if recombined else {}
        made = gmsh.model.occ.extrude([(2, square)], 0, 0, 0.4, **layers)
        gmsh.model.occ.synchronize()
        volume = [tag for dimension, tag in made if dimension == 3]
        faces = {tag: gmsh.model.occ.getCenterOfMass(2, tag) for _, tag in gmsh.model.getEntities(2)}
        gmsh.model.addPhysicalGroup(3, volume, name="block")
        for name, axis, place in (("wall", 0, 0.0), ("end", 0, 1.0), ("top", 2, 0.4)):
            gmsh.model.addPhysicalGroup(2, [tag for tag, at in faces.items() if abs(at[axis] - place) < 1e-6], name=name)
        gmsh.model.mesh.generate(3)
        if not recombined:
            gmsh.model.mesh.setOrder(2)
        gmsh.write(str(tmp_path / "body.msh"))
    finally:
        gmsh.finalize()
    path = tmp_path / "body.toml"
    path.write_text(
        """
units = "m-kg-s"
mesh.file = "body.msh"
material = { youngs_modulus = 1e9, density = 1000.0, poisson_ratio = 0.3 }
clamp.group = "wall"
interface_points.end.group = "end"
pressure_surfaces.top.group = "top"
basis = { kind = "static" }
"""
    )
    model, body = build(path), discrete_body(path, BodyRecipe.read(path).file)
    assert set(body.mesh.blocks) == ({"wedge"} if recombined else {"tetra10"})
    np.testing.assert_allclose(model.invariants.mass, 1000 * 0.5 * 0.4, rtol=1e-10)  # the digits of the file
    np.testing.assert_allclose(model.interfaces["end"].position[0, :, 0], [1.0, 0.25, 0.2], atol=1e-10)
    np.testing.assert_allclose(model.surface_loads["top"].force, [0, 0, -0.5], atol=1e-10)


def write_matrices(folder: Path, kind: str) -> Path:
    """body.toml with the finished matrices of the same body, and no mesh; what an average weighs is not known then, so its tie is rigid."""
    path = write_body(folder, MESH, BASIS, tie="rigid")
    body = discrete_body(path, BodyRecipe.read(path).file)
    matrices = body.parts.at(body.values)
    for name, matrix in {"mass": matrices.mass, "stiffness": matrices.stiffness}.items():
        if kind == "abaqus":
            lower = sparse.tril(matrix).tocoo()
            numbers = zip(lower.row // 3 + 1, lower.row % 3 + 1, lower.col // 3 + 1, lower.col % 3 + 1, lower.data, strict=True)
            text = "".join(f"{a},{b}, {c},{d}, {value:.17e}\n" for a, b, c, d, value in numbers)
            (folder / f"{name}.mtx").write_text(text)
        elif kind == "npz":
            sparse.save_npz(folder / f"{name}.npz", matrix)
        else:
            io.mmwrite(folder / f"{name}.mtx", sparse.coo_array(matrix), precision=17, symmetry="symmetric")
    ending = "npz" if kind == "npz" else "mtx"
    np.savetxt(folder / "nodes.csv", MESH.nodes, delimiter=",", fmt="%.17g")
    tables = f'[matrices]\nmass = "mass.{ending}"\nstiffness = "stiffness.{ending}"\nnodes = "nodes.csv"\n'
    path.write_text(path.read_text().replace('[mesh]\nfile = "body.vtu"\n', tables))
    return path


@pytest.mark.parametrize("kind", ["matrix-market", "abaqus", "npz"])
def test_finished_matrices_give_the_body_of_the_mesh_that_they_were_made_from(kind, tmp_path):
    expected = build(write_body(tmp_path, MESH, BASIS + '\nderivative = "frozen"', tie="rigid"))
    found = build(write_matrices(tmp_path, kind))
    assert found.surface is None
    for name in ("mass", "first_moment", "second_moment", "stiffness", "damping"):
        array = getattr(expected.invariants, name)
        # 17 digits, times the condition of the stiffness
        np.testing.assert_allclose(getattr(found.invariants, name), array, atol=1e-9 * np.abs(array).max(), err_msg=name)
    np.testing.assert_allclose(found.interfaces["tip"].position, expected.interfaces["tip"].position, atol=1e-12)
    assert set(found.affine) == {"mass", "first_moment", "second_moment", "stiffness", "damping"}


def test_mesh_beside_finished_matrices_gives_surface_and_stress(tmp_path):
    expected = build(write_body(tmp_path, MESH, BASIS, tie="rigid"))
    path = write_matrices(tmp_path, "npz")
    path.write_text(path.read_text().replace('nodes = "nodes.csv"', '\n[mesh]\nfile = "body.vtu"'))
    found = build(path)
    same(expected, found, 1e-9)
    np.testing.assert_array_equal(found.surface.triangles, expected.surface.triangles)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[damping]", "[section]\nwidth = 0.1\n[damping]", "section: this body is spatial"),
        ("poisson_ratio = 0.3", 'poisson_ratio = 0.3\nstate = "plane-strain"', "material.state: this body is spatial"),
        ("poisson_ratio = 0.3", "", "elements need .material. with youngs_modulus, poisson_ratio and density"),
        (f"[clamp]\nnodes = {LEFT}", "[clamp]\nnodes = [4]", "clamp: .* holds 1 node at one place or on one line"),
        (
            f"[clamp]\nnodes = {LEFT}",
            "[clamp]\nbox = [0, -1, 0.1, 0, 1, 0.1]",
            "clamp: .* holds 3 nodes at one place or on one line",
        ),
        (f"[clamp]\nnodes = {LEFT}", "[clamp]\nbox = [0, -1, 0, 1]", "clamp: the box .* has 4 numbers, but the body has 3 axes"),
        (
            f"[interface_points.tip]\nnodes = {RIGHT}",
            "[interface_points.tip]\nbox = [1, -1, 0.1, 1, 1, 0.1]",
            "tip: the 3 nodes are at",
        ),
        ('tie = "averaged"', 'tie = "averaged"\nat = [1.0, 0.0]', r"interface_points.tip: at = \[1.0, 0.0\] has 2 coordinates"),
        (BASIS, f'{BASIS}\n[stress]\nquantity = "xx"', "stress.quantity: .* is one of plane bodies"),
        (BASIS, f"{BASIS}\n[pressure_surfaces.side]\nnodes = [0, 1]", "pressure_surfaces.side: .* holds no whole face"),
        (BASIS, f'{BASIS}\n[pressure_surfaces.side]\ngroup = "x"', "pressure_surfaces.side: the mesh has no group 'x'"),
    ],
)
def test_wrong_bodies_are_refused_by_name(old, new, message, tmp_path):
    path = write_body(tmp_path, MESH, BASIS)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=message):
        build(path)


def test_pyramids_and_folded_elements_are_refused(tmp_path):
    path = write_body(tmp_path, MESH, BASIS)
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]])
    meshio.write(tmp_path / "body.vtu", meshio.Mesh(corners, [("pyramid", np.arange(5)[None])]))
    with pytest.raises(InputError, match=r"elements of the kinds pyramid; possible are .* tetra, tetra10, hexahedron"):
        build(path)
    nodes = MESH.nodes.copy()
    nodes[MESH.blocks["hexahedron20"][1, 6]] = nodes[MESH.blocks["hexahedron20"][1, 0]]
    meshio.write(tmp_path / "body.vtu", meshio.Mesh(nodes, list(MESH.blocks.items())))
    with pytest.raises(InputError, match=r"mesh.file: .* elements of kind hexahedron20 are flat or folded over"):
        build(path)


def test_group_of_faces_is_pressed_on_its_own_faces_alone(tmp_path):
    """Two groups that between them hold all nodes of a third face: the nodes alone would name it too."""
    mesh = box("hexahedron", (1, 1, 1), (1.0, 1.0, 1.0))
    (cube,) = mesh.blocks["hexahedron"]
    both = cube[[[0, 3, 2, 1], [4, 5, 6, 7]]]
    path = write_body(tmp_path, mesh, 'kind = "static"')
    cells = [("hexahedron", cube[None]), ("quad", both)]
    meshio.write(tmp_path / "body.inp", meshio.Mesh(mesh.nodes, cells, cell_sets={"lids": [[], [0, 1]]}))
    path.write_text(path.read_text().replace("body.vtu", "body.inp") + '\n[pressure_surfaces.lids]\ngroup = "lids"\n')
    load = build(path).surface_loads["lids"]
    np.testing.assert_allclose(load.force, 0, atol=1e-15)
    np.testing.assert_allclose(load.moment[:, :, 0], np.diag([0, 0, -1.0]), atol=1e-15)


def halves(first: str, second: str) -> meshio.Mesh:
    """Two cubes side by side, of one kind of elements each."""
    one, other = box(first, (1, 1, 1), (1.0, 1.0, 1.0)), box(second, (1, 1, 1), (1.0, 1.0, 1.0))
    every = np.vstack([one.nodes, other.nodes + np.array([1.0, 0, 0])])
    nodes, number = np.unique(every.round(12), axis=0, return_inverse=True)
    elements = (one.blocks[first], other.blocks[second] + len(one.nodes))
    return meshio.Mesh(nodes, [(kind, number.ravel()[each]) for kind, each in zip((first, second), elements, strict=True)])


@pytest.mark.parametrize("kinds", [("hexahedron", "wedge"), ("hexahedron20", "hexahedron27")])
def test_blocks_of_several_kinds_are_one_body(kinds, tmp_path):
    """The wedges' quadrilateral faces meet those of the hexahedra; a face of 8 nodes and one of 9 do not."""
    path = write_body(tmp_path, box("hexahedron", (2, 1, 1), (2.0, 1.0, 1.0)), 'kind = "static"')
    meshio.write(tmp_path / "body.vtu", halves(*kinds))
    text = path.read_text()
    for end, x in (("left", 0.0), ("right", 2.0)):
        nodes = box("hexahedron", (2, 1, 1), (2.0, 1.0, 1.0)).groups[end].tolist()
        text = text.replace(f"nodes = {nodes}", f"box = [{x}, -1.0, -1.0, {x}, 1.0, 1.0]")
    path.write_text(text)
    if kinds[1] == "hexahedron27":
        with pytest.raises(
            InputError, match=r"mesh.file: 1 faces have nodes in the middle .* for one of their two elements only"
        ):
            build(path)
        return
    model = build(path)
    np.testing.assert_allclose(model.invariants.mass, 7800.0 * 2.0, rtol=1e-12)  # round-off, here and below
    faces = discrete_body(path, BodyRecipe.read(path).file).boundary.faces
    assert {kind: len(each) for kind, each in faces.items()} == {"quad": 8, "triangle": 4}
    np.testing.assert_allclose(model.interfaces["tip"].position[0, :, 0], [2.0, 0, 0], atol=1e-12)


def test_plane_bodies_have_no_pressure_surfaces_and_no_shape_variables(tmp_path):
    path = write_body(tmp_path, rectangle("quad", (2, 1), 1.0, 0.5), 'kind = "static"')
    text = path.read_text()
    path.write_text(text + "\n[pressure_surfaces.top]\nnodes = [0]\n")
    with pytest.raises(InputError, match="pressure_surfaces: this body is plane"):
        build(path)
    np.save(tmp_path / "f.npy", np.zeros((6, 3)))
    path.write_text(text + '\n[shape_variables.top]\nfield = "f.npy"\n')
    with pytest.raises(InputError, match=r"shape_variables.top: the nodes of plane meshes cannot be moved"):
        build(path)
    path = write_matrices(tmp_path, "npz")
    path.write_text(path.read_text() + '\n[shape_variables.top]\nfield = "f.npy"\n')
    with pytest.raises(InputError, match=r"finished matrices stay as they are"):
        build(path)
