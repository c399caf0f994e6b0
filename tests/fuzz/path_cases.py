"""Paths that lead to no file: pipes, devices, sockets, folders, links in circles, sparse files of a terabyte, names that are too long."""

from __future__ import annotations

import os
import shutil
import socket
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from tests.fuzz.case import Case
from tests.fuzz.mesh_cases import body, good

MODELS = Path(__file__).parents[2] / "models"


def _socket(path: Path) -> None:
    here = os.getcwd()
    os.chdir(path.parent)  # its name may have 100 letters
    with socket.socket(socket.AF_UNIX) as end:
        end.bind(path.name)
    os.chdir(here)


def _sparse(size: int) -> Callable[[Path], None]:
    def make(path: Path) -> None:
        with path.open("wb") as file:
            file.truncate(size)

    return make


PLACES: dict[str, Callable[[Path], None] | str] = {
    "pipe": os.mkfifo,
    "socket": _socket,
    "folder": os.mkdir,
    "terabyte": _sparse(10**12),
    "gigabytes": _sparse(5 * 10**9),
    "megabytes of zeros": _sparse(3 * 10**7),
    "nothing in it": _sparse(0),
    "link to itself": lambda path: path.symlink_to(path.name),
    "link to a pipe": lambda path: (os.mkfifo(path.with_name("pipe")), path.symlink_to("pipe"))[1],
    "link to nothing": lambda path: path.symlink_to("nothing"),
    "link to /dev/zero": lambda path: path.symlink_to("/dev/zero"),
    "unreadable": lambda path: (path.write_text("x"), path.chmod(0))[1],
    "missing": lambda path: None,
    "/dev/zero": "/dev/zero", "/dev/random": "/dev/urandom", "/dev/null": "/dev/null", "/dev/stdin": "/dev/stdin",
    "/dev/tty": "/dev/tty",
    "root": "/", "here": ".", "up": "..", "300 letters": "x" * 300, "5000 letters": "x" * 5000, "deep": "a/" * 500 + "a",
    "letters": "é🛩\u202e", "blank": " ", "newline": "a\nb", "dash": "-", "option": "--help", "proc": "/proc/self/mem",
    "url": "http://x/y",
    "under a file": "scene.toml/x", "tilde": "~",
}  # fmt: skip
"""What a path leads to: made at a name that was given, or such a name."""
USES: dict[str, tuple[str, ...]] = {
    "scene": ("ffrf", "statics", "@.toml"), "scene to inspect": ("ffrf", "inspect", "@.toml", "--no-measure"),
    "scene to simulate": ("ffrf", "simulate", "@.toml"), "results": ("ffrf", "inspect", "@.h5"), "results to export": ("ffrf",
    "export", "@.h5", "--csv", "out"),
    "scene without ending": ("ffrf", "inspect", "@"),
    "body": ("ffrf-preprocess", "@.toml"), "model of a scene": ("ffrf", "inspect", "use.toml", "--no-measure"),
    "airfoil": ("ffrf-preprocess", "use.toml"), "target": ("ffrf-preprocess", "use.toml"),
    "mesh": ("ffrf-preprocess", "use.toml"), "matrix": ("ffrf-preprocess", "use.toml"), "nodes": ("ffrf-preprocess", "use.toml"),
    "include": ("ffrf-preprocess", "use.toml"), "xdmf": ("ffrf-preprocess", "use.toml"),
    "output of a model": ("ffrf-preprocess", "frame.toml", "--output", "@.h5"), "forced output": ("ffrf-preprocess",
    "frame.toml", "--force", "--overwrite", "--output", "@.h5"),
    "output of a run": ("ffrf", "statics", "pendulum.toml", "--output", "@.h5"), "extrusion": ("ffrf-preprocess", "skin.toml",
    "--extrude", "@.msh"),
    "wing": ("ffrf", "new", "wing", "@", "--airfoil", "high_speed.dat"), "airfoil of a wing": ("ffrf", "new", "wing", "new",
    "--airfoil", "@.dat"),
    "target of a wing": ("ffrf", "new", "wing", "new", "--airfoil", "high_speed.dat", "--target", "@.dat"),
}  # fmt: skip
"""Commands and where the path stands in them: @."""
ENDING = {"airfoil": ".dat", "target": ".dat", "matrix": ".mtx", "nodes": ".csv", "include": ".inp", "model of a scene": ".h5"}
MESHES = (".msh", ".inp", ".vtu", ".vtk", ".bdf", ".xdmf", ".su2", ".mesh", ".ele", ".stl", ".post.gz", ".xml")


def cases(rng: np.random.Generator) -> Iterator[Case]:
    """Every use with every place, in another order each time."""
    pairs = [(use, place) for use in USES for place in PLACES]
    while True:
        for k in rng.permutation(len(pairs)):
            use, place = pairs[k]
            ending = MESHES[int(rng.integers(len(MESHES)))] if use == "mesh" else ENDING.get(use, "")
            yield _case(use, place, ending, rng)


def _case(use: str, place: str, ending: str, rng: np.random.Generator) -> Case:
    made = PLACES[place]
    stem = f"place{rng.integers(10**6)}" if callable(made) else made
    arguments = tuple(part.replace("@", stem) for part in USES[use])
    given = next((part for part in arguments if stem in part), stem + ending)
    text = in_toml(use, stem + ending)

    def write(folder: Path) -> None:
        for source, name in FILES:
            shutil.copy(source, folder / name)
        (folder / "frame.toml").write_text(FRAME)
        for name, content in text.items():
            (folder / name).write_bytes(content)
        if callable(made):
            made(folder / given)

    return Case(f"{use}: {place} {ending}", arguments, write, (given,) if "output" in use else ())


FILES = [
    (MODELS / "pendulum" / "scene.toml", "pendulum.toml"),
    (MODELS / "morphing_wing" / "skin.toml", "skin.toml"),
    (MODELS / "morphing_wing" / "high_speed.dat", "high_speed.dat"),
    (MODELS / "morphing_wing" / "low_speed.dat", "low_speed.dat"),
]
FRAME = """
units = "m-kg-s"
nodes = { a = [0.0, 0.0, 0.0], b = [1.0, 0.0, 0.0] }
beams = [{ from = "a", to = "b", section = "s", elements = 2 }]
sections.s = { kind = "rectangle", thickness = 0.01, width = 0.02, material = "m" }
materials.m = { youngs_modulus = 2e11, poisson_ratio = 0.3, density = 7800.0 }
clamp = ["a"]
interface_points.tip.node = "b"
basis.kind = "static"
"""


def in_toml(use: str, path: str) -> dict[str, bytes]:
    """Files that name the path."""
    quoted = path.replace("\n", "\\n")
    rng = np.random.default_rng(0)
    wing = (MODELS / "morphing_wing" / "skin.toml").read_text()
    if use == "model of a scene":
        text = (MODELS / "morphing_wing" / "scene.toml").read_text().replace('"skin.h5"', f'"{quoted}"')
        return {"use.toml": text.encode()}
    if use in ("airfoil", "target"):
        name = {"airfoil": "high_speed.dat", "target": "low_speed.dat"}[use]
        return {"use.toml": wing.replace(f'"{name}"', f'"{quoted}"').encode()}
    if use == "mesh":
        return {"use.toml": body(quoted, True, rng).encode()}
    if use in ("matrix", "nodes"):
        names = {"mass": "m.csv", "stiffness": "m.csv", "nodes": "n.csv"} | (
            {"mass": quoted} if use == "matrix" else {"nodes": quoted}
        )
        table = "".join(f'{key} = "{name}"\n' for key, name in names.items())
        rest = 'clamp = { nodes = [0, 1] }\nbasis = { kind = "full" }\n'
        lines = b"".join(b"%d,%d,%d,%d,1.0\n" % (k, d, k, d) for k in (1, 2, 3) for d in (1, 2))
        return {"use.toml": f'units = "m-kg-s"\n{rest}[matrices]\n{table}'.encode(), "m.csv": lines, "n.csv": b"0,0\n1,0\n0,1\n"}
    if use == "include":
        plate = (
            b"*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n*ELEMENT, TYPE=CPS4\n1,1,2,3,4\n*INCLUDE, INPUT=" + path.encode() + b"\n"
        )
        return {"use.toml": body("plate.inp", True, rng).encode(), "plate.inp": plate}
    if use == "xdmf":
        files = good()["xdmf-hdf", "quad"]
        text = files["body.xdmf"].replace(b"body.h5", path.encode())
        return {"use.toml": body("body.xdmf", True, rng).encode(), "body.xdmf": text}
    return {}
