"""Finished matrices of other programs: read whole in every way that these write them, or refused by the line; compared with the mesh."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

from preprocessing import build
from preprocessing.builders.body_recipe import BodyRecipe
from preprocessing.builders.discrete_body import lame_factors
from preprocessing.elements.elasticity import solid_matrices
from preprocessing.elements.solid_elements import element_blocks
from preprocessing.elements.uniform_material import uniform_strains, volume_of
from preprocessing.mesh.matrix_file import read_array, read_nodes, square_of
from preprocessing.mesh.mesh_file import read_mesh
from preprocessing.mesh.solid_mesh import SolidMesh
from tests.models.solid_bodies import DENSITY, MODULUS, SPATIAL_KINDS, WIDTH, box, rectangle, write_body
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.model import ReducedModel

pytestmark = pytest.mark.usefixtures("read_here")

BAR = Path(__file__).parents[1] / "data" / "calculix_bar"
"""A bar of three C3D8, 1.5 x 0.5 x 0.4 m of steel, node numbers with gaps and in no order, and its matrices by CalculiX 2.20."""
FREQUENCIES = [189.8108, 215.4491, 533.2435, 904.7772]
"""Of this bar with its left end clamped, by *FREQUENCY of CalculiX 2.20."""


def bar() -> SolidMesh:
    """The mesh of the deck."""
    return read_mesh(BAR / "bar.inp")


def own_matrices(mesh: SolidMesh, lame: tuple[float, float] | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness by the elements of this program, dense."""
    found = solid_matrices(element_blocks(mesh), len(mesh.nodes), mesh.dimension)
    first, shear = lame or lame_factors(0.3, "space" if mesh.dimension == 3 else "plane-stress")
    width = 1.0 if mesh.dimension == 3 else WIDTH
    stiffness = width * MODULUS * (first * found.first + shear * found.shear)
    return width * DENSITY * np.kron(found.scalar_mass.toarray(), np.eye(mesh.dimension)), stiffness.toarray()


def clamped_frequencies(mass: np.ndarray, stiffness: np.ndarray, mesh: SolidMesh) -> np.ndarray:
    """The lowest ones, in Hz, with the left end clamped."""
    free = np.setdiff1d(np.arange(mesh.n), np.add.outer(3 * mesh.groups["LEFT"], np.arange(3)))
    values = eigh(stiffness[np.ix_(free, free)], mass[np.ix_(free, free)], eigvals_only=True)
    return np.sqrt(values[: len(FREQUENCIES)]) / (2 * np.pi)


TRIANGLES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "lower": np.tril,
    "upper": np.triu,
    "both": np.array,
    "one of each pair": lambda a: np.where(np.add.outer(np.arange(len(a)), np.arange(len(a))) % 2, np.tril(a), np.triu(a)),
}


def text_of(matrix: np.ndarray, layout: str, labels: np.ndarray | None = None, d: int = 3, separator: str = ", ") -> str:
    """Lines of Abaqus, with labels or in the order of rising labels."""
    labels = np.arange(1, len(matrix) // d + 1) if labels is None else labels
    place = np.empty(len(labels), int)
    place[np.argsort(labels)] = np.arange(len(labels))
    lines = []
    for i, j in zip(*np.nonzero(matrix), strict=True):
        (a, x), (b, y) = divmod(int(i), d), divmod(int(j), d)
        if layout == "labels":
            fields = [labels[a], x + 1, labels[b], y + 1]
        else:
            fields = [d * place[a] + x + 1, d * place[b] + y + 1]
        lines.append(separator.join([*map(str, fields), f"{matrix[i, j]:.16e}"]))
    return "\n".join(lines) + "\n"


def test_calculix_and_its_own_frequencies(tmp_path):
    """Two programs' frequencies of one pair of matrices, whose rows the .dof file alone explains."""
    mesh = bar()
    mass, stiffness = (square_of(BAR / f"bar.{e}", 16, 3, mesh.labels, BAR / "bar.dof")[0].toarray() for e in ("mas", "sti"))
    np.testing.assert_allclose(clamped_frequencies(mass, stiffness, mesh), FREQUENCIES, rtol=1e-6)  # its seven digits
    np.testing.assert_allclose(mass, own_matrices(mesh)[0], atol=1e-9 * mass.max())
    order = np.random.default_rng(1).permutation(48)  # the rows in any order, with as many lines of .dof
    degrees = np.array((BAR / "bar.dof").read_text().split())
    (tmp_path / "any.dof").write_text("\n".join(degrees[order]))
    place = np.empty(48, int)
    place[order] = np.arange(48)
    rows = np.loadtxt(BAR / "bar.sti")
    moved = np.column_stack([place[rows[:, 0].astype(int) - 1] + 1, place[rows[:, 1].astype(int) - 1] + 1, rows[:, 2]])
    np.savetxt(tmp_path / "any.sti", moved, fmt=["%d", "%d", "%.17g"])
    again = square_of(tmp_path / "any.sti", 16, 3, mesh.labels, tmp_path / "any.dof")[0]
    np.testing.assert_array_equal(again.toarray(), stiffness)


@pytest.mark.parametrize("triangle", TRIANGLES)
@pytest.mark.parametrize("layout", ["labels", "coordinate"])
def test_texts_of_abaqus_give_one_matrix(tmp_path, layout, triangle):
    """Of a mesh in no order, whose labels have gaps: either triangle, or both."""
    mesh = bar()
    for matrix in own_matrices(mesh):
        matrix = (matrix + matrix.T) / 2
        path = tmp_path / "matrix.mtx"
        path.write_text(
            text_of(TRIANGLES[triangle](matrix), layout, mesh.labels, separator="  " if layout == "coordinate" else ", ")
        )
        found, remark = square_of(path, 16, 3, mesh.labels)
        np.testing.assert_allclose(found.toarray(), matrix, rtol=1e-15)  # 17 digits
        assert remark == ""


def test_labels_without_a_mesh_count_in_rising_order_and_this_is_told(tmp_path):
    matrix = own_matrices(bar())[1]
    labels = 101 + 3 * np.arange(16)
    (tmp_path / "matrix.mtx").write_text(
        "** of Abaqus\n*MATRIX INPUT, NAME=K, TYPE=SYMMETRIC\n" + text_of(np.tril(matrix), "labels", labels)
    )
    found, remark = square_of(tmp_path / "matrix.mtx", 16, 3)
    np.testing.assert_allclose(found.toarray(), matrix, rtol=1e-15, atol=1e-3)
    assert "from 101 to 146" in remark
    with pytest.raises(InputError, match="names 16 nodes, and the body has 17"):
        square_of(tmp_path / "matrix.mtx", 17, 3)


UNIT = "1 1 1.0\n2 2 1.0\n3 3 1.0\n4 4 1.0\n"
ABAQUS = "1,1,1,1,1.0\n1,2,1,2,1.0\n2,1,2,1,1.0\n2,2,2,2,1.0\n"
MARKET = "%%MatrixMarket matrix coordinate real symmetric\n4 4 4\n" + UNIT
TEXTS: dict[str, tuple[str, str]] = {
    "letters behind a number": (MARKET.replace("2 2 1.0", "2 2 1.0abc"), "line 4 has a field, number 3, that is no finite real"),
    "decimal comma": (MARKET.replace("2 2 1.0", "2 2 1,0"), "line 4 holds a comma .* write decimal points"),
    "more than a line": (MARKET.replace("4 4 1.0\n", "4 4 1.0 4 3 2.0\n"), "line 6 has 6 fields instead of 3"),
    "fewer entries": (MARKET.replace("4 4 1.0\n", ""), "claims 4 entries, and holds 3"),
    "more entries": (MARKET + "4 3 1.0\n", "claims 4 entries, and holds 5"),
    "an index beyond the size": (MARKET.replace("2 2 1.0", "2 5 1.0"), "line 4 is outside of its 4 rows and 4 columns"),
    "a fraction of a row": (MARKET.replace("2 2 1.0", "2.5 2 1.0"), "line 4 has a fraction"),
    "both triangles of a symmetric one": (
        MARKET.replace("4 4 4", "4 4 6") + "2 1 3.0\n1 2 3.0\n",
        "symmetric, and holds entries on both",
    ),
    "skew-symmetric": (MARKET.replace("symmetric", "skew-symmetric"), "it is skew-symmetric; real matrices are needed"),
    "hermitian": (MARKET.replace("real symmetric", "complex hermitian"), "it is complex; real matrices"),
    "pattern": (MARKET.replace("real", "pattern"), "it is pattern"),
    "another word": (MARKET.replace("real", "secret"), "a word that the format does not know"),
    "whole numbers that are none": (MARKET.replace("real", "integer").replace("2 2 1.0", "2 2 1.5"), "line 4 has a fraction"),
    "beyond 1e308": (MARKET.replace("2 2 1.0", "2 2 1e999"), r"line 4 has a number, in field 3, beyond 1e308"),
    "a letter that looks like a digit": (MARKET.replace("2 2 1.0", "2 2 \u0661"), "line 4 holds characters that are neither"),
    "no diagonal": (UNIT.replace("4 4 1.0\n", ""), "no line has row 4, one of 1 that are missing of 4"),
    "too many rows": (UNIT + "5 5 1.0\n", "line 5 has no row and column from 1 to 4"),
    "half a row": (UNIT + "1.5 1 1.0\n", "line 5 has no row and column"),
    "a row from zero": (UNIT + "0 1 1.0\n", "line 5 has no row and column"),
    "a place twice": (UNIT + "2 2 1.0\n", "line 5 gives a place that another line gave before"),
    "half of a triangle": (UNIT + "1 2 3.0\n2 1 3.0\n3 4 5.0\n", "1 of them on one side only"),
    "sides that differ": (UNIT + "1 2 3.0\n2 1 4.0\n", "not symmetric"),
    "a rotation": (ABAQUS + "1,6,1,6,1.0\n", "line 5 has a direction beyond 1 to 2: it is a rotation"),
    "an internal node": (ABAQUS + "-1,1,-1,1,1.0\n", "line 5 has a node below 1: Abaqus numbers so what it adds itself"),
    "a direction too few": (ABAQUS.replace("2,2,2,2,1.0\n", ""), "no line names direction 2 of node 2"),
    "four fields": ("1,1,1,1\n", "line 1 has 4 fields instead of 3 or 5"),
    "nan": (ABAQUS.replace("2,1,2,1,1.0", "2,1,2,1,nan"), "line 3 has a field, number 5, that is no finite real number"),
    "two matrices": ("*MATRIX INPUT, NAME=K\n" + ABAQUS + "*MATRIX INPUT, NAME=M\n" + ABAQUS, "line 6 is a keyword"),
    "a factor": ("*MATRIX INPUT, NAME=K, SCALE FACTOR=2.\n" + ABAQUS, "line 1 is a keyword"),
    "of one element": ("*USER ELEMENT, NODES=2, LINEAR\n" + ABAQUS, "line 1 is a keyword"),
    "nothing": ("** nothing\n", "no line of numbers"),
    "an empty file": ("", "no line of numbers"),
    "zero bytes": ("1\0 1 1.0\n", "zero bytes"),
}


@pytest.mark.parametrize("kind", TEXTS)
def test_a_text_that_is_not_wholly_a_matrix_is_refused_by_its_line(tmp_path, kind):
    text, message = TEXTS[kind]
    (tmp_path / "matrix.mtx").write_text(text)
    with pytest.raises(InputError, match=rf"matrix\.mtx'.*{message}"):
        square_of(tmp_path / "matrix.mtx", 2, 2)


SAME: dict[str, str] = {
    "as it is": MARKET,
    "exponents of Fortran": MARKET.replace("1.0", "1.0D+00"),
    "lower-case exponents of Fortran": MARKET.replace("1.0", "10.d-1"),
    "comments and blank lines": MARKET.replace("4 4 4", "% of it, in 1 2 3\n\n4 4 4\n\n").replace("3 3", "% 5 5 7.0\n3 3"),
    "windows": MARKET.replace("\n", "\r\n"),
    "upper case": MARKET.replace(
        "%%MatrixMarket matrix coordinate real symmetric", "%%MatrixMarket MATRIX Coordinate REAL Symmetric"
    ),
    "whole numbers": MARKET.replace("real", "integer").replace("1.0", "1"),
    "no last end of a line": MARKET.rstrip(),
    "dense": "%%MatrixMarket matrix array real general\n4 4\n" + "\n".join(map(str, np.eye(4).ravel())),
    "dense triangle": "%%MatrixMarket matrix array real symmetric\n4 4\n" + "1\n0\n0\n0\n1\n0\n0\n1\n0\n1",
    "rows and columns": UNIT,
    "rows and columns with commas": UNIT.replace(" ", ","),
    "rows and columns with tabs": UNIT.replace(" ", "\t"),
    "nodes and directions": ABAQUS,
    "nodes and directions with blanks": ABAQUS.replace(",", "  "),
    "nodes and directions of Fortran": ABAQUS.replace("1.0", "1.0D0"),
}


@pytest.mark.parametrize("kind", SAME)
def test_spellings_of_one_matrix(tmp_path, kind):
    (tmp_path / "matrix.mtx").write_bytes(SAME[kind].encode())
    np.testing.assert_array_equal(square_of(tmp_path / "matrix.mtx", 2, 2)[0].toarray(), np.eye(4))


TABLES: dict[str, tuple[str, str]] = {
    "semicolons": ("1,0;2,0\n3,0;4,0\n", "line 1 holds a semicolon; write a comma between two numbers"),
    "decimal commas with blanks": ("1,5 2,5\n3,5 4,5\n", "line 1 has a field, number 2, that is no finite"),
    "words": ("node,x,y\n1,2,3\n", "line 1 has a field, number 1, that is no finite"),
    "a line that is longer": ("1,2\n3,4,5\n", "line 2 has 3 fields instead of 2"),
    "an empty field": ("1,2\n3,\n", "line 2 has a field, number 2"),
    "nan": ("1,2\n\n3,nan\n", "line 3 has a field, number 2"),
    "letters behind": ("# x, y\n1,2.0abc\n", "line 2 has a field, number 2"),
    "a header in the middle": ("1,2\nx,y\n", "line 2 has a field, number 1"),
}


@pytest.mark.parametrize("kind", TABLES)
def test_a_table_that_is_not_wholly_of_numbers_is_refused_by_its_line(tmp_path, kind):
    text, message = TABLES[kind]
    (tmp_path / "nodes.csv").write_text(text)
    with pytest.raises(InputError, match=rf"nodes\.csv' cannot be read as .*{message}"):
        read_nodes(tmp_path / "nodes.csv")


def test_spellings_of_one_table(tmp_path):
    for text in (
        "1,2\n3,4\n",
        "x,y\n1,2\n3,4",
        '\ufeff"X", "Y"\r\n1.0D0,2\r\n3,4\r\n',
        "# of nodes\n1, 2 # the first\n3,4\n",
        "1 2\n3\t4\n",
    ):
        (tmp_path / "nodes.csv").write_text(text, newline="")
        np.testing.assert_array_equal(read_nodes(tmp_path / "nodes.csv"), [[1, 2], [3, 4]])


def test_an_archive_of_several_arrays_is_not_taken_for_its_first(tmp_path):
    np.savez(tmp_path / "nodes.npz", labels=np.eye(3), nodes=np.eye(2))
    with pytest.raises(InputError, match="it holds 2 arrays, and it is not clear which of them is meant"):
        read_array(tmp_path / "nodes.npz", "numbers")


DEGREES: dict[str, tuple[Callable[[str], str], str]] = {
    "supports": (lambda text: text.replace("101.2\n", ""), "to 47, the number of the lines of its .dof file"),
    "a rotation": (lambda text: text.replace("101.2\n", "101.4\n"), "line 2 of its .dof file has direction 4"),
    "a number": (
        lambda text: text.replace("101.2\n", "1012\n"),
        "line 2 of its .dof file is not a node, a point and a direction",
    ),
    "twice": (lambda text: text.replace("101.2\n", "101.1\n"), "has a direction of a node twice"),
    "of another node": (lambda text: text.replace("101.2\n", "100.2\n"), "lacks direction 1 of node 100, one of 3"),
    "of another mesh": (lambda text: text.replace("101.", "100."), "names node 100, which no element of the mesh has"),
}


@pytest.mark.parametrize("kind", DEGREES)
def test_degrees_that_are_not_those_of_the_matrix_are_refused(tmp_path, kind):
    change, message = DEGREES[kind]
    (tmp_path / "bar.dof").write_text(change((BAR / "bar.dof").read_text()))
    with pytest.raises(InputError, match=message):
        square_of(BAR / "bar.sti", 16, 3, bar().labels, tmp_path / "bar.dof")


def test_degrees_of_files_that_need_none_are_refused(tmp_path):
    (tmp_path / "matrix.mtx").write_text(MARKET)
    (tmp_path / "abaqus.mtx").write_text(ABAQUS)
    (tmp_path / "any.dof").write_text("1.1\n1.2\n2.1\n2.2\n")
    for name, message in (
        ("matrix", "this is none; leave matrices.dof out"),
        ("abaqus", "need no .dof file; leave matrices.dof out"),
    ):
        with pytest.raises(InputError, match=message):
            square_of(tmp_path / f"{name}.mtx", 2, 2, None, tmp_path / "any.dof")


def test_nodes_that_only_the_mesh_has_are_named():
    mesh = bar()
    with pytest.raises(InputError, match=r"lacks node 500 of the mesh\. Give matrices and mesh of one model, free of supports"):
        square_of(BAR / "bar.sti", 17, 3, np.append(mesh.labels, 500), BAR / "bar.dof")


@pytest.fixture
def body(tmp_path) -> Path:
    """body.toml of the bar of CalculiX."""
    for ending in ("inp", "sti", "mas", "dof"):
        shutil.copy(BAR / f"bar.{ending}", tmp_path)
    path = tmp_path / "body.toml"
    path.write_text(
        'units = "m-kg-s"\nmesh.file = "bar.inp"\nmatrices = { mass = "bar.mas", stiffness = "bar.sti" }\n'
        "material = { youngs_modulus = 2.1e11, density = 7800.0, poisson_ratio = 0.3 }\n"
        'clamp.group = "LEFT"\ninterface_points.tip = { group = "RIGHT", tie = "rigid" }\n'
        'basis = { kind = "craig-bampton", count = 2, derivative = "frozen" }\n'
    )
    return path


def changed(path: Path, old: str, new: str) -> Path:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    return path


def mass_at(model: ReducedModel, **values: float) -> float:
    """The mass at other values of the parameters."""
    return float(model.affine["mass"](np.array([*{**model.nominal, **values}.values()]), 1)[0])


def test_a_body_of_calculix_is_known_by_all_three_files(body):
    model, before = build(body), BodyRecipe.read(body).hash()
    np.testing.assert_allclose(model.invariants.mass, 7800 * 1.5 * 0.5 * 0.4, rtol=1e-12)
    np.testing.assert_allclose(model.invariants.first_moment[:, 0] / model.invariants.mass, [0.75, 0.25, 0.2], rtol=1e-12)
    np.testing.assert_allclose(mass_at(model, density=7801.0) - mass_at(model), 1.5 * 0.5 * 0.4, rtol=1e-9)
    np.testing.assert_allclose(model.interfaces["tip"].position[0, :, 0], [1.5, 0.25, 0.2])
    with (body.parent / "bar.dof").open("a") as file:
        file.write("\n")
    assert BodyRecipe.read(body).hash() != before
    (body.parent / "bar.dof").rename(body.parent / "other.dof")
    with pytest.raises(InputError, match=r"CalculiX writes 'bar\.dof' beside 'bar\.mas'"):
        build(body)
    changed(body, 'stiffness = "bar.sti"', 'stiffness = "bar.sti", dof = "other.dof"')
    np.testing.assert_array_equal(build(body).invariants.stiffness, model.invariants.stiffness)


MATERIALS: dict[str, tuple[str, str, str]] = {
    "density": (
        "density = 7800.0",
        "density = 2700.0",
        "a mass of 2340, but density times volume of the mesh is 810: the ratio is 2.88889",
    ),
    "density of another steel": ("density = 7800.0", "density = 7850.0", "with a density of 7800"),
    "unit of mass": ("density = 7800.0", "density = 7.8", r"ratio is 1000, 10\^3, as of other units"),
    "modulus": (
        "2.1e11",
        "2.0e11",
        r"Young's modulus 2.1e\+11 and Poisson's ratio 0.3, .* has 2e\+11 and 0.3: the ratio of the moduli is 1.05",
    ),
    "ratio": ("poisson_ratio = 0.3", "poisson_ratio = 0.29", r"Poisson's ratio 0.3, .* has 2.1e\+11 and 0.29"),
    "unit of stress": ("2.1e11", "2.1e5", r"moduli is 1e\+06, 10\^6, as of other units"),
    "modulus alone": ("2.1e11, density = 7800.0, poisson_ratio = 0.3", "2.0e11, density = 7800.0", r"has 2e\+11: the ratio"),
    "swapped": (
        'mass = "bar.mas", stiffness = "bar.sti"',
        'mass = "bar.sti", stiffness = "bar.mas"',
        "the two files are swapped",
    ),
}


@pytest.mark.parametrize("kind", MATERIALS)
def test_a_material_that_is_not_that_of_the_matrices_is_refused_with_the_ratio(body, kind):
    with pytest.raises(InputError, match=f"matrices: .*{MATERIALS[kind][2]}"):
        build(changed(body, *MATERIALS[kind][:2]))


def test_a_point_mass_that_mesh_and_matrices_have_follows_no_density(body):
    """100 kg on one node, in the deck and in its matrices: the rest, 2340 kg, is density times volume."""
    row = 1 + (BAR / "bar.dof").read_text().split().index("122.1")
    lump = "*ELEMENT, TYPE=MASS, ELSET=LUMP\n9, 122\n*MASS, ELSET=LUMP\n100.\n*MATERIAL"
    changed(body.parent / "bar.inp", "*MATERIAL", lump)
    with pytest.raises(InputError, match="does not hold the concentrated masses of the mesh file"):
        build(body)
    mass = np.loadtxt(body.parent / "bar.mas")
    mass[(mass[:, 0] == mass[:, 1]) & (mass[:, 0] >= row) & (mass[:, 0] < row + 3), 2] += 100.0
    np.savetxt(body.parent / "bar.mas", mass, fmt=["%d", "%d", "%.17g"])
    model = build(body)
    density = model.nominal["density"]
    np.testing.assert_allclose(model.invariants.mass, 2440.0, rtol=1e-12)
    np.testing.assert_allclose(mass_at(model, density=2 * density), 4780.0, rtol=1e-12)


def test_a_mass_that_differs_on_purpose_has_a_scale(body):
    """A point mass of 100 kg in the matrices alone: the derivative by density is known no more, that by the scale is."""
    row = 1 + (BAR / "bar.dof").read_text().split().index("122.1")
    mass = np.loadtxt(body.parent / "bar.mas")
    mass[(mass[:, 0] == mass[:, 1]) & (mass[:, 0] >= row) & (mass[:, 0] < row + 3), 2] += 100.0
    np.savetxt(body.parent / "bar.mas", mass, fmt=["%d", "%d", "%.17g"])
    with pytest.raises(InputError, match=r"mass of 2440, but .* is 2340: .* set matrices.mass_differs = true"):
        build(body)
    changed(body, 'stiffness = "bar.sti"', 'stiffness = "bar.sti", mass_differs = true')
    model = build(body)
    assert {"mass_scale", "youngs_modulus"} <= set(model.nominal)
    assert "density" not in model.nominal
    np.testing.assert_allclose(model.invariants.mass, 2440.0, rtol=1e-12)
    np.testing.assert_allclose(mass_at(model, mass_scale=2.0), 4880.0, rtol=1e-12)


def plane_body(folder: Path, more: str, state: str, added: float = 0.0) -> Path:
    """A rectangle of curved quadrilaterals with finished matrices beside its mesh, and a mass at its last node."""
    mesh = rectangle("quad8", (3, 2), 1.0, 0.3, bent=0.01)
    path = write_body(folder, mesh, tie="rigid")
    mass, stiffness = own_matrices(mesh, lame_factors(0.3, state))
    mass[-2:, -2:] += added * np.eye(2)
    for name, matrix in {"mass": mass, "stiffness": stiffness}.items():
        (folder / f"{name}.mtx").write_text(text_of(np.tril(matrix), "labels", d=2))
    changed(path, "[damping]", f'[matrices]\nmass = "mass.mtx"\nstiffness = "stiffness.mtx"\n{more}\n[damping]')
    return path


def test_matrices_of_the_plane_are_compared_by_their_state(tmp_path):
    path = plane_body(tmp_path, "", "plane-strain")
    with pytest.raises(InputError, match=r"Poisson's ratio 0.4285.*has 2.1e\+11 and 0.3"):
        build(path)
    build(changed(path, "poisson_ratio = 0.3", 'poisson_ratio = 0.3\nstate = "plane-strain"'))
    build(changed(path, 'poisson_ratio = 0.3\nstate = "plane-strain"', ""))  # the modulus fits one of the two states
    with pytest.raises(InputError, match=r"density times volume times width of the mesh is .*the ratio is 0.9,"):
        build(changed(path, "width = 0.05", f"width = {0.05 / 0.9}"))


def test_a_mass_that_differs_does_not_grow_with_the_width(tmp_path):
    model = build(plane_body(tmp_path, "mass_differs = true", "plane-stress", added=10.0))
    whole = model.invariants.mass
    assert whole > 10.0 + DENSITY * WIDTH * 0.29
    np.testing.assert_allclose(mass_at(model, mass_scale=2.0), 2 * whole, rtol=1e-12)
    np.testing.assert_allclose(mass_at(model, width=2.0), whole, rtol=1e-12)


def without_mesh(body: Path) -> Path:
    """The same body with its nodes in a table, in the rising order of their numbers."""
    mesh = bar()
    np.savetxt(body.parent / "nodes.csv", mesh.nodes[np.argsort(mesh.labels)], delimiter=",")
    changed(body, 'mesh.file = "bar.inp"\n', "")
    changed(body, 'stiffness = "bar.sti"', 'stiffness = "bar.sti", nodes = "nodes.csv"')
    changed(body, 'clamp.group = "LEFT"', "clamp.box = [-1, -1, -1, 0.1, 1, 1]")
    return changed(body, 'group = "RIGHT"', "box = [1.4, -1, -1, 1.6, 1, 1]")


NODES_ALONE: dict[str, tuple[str, str, str]] = {
    "too heavy": (
        "density = 7800.0",
        "density = 780.0",
        "a mass of 2340, which is density times a volume of 3, and all nodes lie within 0.3",
    ),
    "a density that does not fit to the modulus": (
        "density = 7800.0",
        "density = 8000.0",
        "of a volume of mass by density say, .* is 1.02564",
    ),
    "a modulus that does not fit to the density": (
        "2.1e11",
        "2.0e11",
        "Young's modulus 2.1e.11 and Poisson's ratio 0.3, .* is 1.05",
    ),
}


@pytest.mark.parametrize("kind", NODES_ALONE)
def test_matrices_of_nodes_alone_are_compared_with_each_other(body, kind):
    told: list[str] = []
    found = BodyRecipe.read(without_mesh(body)).build(told.append)
    np.testing.assert_allclose(found.invariants.mass, 2340.0, rtol=1e-12)
    assert told == [text for text in told if "from 101 to 230" in text and len(told) == 1]
    with pytest.raises(InputError, match=NODES_ALONE[kind][2]):
        build(changed(body, *NODES_ALONE[kind][:2]))


def test_a_mass_matrix_in_another_order_of_nodes_has_another_centre(body):
    """The nodes of the heavy middle and of the ends exchanged, which keeps the whole mass."""
    text = (body.parent / "bar.dof").read_text()
    mass = np.loadtxt(body.parent / "bar.mas")
    labels = [int(line.partition(".")[0]) for line in text.split()[::3]]
    exchanged = [*labels]
    for one, other in ((140, 160), (121, 230), (130, 101), (122, 111)):
        i, j = labels.index(one), labels.index(other)
        exchanged[i], exchanged[j] = exchanged[j], exchanged[i]
    mesh = bar()
    number = {label: k for k, label in enumerate(mesh.labels.tolist())}
    rows = np.array([3 * number[label] + axis for label in exchanged for axis in range(3)])
    dense = np.zeros((48, 48))
    dense[rows[mass[:, 0].astype(int) - 1], rows[mass[:, 1].astype(int) - 1]] = mass[:, 2]
    (body.parent / "mass.mtx").write_text(text_of(np.triu(dense + dense.T - np.diag(np.diag(dense))), "labels", mesh.labels))
    with pytest.raises(
        InputError,
        match=r"has its centre at \(0.833333, 0.25, 0.2\), and the elements of the mesh have theirs at \(0.75, 0.25, 0.2\)",
    ):
        build(changed(body, 'mass = "bar.mas"', 'mass = "mass.mtx"'))


@pytest.mark.parametrize("kind", SPATIAL_KINDS)
def test_uniform_strains_measure_every_element_also_a_curved_one(kind):
    """u . K u = V eps : C : eps to round-off, where mesh and matrices come from one quadrature."""
    mesh = box(kind, (2, 1, 1), (1.0, 0.4, 0.3), bent=0.02)
    _, stiffness = own_matrices(mesh)
    volume = volume_of(element_blocks(mesh))
    strains = uniform_strains(mesh.nodes - volume.centre)
    first, shear = (MODULUS * factor for factor in lame_factors(0.3, "space"))
    normal = np.repeat([1.0, 0.0], 3)
    meant = volume.size * (first * np.outer(normal, normal) + shear * np.diag(1 + normal))
    np.testing.assert_allclose(strains.T @ stiffness @ strains, meant, atol=1e-9 * meant.max())
    assert volume.doubt < 0.05
