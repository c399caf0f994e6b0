"""Meshes in every format that can be written here, spoilt."""

from __future__ import annotations

import io
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path

import meshio
import numpy as np

from tests.foreign_decks.bulk_decks import Writer
from tests.foreign_meshes.ansys_files import component, element_block, node_block
from tests.foreign_meshes.gmsh_files import meshed, written
from tests.fuzz.case import Case
from tests.fuzz.mutations import spoilt
from tests.models.solid_bodies import box, rectangle

BODY = """
units = "m-kg-s"
mesh = {{ file = "{file}", scale = {scale} }}
material = {{ youngs_modulus = 2e11, density = 7800.0, poisson_ratio = 0.3 }}
{section}
clamp = {{ {clamp} }}
interface_points = {{ tip = {{ {tip} }} }}
basis = {{ kind = "static" }}
"""
FORMATS = {
    "gmsh22-text": ("msh", {"file_format": "gmsh22", "binary": False}), "gmsh22-binary": ("msh", {"file_format": "gmsh22"}),
    "gmsh41-text": ("msh", {"file_format": "gmsh", "binary": False}), "gmsh41-binary": ("msh", {"file_format": "gmsh"}),
    "abaqus": ("inp", {}), "nastran": ("bdf", {}), "bulk": ("bdf", {}), "vtk-binary": ("vtk", {}), "vtk-text": ("vtk", {"binary": False}),
    "vtk42": ("vtk", {"file_format": "vtk42"}),
    "vtk42-text": ("vtk", {"file_format": "vtk42", "binary": False}), "vtu": ("vtu", {}), "vtu-text": ("vtu", {"binary": False}),
    "xdmf-hdf": ("xdmf", {}), "xdmf-xml": ("xdmf", {"data_format": "XML"}), "xdmf-binary": ("xdmf", {"data_format": "Binary"}),
    "su2": ("su2", {}), "medit": ("mesh", {}), "medit-binary": ("meshb", {}), "ply": ("ply", {}), "off": ("off", {}), "obj": ("obj", {}),
    "stl": ("stl", {}), "tecplot": ("dat", {}), "tetgen": ("ele", {}), "ugrid": ("ugrid", {}), "avs": ("avs", {}),
    "dolfin": ("xml", {}), "netgen": ("vol", {}), "permas": ("post", {}), "med": ("med", {}), "cgns": ("cgns", {}), "h5m": ("h5m", {}),
    "hmf": ("hmf", {}), "mdpa": ("mdpa", {}), "flac3d": ("f3grid", {}), "exodus": ("e", {}), "wkt": ("wkt", {}),
    "fluent": ("msh", {"file_format": "ansys"}),
}  # fmt: skip
"""Name -> ending and options of meshio.write, but for `bulk`, which is written here."""
GROUPS = ("abaqus", "gmsh22-text", "gmsh22-binary")
BY_GMSH = {
    "gmsh-1": ("msh", {"Mesh_MshFileVersion": 1.0}), "gmsh-2": ("msh", {"Mesh_MshFileVersion": 2.2}),
    "gmsh-2-binary": ("msh", {"Mesh_MshFileVersion": 2.2, "Mesh_Binary": 1}), "gmsh-4": ("msh", {}),
    "gmsh-4-binary": ("msh", {"Mesh_Binary": 1}), "gmsh-4-parametric": ("msh", {"Mesh_SaveParametric": 1}),
    "gmsh-unv": ("unv", {}), "gmsh-med": ("med", {}),
}  # fmt: skip
"""Name -> ending and options of gmsh, whose files have groups and entities."""
ENDINGS = {name: ending for name, (ending, _) in {**FORMATS, **BY_GMSH}.items()} | {"ansys": "cdb"}


@cache
def good() -> dict[tuple[str, str], dict[str, bytes]]:
    """Format and kind of elements -> the files of a mesh, as far as this format can be written."""
    found = {}
    for kind in ("triangle", "quad", "quad8", "tetra", "hexahedron", "hexahedron20", "wedge"):
        plane = kind.startswith(("t", "q")) and not kind.startswith("tetra")
        solid = rectangle(kind, (3, 2), 1.0, 0.4) if plane else box(kind, (2, 1, 1), (1.0, 0.4, 0.4))
        points = np.column_stack([solid.nodes, np.zeros((len(solid.nodes), 3 - solid.dimension))])
        for name, (ending, options) in FORMATS.items():
            if name == "tetgen" and kind != "tetra":  # written without elements, which is read without end
                continue
            if name == "bulk":
                found[name, kind] = bulk(points, kind, solid.blocks[kind])
                continue
            mesh = meshio.Mesh(points, [(kind, solid.blocks[kind])])
            if name in GROUPS:
                mesh.point_sets = {key: nodes for key, nodes in solid.groups.items()} if name == "abaqus" else {}
            with tempfile.TemporaryDirectory() as folder, redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
                try:
                    meshio.write(Path(folder) / f"body.{ending}", mesh, **options)
                    meshio.read(Path(folder) / f"body.{ending}", file_format="gmsh" if ending == "msh" else None)
                except (Exception, SystemExit):  # noqa: BLE001 (not every format has every kind, or a writer that works)
                    continue
                found[name, kind] = {each.name: each.read_bytes() for each in Path(folder).iterdir()}
    return found | _by_gmsh() | _of_ansys()


def _by_gmsh() -> dict[tuple[str, str], dict[str, bytes]]:
    """Files that gmsh itself writes."""
    found = {}
    for kind in ("triangle", "tetra", "wedge"):
        with meshed(kind) as (gmsh, _), tempfile.TemporaryDirectory() as folder:
            for name, (ending, options) in BY_GMSH.items():
                path = written(gmsh, Path(folder) / f"body.{ending}", **options)
                found[name, kind] = {path.name: path.read_bytes()}
                path.unlink()
    return found


CARDS = {"triangle": "CTRIA3", "quad": "CQUAD4", "quad8": "CQUAD8", "tetra": "CTETRA", "wedge": "CPENTA"}


def bulk(points: np.ndarray, kind: str, block: np.ndarray) -> dict[str, bytes]:
    """Bulk data of Nastran in all formats, with a coordinate system, masses, a tie, sets and an included file."""
    writer = Writer(np.random.default_rng(7), False)
    nodes = [["GRID", str(k + 1), "5", *(f"{x:.4f}" for x in place)] for k, place in enumerate(points)]
    name = CARDS.get(kind, "CHEXA")
    order = [*range(12), *range(16, 20), *range(12, 16)] if kind == "hexahedron20" else slice(None)
    elements = [[name, str(k + 1), "1", *map(str, row[order] + 1)] for k, row in enumerate(block)]
    n = len(points)
    more = [["CORD2R", "5", "", *["0."] * 5, "1.", "1.", "0.", "0."], ["GRID", str(n + 1), "", "2.", "0.", "0."],
            ["CONM2", "901", "1", "5", "2.", ".1", "", "", "", "1.", "", "1.", "", "", "1."], ["CONM2", "902", str(n + 1), "", "3."],
            ["RBE2", "903", str(n + 1), "123456", "1", "2", "3"], ["SET1", "9", "1", "THRU", "4"],
            ["SET3", "8", "ELEM", "1"], ["SPC1", "1", "123", "1"], ["PARAM", "WTMASS", "1."], ["PSOLID", "1", "1"],
            ["MAT1", "1", "2.+11", "", ".3", "7800."]]  # fmt: skip
    text = [[line for card in cards for line in writer.card(card)] for cards in ([*nodes, *more], elements)]
    main = ["SOL 103", "CEND", "BEGIN BULK", *text[0], "INCLUDE 'rest.blk'", "ENDDATA", ""]
    return {"body.bdf": "\n".join(main).encode(), "rest.blk": "\n".join([*text[1], ""]).encode()}


def _of_ansys() -> dict[tuple[str, str], dict[str, bytes]]:
    """An archive of bricks, with components."""
    solid = box("hexahedron", (2, 1, 1), (1.0, 0.4, 0.4))
    elements = element_block(*((1, (row + 1).tolist()) for row in solid.blocks["hexahedron"]))
    parts = component("SOME", "NODE", 1, -4, 7) + component("ALL", "ELEM", 101, -102)
    text = f"/PREP7\nET,1,185\n{node_block(solid.nodes)}{elements}{parts}FINISH\n"
    return {("ansys", "hexahedron"): {"body.cdb": text.encode()}}


def body(file: str, plane: bool, rng: np.random.Generator, groups: bool = False) -> str:
    """body.toml of such a mesh."""
    low, high = ("-0.1, -1, 0.01, 1", "0.99, -1, 1.1, 1") if plane else ("-0.1, -1, -1, 0.01, 1, 1", "0.99, -1, -1, 1.1, 1, 1")
    return BODY.format(
        file=file,
        scale=rng.choice(["1.0"] * 40 + ["1e-19", "1e19", "1e300"]),
        section="section = { width = 0.1 }" if plane else "",
        clamp='group = "left"' if groups else f"box = [{low}]",
        tip='group = "right"' if groups else f"box = [{high}]",
    )


def cases(rng: np.random.Generator) -> Iterator[Case]:
    """One of the files of a mesh is spoilt each time."""
    keys = sorted(good())
    formats = sorted({name for name, _ in keys})
    while True:
        name = formats[int(rng.integers(len(formats)))]
        kind = str(rng.choice([kind for other, kind in keys if other == name]))
        files = dict(good()[name, kind])
        victim = str(rng.choice(sorted(files)))
        others = [each for key in keys if key[0] == name for each in good()[key].values()]
        how, files[victim] = spoilt(files[victim], others[int(rng.integers(len(others)))], rng)
        main = f"body.{ENDINGS[name]}"
        plane = kind.startswith(("tri", "quad"))
        text = body(main, plane, rng, name == "abaqus" and rng.random() < 0.5)
        yield Case(f"{name} {kind} {how}", ("ffrf-preprocess", "body.toml", "--output", "out.h5"), files_of(text, files))


def files_of(text: str, files: dict[str, bytes]) -> Callable[[Path], None]:
    def write(folder: Path) -> None:
        (folder / "body.toml").write_text(text)
        for name, content in files.items():
            (folder / name).write_bytes(content)

    return write


def copied(source: Path, folder: Path) -> None:
    """All files of a folder."""
    for each in source.iterdir():
        shutil.copy(each, folder)
