"""Files that solid bodies are made of: every format gives the same body, and invalid input is refused by name."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import gmsh
import meshio
import numpy as np
import pytest
from scipy import io, sparse

from preprocessing import build
from preprocessing.builders.body_recipe import BodyRecipe
from preprocessing.builders.discrete_body import discrete_body
from preprocessing.commands.cli import main
from tests.models.solid_bodies import rectangle, write_body, write_mesh
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.file import load
from toolkit.reduced_model.model import ReducedModel

pytestmark = pytest.mark.usefixtures("read_here")

MESH = rectangle("quad8", (6, 2), 1.0, 0.2)
LEFT, RIGHT = MESH.groups["left"].tolist(), MESH.groups["right"].tolist()
BASIS = 'kind = "craig-bampton"\ncount = 3'


def same(one: ReducedModel, other: ReducedModel, tolerance: float) -> None:
    """All invariants and interface points of two models, relative to their largest entries."""
    for name, array in asdict(one.invariants).items():
        found = getattr(other.invariants, name)
        np.testing.assert_allclose(found, array, atol=tolerance * np.abs(array).max(initial=0), rtol=0, err_msg=name)
    for name, point in one.interfaces.items():
        np.testing.assert_allclose(other.interfaces[name].position, point.position, atol=tolerance)


def test_every_mesh_format_gives_the_same_body(tmp_path):
    path = write_body(tmp_path, MESH, BASIS)
    expected, text = build(path), path.read_text()
    for name in ("body.msh", "body.inp", "body.vtk", "body.vtu"):
        write_mesh(MESH, tmp_path / name)
        path.write_text(text.replace("body.vtu", name))
        same(expected, build(path), 1e-9)  # a text file's digits, 16 or fewer, times the condition of the stiffness


def test_nastran_mesh_of_linear_elements_gives_the_same_body(tmp_path):
    mesh = rectangle("quad", (6, 2), 1.0, 0.25)
    path = write_body(tmp_path, mesh, BASIS)
    expected = build(path)
    write_mesh(mesh, tmp_path / "body.bdf")
    path.write_text(path.read_text().replace("body.vtu", "body.bdf"))
    same(expected, build(path), 1e-5)  # numbers in fields of 8 or 16 characters


def test_nodes_keep_their_numbers_when_others_of_the_file_have_no_element(tmp_path):
    path = write_body(tmp_path, MESH, BASIS)
    expected = build(path)
    points = np.column_stack([np.vstack([[[9.0, 9.0]], MESH.nodes]), np.zeros(1 + len(MESH.nodes))])
    meshio.write(tmp_path / "body.vtu", meshio.Mesh(points, [("quad8", 1 + MESH.blocks["quad8"])]))
    for nodes in (LEFT, RIGHT):
        path.write_text(path.read_text().replace(str(nodes), str([node + 1 for node in nodes])))
    same(expected, build(path), 1e-14)


@pytest.mark.parametrize("version", [2.2, 4.1])
def test_physical_groups_of_gmsh_and_both_kinds_of_elements_in_one_mesh(version, tmp_path):
    """Two squares side by side, one of triangles and one of quadrilaterals, clamped and gripped at named lines."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        corners = [gmsh.model.geo.addPoint(x, y, 0, 0.25) for x, y in ((0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1))]
        lines = [
            gmsh.model.geo.addLine(corners[a], corners[b]) for a, b in ((0, 1), (1, 4), (4, 5), (5, 0), (1, 2), (2, 3), (3, 4))
        ]
        surfaces = []
        for loop in ([0, 1, 2, 3], [4, 5, 6, -1]):
            signed = [lines[k] if k >= 0 else -lines[-k] for k in loop]
            surfaces.append(gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(signed)]))
        gmsh.model.geo.mesh.setTransfiniteSurface(surfaces[1])
        gmsh.model.geo.mesh.setRecombine(2, surfaces[1])
        gmsh.model.geo.synchronize()
        gmsh.model.addPhysicalGroup(2, surfaces, name="sheet")
        gmsh.model.addPhysicalGroup(2, surfaces[:1], name="half")  # version 2.2 writes its elements twice
        gmsh.model.addPhysicalGroup(1, [lines[3]], name="wall")
        gmsh.model.addPhysicalGroup(1, [lines[5]], name="end")
        gmsh.model.mesh.generate(2)
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
section.width = 0.1
clamp.group = "wall"
interface_points.end.group = "end"
basis = { kind = "static" }
"""
    )
    model, body = build(path), discrete_body(path, BodyRecipe.read(path).file)
    assert set(body.mesh.blocks) == {"triangle6", "quad9"}
    np.testing.assert_allclose(model.invariants.mass, 1000 * 0.1 * 2, rtol=1e-12)  # round-off
    np.testing.assert_allclose(model.interfaces["end"].position[0, :, 0], [2.0, 0.5], atol=1e-12)
    assert len(model.stress.element) == 24  # four edges on each side of the two squares, none between them


def write_matrices(folder: Path, kind: str) -> Path:
    """body.toml with the finished matrices of the same body, and no mesh; what an average weighs is not known then, so its tie is rigid."""
    path = write_body(folder, MESH, BASIS, tie="rigid")
    body = discrete_body(path, BodyRecipe.read(path).file)
    matrices = body.parts.at(body.values)
    files = {"mass": matrices.mass, "stiffness": matrices.stiffness}
    for name, matrix in files.items():
        if kind == "abaqus":
            lower = sparse.tril(matrix).tocoo()
            numbers = zip(lower.row // 2 + 1, lower.row % 2 + 1, lower.col // 2 + 1, lower.col % 2 + 1, lower.data, strict=True)
            text = "".join(f"{a},{b}, {c},{d}, {value:.17e}\n" for a, b, c, d, value in numbers)
            (folder / f"{name}.mtx").write_text(text)
        elif kind == "npz":
            sparse.save_npz(folder / f"{name}.npz", matrix)
        else:
            symmetric = "symmetric" if kind == "matrix-market-symmetric" else "general"
            io.mmwrite(folder / f"{name}.mtx", sparse.coo_array(matrix), precision=17, symmetry=symmetric)
    ending = "npz" if kind == "npz" else "mtx"
    np.savetxt(folder / "nodes.csv", body.mesh.nodes, delimiter=",", fmt="%.17g")
    sparse.save_npz(folder / "stress.npz", matrices.stress)
    text = path.read_text().replace('[mesh]\nfile = "body.vtu"', "[matrices]").replace("poisson_ratio = 0.3\n", "")
    keys = f'mass = "mass.{ending}"\nstiffness = "stiffness.{ending}"\nnodes = "nodes.csv"\nstress = "stress.npz"\n'
    path.write_text(text.replace("[matrices]\n", f"[matrices]\n{keys}"))
    return path


@pytest.mark.parametrize("kind", ["matrix-market", "matrix-market-symmetric", "npz", "abaqus"])
def test_finished_matrices_give_the_body_that_its_elements_give(kind, tmp_path):
    (tmp_path / "elements").mkdir()
    expected = build(write_body(tmp_path / "elements", MESH, BASIS, tie="rigid"))
    found = build(write_matrices(tmp_path, kind))
    # sums in another order, 1e-16, are multiplied by the condition of the stiffness in the shapes only, and these are of least energy
    same(expected, found, 1e-12)
    for item, polynomial in found.affine.items():
        np.testing.assert_array_equal(polynomial.power, expected.affine[item].power)


def test_finished_matrices_without_material_scale_and_take_groups_from_a_mesh(tmp_path):
    path = write_matrices(tmp_path, "npz")
    text = path.read_text()
    start, end = text.index("[material]"), text.index("[damping]")
    text = text[:start] + '[mesh]\nfile = "body.vtu"\n' + text[end:].replace('stress = "stress.npz"\n', "")
    path.write_text(text.replace('nodes = "nodes.csv"\n', "").replace('stress = "stress.npz"\n', ""))
    model = build(path)
    assert set(model.nominal) == {"stiffness_scale", "mass_scale", "damping_mass", "damping_stiffness"}
    np.testing.assert_allclose(model.invariants.mass, 7800 * 0.05 * 0.2, rtol=1e-12)  # round-off
    assert model.invariants.stress_operator.shape[0] == 0


def test_command_builds_a_body_and_then_finds_it_up_to_date(tmp_path, monkeypatch, capsys):
    path = write_body(tmp_path, MESH, BASIS)

    def run(*options: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["ffrf-preprocess", str(path), *options])
        with pytest.raises(SystemExit) as caught:
            main()
        return (caught.value.code or 0, *capsys.readouterr())

    code, out, err = run()
    assert (code, err) == (0, "")
    assert "9 elastic coordinates" not in out
    assert "body.h5 written: 6 elastic coordinates, interface points hub, tip." in out
    assert load(tmp_path / "body.h5").mesh is None
    assert "is up to date" in run()[1]
    write_mesh(rectangle("quad8", (6, 2), 1.1, 0.2), tmp_path / "body.vtu")
    assert "written" in run()[1]
    assert "written" in run("--parameter", "width=0.1", "--output", str(tmp_path / "wide.h5"))[1]
    assert load(tmp_path / "wide.h5").nominal["width"] == 0.1
    code, _, err = run("--output", str(tmp_path / "body.vtu"))
    assert code == 1
    assert "is an input of the model" in err


def spatial(folder: Path) -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    meshio.write(folder / "body.vtu", meshio.Mesh(corners, [("tetra", np.arange(4)[None])]))


def tilted(folder: Path) -> None:
    points = np.column_stack([MESH.nodes, MESH.nodes[:, 0]])
    meshio.write(folder / "body.vtu", meshio.Mesh(points, list(MESH.blocks.items())))


def torn(folder: Path) -> None:
    one, n = MESH.nodes, len(MESH.nodes)
    points = np.column_stack([np.vstack([one, one + np.array([5.0, 0.0])]), np.zeros(2 * n)])
    both = np.vstack([MESH.blocks["quad8"], MESH.blocks["quad8"] + n])
    meshio.write(folder / "body.vtu", meshio.Mesh(points, [("quad8", both)]))


def moved(place: int, to: tuple[float, float]) -> Callable[[Path], None]:
    def write(folder: Path) -> None:
        nodes = MESH.nodes.copy()
        nodes[MESH.blocks["quad8"][5, place]] = to
        points = np.column_stack([nodes, np.zeros(len(nodes))])
        meshio.write(folder / "body.vtu", meshio.Mesh(points, list(MESH.blocks.items())))

    return write


def damaged(folder: Path) -> None:
    (folder / "body.vtu").write_text("<VTKFile> no mesh at all")


def lines_only(folder: Path) -> None:
    meshio.write(folder / "body.vtu", meshio.Mesh(np.eye(3), [("line", np.array([[0, 1], [1, 2]]))]))


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (spatial, r"body\.toml', section: this body is spatial, .* such bodies have none"),
        (tilted, "has triangles or quadrilaterals only, but its z reaches from 0 to 1"),
        (torn, r"2 parts that share no nodes; one of them is at \(5, -0.1\)"),
        (moved(0, (0.9, 0.09)), "flat or folded over, the first with the nodes"),
        (moved(4, (0.0, -0.1)), "flat or folded over"),
        (damaged, "it is no XML, or not whole"),
        (lines_only, "holds no triangles and no quadrilaterals"),
        (lambda folder: (folder / "body.vtu").unlink(), r"there is no file '.*body\.vtu'"),
    ],
)
def test_meshes_that_cannot_be_used_are_refused(spoil, message, tmp_path):
    path = write_body(tmp_path, MESH, BASIS)
    spoil(tmp_path)
    with pytest.raises(InputError, match=message):
        build(path)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('file = "body.vtu"', 'fil = "body.vtu"', "mesh.fil: unknown key, did you mean 'file'; possible here: file, scale"),
        ("poisson_ratio = 0.3", "", "elements need .material. with youngs_modulus, poisson_ratio and density"),
        ("poisson_ratio = 0.3", "poisson_ratio = 0.5", "material.poisson_ratio: .* less than 0.5"),
        (f"[clamp]\nnodes = {LEFT}", "", "the body's frame needs a place; add .clamp."),
        (f"[clamp]\nnodes = {LEFT}", "[clamp]", "clamp: give exactly one of group, box, nodes"),
        (f"[clamp]\nnodes = {LEFT}", "[clamp]\nnodes = [4]", "clamp: .* holds 1 node at one place, and the body can still turn"),
        (f"[clamp]\nnodes = {LEFT}", '[clamp]\ngroup = "wall"', "clamp: the mesh has no group 'wall'; there are none"),
        (
            f"[interface_points.tip]\nnodes = {RIGHT}",
            "[interface_points.tip]\nbox = [2.0, 0.0, 3.0, 1.0]",
            "tip: box .* holds no node",
        ),
        (f"[interface_points.tip]\nnodes = {RIGHT}", "[interface_points.tip]\nnodes = [999]", "no element has node 999"),
        (f"[interface_points.tip]\nnodes = {RIGHT}", "[interface_points.tip]\nbox = [1, 1, 0, 0]", "turned inside out"),
        ('tie = "averaged"', 'tie = "glued"', "interface_points.tip.tie: "),
        (f'nodes = {RIGHT}\ntie = "averaged"', f'nodes = {RIGHT[:1]}\ntie = "rigid"', "alone ties no rotation"),
        (f'nodes = {RIGHT}\ntie = "averaged"', f'nodes = {[*RIGHT, LEFT[0]]}\ntie = "rigid"', "shares nodes with the clamp"),
        ("count = 3", "count = 300", "300 modes cannot be taken: the mesh has"),
        (BASIS, 'kind = "eigenmodes"\nboundary = "free"\ncount = 3', "floats about mean axes; leave .clamp. out"),
        (BASIS, BASIS + f"\n[interface_points.end]\nnodes = {RIGHT}", "cannot move independently"),
    ],
)
def test_wrong_bodies_are_refused_by_name(old, new, message, tmp_path):
    path = write_body(tmp_path, MESH, BASIS)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=message):
        build(path)


def _other(name: str, change: Callable) -> Callable[[Path], None]:
    def write(folder: Path) -> None:
        sparse.save_npz(folder / f"{name}.npz", sparse.csr_array(change(sparse.load_npz(folder / f"{name}.npz").tolil())))

    return write


def _asymmetric(matrix):
    matrix[0, 1] = 2 * abs(matrix).max()
    return matrix


def _supported(matrix):
    matrix[0, 0] = 2 * matrix[0, 0]
    return matrix


def _rotary(matrix):
    matrix[1, 1] = 2 * matrix[1, 1]
    return matrix


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (_other("mass", lambda matrix: matrix[:10, :10]), r"matrices.mass: the matrix .* of shape \(10, 10\) needs 106 columns"),
        (_other("stiffness", _asymmetric), "matrices.stiffness: .* is not symmetric"),
        (_other("stiffness", _supported), "resists a rigid motion .x. by"),
        (_other("mass", _rotary), "treats x and y differently"),
        (lambda folder: (folder / "mass.npz").unlink(), "there is no file '.*mass.npz'"),
        (lambda folder: (folder / "mass.npz").write_text("no matrix"), "cannot be read as a matrix"),
        (lambda folder: np.savetxt(folder / "nodes.csv", np.eye(3), delimiter=","), "section: this body is spatial"),
        (lambda folder: (folder / "nodes.csv").write_text("a,b\n"), "cannot be read as the coordinates of nodes"),
    ],
)
def test_wrong_matrices_are_refused_by_name(spoil, message, tmp_path):
    path = write_matrices(tmp_path, "npz")
    spoil(tmp_path)
    with pytest.raises(InputError, match=message):
        build(path)
