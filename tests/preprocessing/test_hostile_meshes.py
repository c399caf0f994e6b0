"""Meshes and matrices of other programs that crash, exhaust or hang their readers: one error in words, and nothing else.

The nightly run `python -m tests.fuzz.nightly` looks for more of them.
"""

from __future__ import annotations

import os
import pickle
import resource
import signal
import sys
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy import sparse
from typer.testing import CliRunner

from preprocessing import build
from preprocessing.airfoil.airfoil_file import read_airfoil
from preprocessing.builders.body_recipe import BodyRecipe
from preprocessing.builders.skin_recipe import SkinRecipe
from preprocessing.commands.cli import main
from preprocessing.elements.solid_elements import element_blocks
from preprocessing.mesh.matrix_file import read_array, read_matrix, read_nodes, square_of
from preprocessing.mesh.mesh_file import read_mesh
from preprocessing.mesh.solid_mesh import SolidMesh
from tests.models.solid_bodies import rectangle, write_body
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.command_line.cli import app
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError, ModelFileError
from toolkit.reduced_model.file import load

WING = Path(__file__).parents[2] / "models" / "morphing_wing"
PLATE = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n*ELEMENT, TYPE=CPS4\n1, 1, 2, 3, 4\n*NSET, NSET=held\n1, 4\n"
WALL = 40
"""Seconds that no case takes; what waits for ever fails instead."""


@pytest.fixture(autouse=True)
def _ends() -> Iterator[None]:
    """No case waits for ever, or takes all memory."""

    def late(*_: object) -> None:
        raise AssertionError(f"no end within {WALL} s")

    before, limit = signal.signal(signal.SIGALRM, late), resource.getrlimit(resource.RLIMIT_AS)
    signal.alarm(WALL)
    taken = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (taken + 2 * 2**30, limit[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, limit)
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def archive(folder: Path, **changed: object) -> Path:
    """A matrix of 4 rows in SciPy's format with other arrays; None takes one out."""
    matrix = sparse.csr_array(np.diag([1.0, 2, 3, 4]))
    arrays = {
        "format": b"csr",
        "shape": matrix.shape,
        "data": matrix.data,
        "indices": matrix.indices,
        "indptr": matrix.indptr,
        **changed,
    }
    path = folder / "matrix.npz"
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    return path


DIAGONALS = {"indices": None, "indptr": None, "format": b"dia", "offsets": np.array([0])}
BLOCKS = {"format": b"bsr", "data": np.ones((2, 2, 2)), "indices": np.array([0, 1]), "indptr": np.array([0, 1, 2])}
ARCHIVES: dict[str, tuple[dict[str, object], str]] = {
    "index beyond the columns": ({"indices": np.array([0, 1, 2, 10**9])}, "outside of its shape"),
    "negative index": ({"indices": np.array([0, 1, 2, -5])}, "outside of its shape"),
    "indptr that falls": ({"indptr": np.array([0, 4, 1, 2, 4])}, "indptr does not rise"),
    "indptr beyond the entries": ({"indptr": np.array([0, 1, 2, 3, 10**9])}, "indptr does not rise"),
    "indptr that is too short": ({"indptr": np.array([0, 4])}, "indptr does not rise"),
    "column of a csc beyond the rows": ({"format": b"csc", "indices": np.array([0, 1, 2, 10**7])}, "outside of its shape"),
    "block beyond the columns": ({**BLOCKS, "indices": np.array([0, 10**8])}, "outside of its shape"),
    "blocks that fall": ({**BLOCKS, "indptr": np.array([0, 2, 1])}, "indptr does not rise"),
    "blocks of no size": ({**BLOCKS, "data": np.ones((2, 0, 2))}, "do not divide"),
    "diagonals without offsets": ({**DIAGONALS, "data": np.ones((3, 4))}, "diagonals do not fit"),
    "shape of terabytes": ({"shape": (10**12, 4), "indptr": np.array([0, 4])}, "indptr does not rise"),
    "entries that are no numbers": ({"data": np.array([1j, 2, 3, 4])}, "finite real numbers"),
    "no shape": ({"shape": None}, "cannot be read as a matrix"),
    "rows without entries": (
        {"format": b"coo", "row": np.zeros(4, int), "col": np.arange(4), "shape": (10**12, 4)},
        "claims 10+ rows for 4",
    ),
    "values without axes": (
        {"format": b"coo", "row": np.arange(4), "col": np.arange(4), "data": np.array(3.0)},
        "no lines of one length",
    ),
}


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("kind", ARCHIVES)
def test_an_archive_whose_parts_do_not_fit_together_is_refused_before_compiled_code_sees_it(tmp_path, kind):
    changed, message = ARCHIVES[kind]
    with pytest.raises(InputError, match=rf"matrix\.npz'.*{message}"):
        read_matrix(archive(tmp_path, **changed), 4)


def diagonal(folder: Path, kind: str) -> Path:
    matrix = sparse.csr_array(np.kron(np.diag([1.0, 2.0]), np.ones((2, 2)))).asformat(kind)
    sparse.save_npz(folder / "matrix.npz", matrix)
    return folder / "matrix.npz"


@pytest.mark.parametrize("kind", ["csr", "csc", "bsr", "coo", "dia"])
def test_archives_of_all_formats_are_read_as_they_were_written(tmp_path, kind):
    found = square_of(diagonal(tmp_path, kind), 2, 2)[0]
    np.testing.assert_array_equal(found.toarray(), np.kron(np.diag([1.0, 2.0]), np.ones((2, 2))))


MARKETS = {
    "zero byte": (b"%%MatrixMarket matrix coordinate real general\n4 4 1\n1\0 1 3.0\n", "holds zero bytes"),
    "entries that it cannot hold": (
        b"%%MatrixMarket matrix coordinate real general\n4 4 99999999999\n1 1 3\n",
        "claims 99999999999 entries",
    ),
    "a dense one that it cannot hold": (
        b"%%MatrixMarket matrix array real general\n1000000 1000000\n1\n",
        "claims 500000000000 entries",
    ),
    "no size": (b"%%MatrixMarket matrix coordinate real general\nx\n", "how many rows"),
    "a row of terabytes": (
        b"%%MatrixMarket matrix coordinate real general\n999999999999 4 1\n1 1 3\n",
        "claims 999999999999 rows",
    ),
    "no entries": (b"%%MatrixMarket matrix coordinate real symmetric\n4 4 0\n", "no entry larger than 0"),
    "entries of 1e308": (b"%%MatrixMarket matrix coordinate real symmetric\n4 4 1\n1 1 1e308\n", r"beyond 1e\+60"),
    "entries of 1e-300": (b"%%MatrixMarket matrix coordinate real symmetric\n4 4 1\n1 1 1e-300\n", "no entry larger than 1e-300"),
    "nan": (b"%%MatrixMarket matrix coordinate real symmetric\n4 4 1\n1 1 nan\n", "line 3 .* no finite real number"),
    "Abaqus with half a node": (b"1.5,1,1,1,3.0\n", "lines of Abaqus are"),
    "Abaqus with no node": (b"nan,1,1,1,3.0\n", "line 1 has a field, number 1, that is no finite real number"),
}


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("kind", MARKETS)
def test_a_matrix_that_is_not_what_it_says_is_refused(tmp_path, kind):
    content, message = MARKETS[kind]
    (tmp_path / "matrix.mtx").write_bytes(content)
    with pytest.raises(InputError, match=rf"matrix\.mtx'.*{message}"):
        square_of(tmp_path / "matrix.mtx", 2, 2)


def bomb(path: Path) -> None:
    """An archive of 14 MB that unpacks to 3 GB; packed better it would be smaller, and take twice as long."""
    zeros = bytes(2**20)
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as packed,
        packed.open("a.npy", "w", force_zip64=True) as member,
    ):
        np.lib.format.write_array_header_1_0(member, {"descr": "<f8", "fortran_order": False, "shape": (3 * 2**27,)})
        for _ in range(3 * 2**10):
            member.write(zeros)


@pytest.mark.robustness
def test_an_archive_that_unpacks_to_two_hundred_times_its_size_is_not_unpacked(tmp_path):
    bomb(tmp_path / "nodes.npz")
    with pytest.raises(InputError, match=r"nodes\.npz' cannot be read as .*bytes unpack to 3221225\d+, and no more than"):
        read_nodes(tmp_path / "nodes.npz")


def claimed(shape: str) -> bytes:
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode() + bytes(16)


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("shape", ["(1000000000000, 3)", "(0, 3)", "(-1, 2)", "(1, 3)"])
def test_an_array_that_is_not_in_its_file_is_refused(tmp_path, shape):
    (tmp_path / "nodes.npy").write_bytes(claimed(shape))
    with pytest.raises(InputError, match=r"nodes\.npy' cannot be read as .*it claims an array"):
        read_nodes(tmp_path / "nodes.npy")


class Trap:
    """An object that writes a file when it is unpickled."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Callable, tuple]:
        return Path.touch, (self.mark,)


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("name", ["field.npy", "field.npz"])
def test_pickled_objects_are_never_executed(tmp_path, name):
    array = np.array([Trap(tmp_path / "executed")], object)
    with (tmp_path / name).open("wb") as file:
        (np.save if name.endswith("npy") else np.savez)(file, array)
    assert pickle.dumps(array)  # the trap is one
    with pytest.raises(InputError, match="cannot be read as numbers"):
        read_array(tmp_path / name, "numbers")
    assert not (tmp_path / "executed").exists()


@pytest.mark.usefixtures("read_here")
def test_nodes_at_one_place_and_beyond_reason_are_refused(tmp_path):
    for rows in (np.ones((4, 2)), np.full((3, 2), 1e308) * [[1, 1], [1, -1], [-1, 1]], np.zeros((1, 2))):
        np.save(tmp_path / "nodes.npy", rows)
        with pytest.raises(InputError, match="all at one place, or beyond"):
            read_nodes(tmp_path / "nodes.npy")


def gmsh(nodes: str, elements: str) -> str:
    return f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{nodes}\n$EndNodes\n$Elements\n{elements}\n$EndElements\n"


VTK = "# vtk DataFile Version 5.1\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {points} float\n0 0 0 1 0 0 0 1 0\nOFFSETS vtktypeint64\n"
MESHES: dict[str, tuple[str, str, str]] = {
    "a count of 1e12 nodes": (".msh", gmsh("1000000000000\n1 0 0 0", "0"), "line 5: .Nodes claims more numbers than it holds"),
    "a node of gmsh that is not there": (".msh", gmsh("3\n1 0 0 0\n2 1 0 0\n3 0 1 0", "1\n1 2 2 0 1 1 2 9"),
    "has a node that the file does not hold"),
    "a group that is generated without end": (".inp", PLATE + "*NSET, NSET=a, GENERATE\n1, 2000000000, 1\n",
    "2000000000 is no number of a node"),
    "a group that is generated in steps of nothing": (".inp", PLATE + "*NSET, NSET=a, GENERATE\n1, 4, 0\n",
    "from 1 to 4 in steps of 0"),
    "a node that is not there": (".vtk",
    "# vtk DataFile Version 4.2\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
                                 "CELLS 1 4\n3 0 1 77\nCELL_TYPES 1\n5\n", "names node 77, and the nodes count from 0 to 2"),
    "a negative node": (".vtk",
    "# vtk DataFile Version 4.2\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
                        "CELLS 1 4\n3 0 1 -1\nCELL_TYPES 1\n5\n", "names node -1, and the nodes count from 0 to 2"),
    "1e13 points": (".vtk", VTK.format(points=10**13), "more or fewer numbers than the line before says"),
    "no points": (".inp", "*NODE\n*ELEMENT, TYPE=CPS4\n", "cannot be read as a mesh|of shape|holds no"),
    "all nodes at one place": (".inp", PLATE.replace(" 1, 0, 0", " 0, 0, 0").replace(" 1, 1, 0", " 0, 0, 0").replace(" 0, 1, 0",
    " 0, 0, 0"), "all at one place"),
    "coordinates of 1e300": (".inp", PLATE.replace("2, 1, 0", "2, 1e300, 0"), r"reaches to 1e\+300"),
    "an archive that ends": (".vtu",
    "<VTKFile type='UnstructuredGrid' version='0.1' compressor='vtkZLibDataCompressor'><UnstructuredGrid/></VTKFile>",
                             "holds no UnstructuredGrid with a Piece"),
    "XML that is none": (".xdmf", "<Xdmf><Domain>", "cannot be read as a mesh"),
    "a reader that never ends": (".ele", "", "comes to no end within|cannot be read as a mesh"),
}  # fmt: skip


@pytest.mark.parametrize("kind", MESHES)
def test_a_mesh_that_its_reader_cannot_take_is_one_error(tmp_path, kind, monkeypatch):
    ending, text, message = MESHES[kind]
    monkeypatch.setattr("preprocessing.foreign_files.child.BASE_SECONDS", 2, raising=False)
    path = tmp_path / f"body{ending}"
    path.write_text(text)
    if ending == ".ele":
        path.with_suffix(".node").write_text("")  # is read line by line until one holds something
    with pytest.raises(InputError, match=message):
        read_mesh(path)


def test_kinds_without_elements_and_groups_without_members_count_for_nothing(tmp_path, monkeypatch):
    """As readers leave them where the lines that should follow a header are missing."""
    (tmp_path / "body.inp").write_text(PLATE)
    nothing = np.zeros(0, np.int64)
    found = {"points": np.eye(3), "cells": [["hexahedron20", nothing]], "groups": [["a", [["quad8", nothing]]]]}
    monkeypatch.setattr("preprocessing.mesh.mesh_file.read_apart", lambda *_, **__: found)
    with pytest.raises(InputError, match="holds no triangles and no quadrilaterals"):
        read_mesh(tmp_path / "body.inp")
    found["cells"].append(["triangle", np.array([[0, 1, 2]])])
    found["points"] = np.array([[0.0, 0], [1, 0], [0, 1]])
    assert read_mesh(tmp_path / "body.inp").groups["a"].size == 0


def test_a_reader_that_crashes_its_process_is_one_error(tmp_path, monkeypatch):
    (tmp_path / "body.inp").write_text(PLATE)
    import preprocessing.foreign_files.apart as apart

    monkeypatch.setattr(apart, "CHILD", "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)")
    with pytest.raises(
        InputError, match=r"body\.inp' cannot be read as a mesh \(its reader crashed, SIGSEGV\)\. Export it again"
    ):
        read_mesh(tmp_path / "body.inp")
    monkeypatch.setattr(apart, "CHILD", "import sys; sys.exit(3)")
    with pytest.raises(InputError, match=r"\(its reader failed\)"):
        read_mesh(tmp_path / "body.inp")


def test_a_package_that_is_missing_is_named(tmp_path, monkeypatch):
    import preprocessing.foreign_files.apart as apart

    blocked = "sys.modules['{}'] = None\n"
    for package, remedy in (
        ("meshio", "pip install 'ffrf-toolkit"),
        ("netCDF4", "Install that package, or export another format"),
    ):
        monkeypatch.setattr(
            apart, "CHILD", blocked.format(package) + "from preprocessing.foreign_files.child import main; main(*sys.argv[1:])"
        )
        path = tmp_path / ("body.mesh" if package == "meshio" else "body.e")
        path.write_text(PLATE)
        with pytest.raises(InputError, match=rf"needs {package}, which cannot be loaded\)\. .*{remedy}"):
            read_mesh(path)


INCLUDES = {
    "of itself": (PLATE + "*INCLUDE, INPUT=body.inp\n", r"body\.inp' includes .*body\.inp', which includes it in turn"),
    "in a circle": (PLATE + "*INCLUDE, INPUT=other.inp\n", r"other\.inp' includes .*body\.inp', which includes it in turn"),
    "of a pipe": (PLATE + "*INCLUDE, INPUT=pipe.inp\n", r"pipe\.inp' cannot be read \(it is a pipe, not a regular file\)"),
    "of a device": (PLATE + "*INCLUDE, INPUT=/dev/zero\n", r"/dev/zero' cannot be read \(it is a device, not a regular file\)"),
    "with blanks and other letters": (PLATE + " * In clude ,\n input = pipe.inp\n", r"pipe\.inp' cannot be read \(it is a pipe"),
    "of a terabyte": (PLATE + "*INCLUDE, INPUT=large.inp\n", r"large\.inp' cannot be read \(it has more than 2000000000 bytes\)"),
}


@pytest.mark.parametrize("kind", INCLUDES)
def test_includes_are_looked_at_before_they_are_followed(tmp_path, kind):
    text, message = INCLUDES[kind]
    os.mkfifo(tmp_path / "pipe.inp")
    with (tmp_path / "large.inp").open("wb") as file:
        file.truncate(10**12)
    (tmp_path / "other.inp").write_text("*INCLUDE, INPUT=body.inp\n")
    (tmp_path / "body.inp").write_text(text)
    with pytest.raises(InputError, match=message):
        read_mesh(tmp_path / "body.inp")


def test_the_data_of_xdmf_may_be_no_pipe(tmp_path):
    meshio.write(tmp_path / "body.xdmf", meshio.Mesh(np.eye(3), [("triangle", [[0, 1, 2]])]))
    (tmp_path / "body.h5").unlink()
    os.mkfifo(tmp_path / "body.h5")
    with pytest.raises(InputError, match=r"body\.h5' cannot be read \(it is a pipe, not a regular file\)"):
        read_mesh(tmp_path / "body.xdmf")


READERS = {
    "scene.toml": read_scene,
    "skin.toml": SkinRecipe.read,
    "section.dat": read_airfoil,
    "body.msh": read_mesh,
    "matrix.mtx": lambda path: read_matrix(path, 4),
    "matrix.npz": lambda path: read_matrix(path, 4),
    "nodes.csv": read_nodes,
    "nodes.npy": read_nodes,
}
PLACES: dict[str, tuple[Callable[[Path], object], str]] = {
    "pipe": (os.mkfifo, "a pipe, not a regular file"),
    "zeros": (lambda path: path.symlink_to("/dev/zero"), "a device, not a regular file"),
    "folder": (os.mkdir, "a folder, not a regular file"),
    "terabyte": (lambda path: os.truncate(os.open(path, os.O_CREAT | os.O_WRONLY), 10**12), "bytes"),
    "circle": (lambda path: path.symlink_to(path.name), "Too many levels of symbolic links"),
}


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("name", READERS)
def test_what_is_no_regular_file_of_bounded_size_is_not_read(tmp_path, name, place):
    make, message = PLACES[place]
    make(tmp_path / name)
    with pytest.raises(InputError, match=message):
        READERS[name](tmp_path / name)


@pytest.mark.parametrize("name", READERS)
def test_a_name_that_is_too_long_is_said_to_be(tmp_path, name):
    with pytest.raises(InputError, match=r"cannot be read.*File name too long"):
        READERS[name](tmp_path / ("x" * 300 + name))


def body_of(folder: Path, mesh: str) -> Path:
    (folder / "body.toml").write_text(
        f'units = "m-kg-s"\nmesh = {{ file = "{mesh}" }}\nclamp = {{ group = "held" }}\nsection = {{ width = 1.0 }}\n'
        'basis = { kind = "full" }\n'
        "material = { youngs_modulus = 2e11, density = 7800.0, poisson_ratio = 0.3 }\n"
    )
    return folder / "body.toml"


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("kind", ["full", "static", "eigenmodes"])
def test_a_body_that_is_clamped_at_every_node_is_refused(tmp_path, kind):
    mesh = rectangle("quad", (2, 1), 1.0, 0.2)
    path = write_body(tmp_path, mesh, f'kind = "{kind}"' + "\ncount = 1" * (kind == "eigenmodes"))
    text = path.read_text()
    path.write_text(text.replace(f"[clamp]\nnodes = {mesh.groups['left'].tolist()}", "[clamp]\nnodes = [0, 1, 2, 3, 4, 5]"))
    with pytest.raises(InputError, match="basis: the clamp holds all nodes, so that nothing of the body can deform"):
        build(path)


@pytest.mark.usefixtures("read_here")
def test_more_modes_than_a_body_has_coordinates_are_refused(tmp_path):
    mesh = rectangle("quad8", (20, 4), 1.0, 0.2)
    path = write_body(tmp_path, mesh, 'kind = "eigenmodes"\ncount = 1000000000')
    with pytest.raises(InputError, match=r"1000000004 modes of a body with \d+ coordinates are too many"):
        build(path)


def test_an_equilibrium_that_does_not_fit_into_memory_is_refused_with_its_size():
    scene = read_scene(WING / "scene.toml", {"solver.memory": "1e-6"})
    with pytest.raises(
        InputError,
        match=r"the equilibrium of 1\d\d unknowns takes dense matrices of 0.000\d+ GB, more than solver.memory = 1e-06 GB",
    ):
        solve(prepare(scene, []), "static")


def test_a_solid_without_the_package_that_writes_meshes_says_what_to_install(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "preprocessing.builders.extruded_skin", None)
    code, said = command(monkeypatch, capsys, str(WING / "skin.toml"), "--extrude", str(tmp_path / "solid.msh"))
    assert code == 1
    assert "a solid needs meshio and scikit-fem, which cannot be loaded" in said
    assert "pip install 'ffrf-toolkit[preprocessing]'" in said


@pytest.mark.parametrize("program", ["toolkit", "preprocessing"])
def test_what_memory_does_not_hold_is_said_without_a_traceback(program, monkeypatch, capsys):
    def exhausted(*_: object, **__: object) -> None:
        raise MemoryError("Unable to allocate 8.18 GiB")

    if program == "toolkit":
        monkeypatch.setattr("toolkit.command_line.commands.inspection.describe", exhausted)
        done = CliRunner().invoke(app, ["inspect", str(WING / "skin.h5")])
        code, said = done.exit_code, done.stderr
    else:
        monkeypatch.setattr("preprocessing.commands.cli.read_recipe", exhausted)
        code, said = command(monkeypatch, capsys, str(WING / "skin.toml"))
    assert (code, said) == (
        1,
        "the memory does not hold what this takes (Unable to allocate 8.18 GiB). Describe it by fewer numbers, or take a larger machine.\n",
    )


def test_files_are_bounded_before_they_are_hashed(tmp_path):
    os.mkfifo(tmp_path / "plate.inp")
    path = body_of(tmp_path, "plate.inp")
    with pytest.raises(InputError, match=r"plate\.inp' cannot be read \(it is a pipe, not a regular file\)"):
        BodyRecipe.read(path).hash()


def test_a_body_of_a_mesh_and_its_includes_is_still_built(tmp_path):
    (tmp_path / "nodes.inp").write_text(PLATE)
    (tmp_path / "plate.inp").write_text("*INCLUDE, INPUT=nodes.inp\n")
    assert build(body_of(tmp_path, "plate.inp")).n_f == 4


def command(monkeypatch, capsys, *arguments: str) -> tuple[int, str]:
    monkeypatch.setattr(sys, "argv", ["ffrf-preprocess", *arguments])
    with pytest.raises(SystemExit) as end:
        main()
    return end.value.code, capsys.readouterr().err


COMMANDS = {
    "layers": ((str(WING / "skin.toml"), "--extrude", "solid.msh", "--layers", "1000000"), "layers"),
    "long output": ((str(WING / "skin.toml"), "--output", "x" * 300 + ".h5"), "File name too long"),
    "long solid": ((str(WING / "skin.toml"), "--extrude", "x" * 300 + ".msh"), "File name too long"),
    "long body": (("x" * 300 + ".toml",), "File name too long"),
}


@pytest.mark.parametrize("kind", COMMANDS)
def test_commands_refuse_what_nobody_means(tmp_path, monkeypatch, capsys, kind):
    arguments, message = COMMANDS[kind]
    monkeypatch.chdir(tmp_path)
    code, said = command(monkeypatch, capsys, *arguments)
    assert code == 1
    assert message in said
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "make", [os.mkfifo, os.mkdir, lambda path: path.symlink_to("/dev/zero")], ids=["pipe", "folder", "zeros"]
)
def test_a_model_that_is_no_file_is_not_waited_for(tmp_path, make):
    make(tmp_path / "skin.h5")
    with pytest.raises(
        ModelFileError, match=r"skin\.h5' cannot be read \(it is a .*, not a regular file\)\. Give a reduced model"
    ):
        load(tmp_path / "skin.h5")


def test_elements_that_do_not_share_the_nodes_between_their_corners_are_refused():
    """A corner of the fourth element is the middle of a side of the fifth, as a wrong line of a mesh file makes it."""
    mesh = rectangle("quad8", (3, 2), 1.0, 0.4)
    blocks = mesh.blocks["quad8"].copy()
    blocks[3, 1] = blocks[5, 4]
    with pytest.raises(InputError, match="quad8 elements do not fit together"):
        element_blocks(SolidMesh(mesh.nodes, {"quad8": blocks}))
