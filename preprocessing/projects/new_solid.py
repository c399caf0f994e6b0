"""A solid of one's own: an arm whose mesh is drawn here, or any mesh with two named groups of nodes, on a motor."""

from __future__ import annotations

import os
import shlex
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from string import Template
from tempfile import TemporaryDirectory

import numpy as np

from preprocessing.builders.body_file import Region
from preprocessing.builders.curve_mesh import load_gmsh
from preprocessing.builders.named_mesh import nodes_in
from preprocessing.foreign_files.child import LARGEST_FILE
from preprocessing.foreign_files.included_files import drawn_on
from preprocessing.mesh.faces import cut
from preprocessing.mesh.mesh_file import read_mesh
from preprocessing.mesh.solid_mesh import SolidMesh
from preprocessing.projects.new_linkage import (
    PER_KILOGRAM,
    PER_METRE,
    WORDS,
    refuse_occupied,
    refuse_units,
    substituted,
    write_folder,
)
from toolkit.foundation.errors import InputError, meant
from toolkit.foundation.files.safe_files import read_whole
from toolkit.foundation.units import UNIT_SYSTEMS, unit

BODY = Template("""\
# $what, between a hub on a motor and a tip that carries a weight.
# $words
units = "$units"

[mesh]
file = "$mesh"

[material]  # aluminium
youngs_modulus = $modulus
density = $density
poisson_ratio = 0.33
$section
[damping]
stiffness = 2e-5

[clamp]  # where the body's frame is
group = "$clamp"

[interface_points]  # where joints grip
hub = { group = "$clamp" }
tip = { group = "$grip", tie = "rigid" }

[basis]
kind = "craig-bampton"
count = $count
""")

SCENE = Template("""\
# A motor turns the body by a quarter of a turn about the hub; at the tip a weight is fixed, as heavy as half the body.
# $words
units = "$units"$dimension

[points]
H = { body = "solid", interface = "hub" }
T = { body = "solid", interface = "tip" }

[bodies]
solid = { type = "flexible", model = "body.h5", frame = "moving" }
weight = { type = "rigid", mass = $mass, inertia = $inertia, center = "T" }

[joints]
hub = { type = "revolute", bodies = ["solid", "ground"], point = "H"$axis }
tip = { type = "rigid", bodies = ["solid", "weight"], point = "T" }

[joints.motor]
type = "angle-driver"
bodies = ["solid", "ground"]
point = "H"
${line_of_axis}curve = { type = "cycloid", height = 1.5707963267948966, duration = $duration }

[loads]
gravity = { type = "gravity", acceleration = $gravity }

[design]  # short names of numbers; `ffrf sensitivity` differentiates by them
T = "joints.motor.curve.duration"
rho = "bodies.solid.density"
m = "bodies.weight.mass"

[responses]
stress = { type = "max-stress", body = "solid"$measure }
torque = { type = "time-max", of = { type = "joint-force", joint = "motor", component = "torque$z" }, measure = "absolute" }
strain = { type = "time-max", of = { type = "strain-energy" } }

[solver]
end_time = $duration
step = $step
rho_inf = 0.8
""")

README = Template("""\
# $what on a motor

`body.toml` describes the body: its mesh `$mesh`, material, where it is held, how many shapes it keeps. `scene.toml` puts it
on a motor.$drawn

```
ffrf-preprocess $folder/body.toml        # writes body.h5, and says how exact the stress of this mesh is; again after every change
ffrf statics $folder/scene.toml          # under its weight, a quarter of a turn on: stress, with exact derivatives
ffrf simulate $folder/scene.toml         # the motion: stress, torque of the motor
ffrf sensitivity $folder/scene.toml      # how these depend on the motor's time, the density and the weight at the tip
ffrf render $folder/scene.toml --output $folder/pictures --animate
ffrf simulate $folder/scene.toml --set bodies.weight.mass=$heavier   # any number can be changed for one run
```
""")


def mesh_files(path: Path, reserved: Collection[str]) -> dict[str, bytes]:
    """Content of a mesh file and of all files that it includes or draws on, by place relative to the mesh's folder.

    Parameters
    ----------
    path : the mesh
    reserved : names that other files of the new folder will have

    Raises
    ------
    InputError
        A file lies outside of the mesh's folder, is named by an absolute path, cannot be read, or has a reserved name.
    """
    mesh = Path(os.path.relpath(path))  # absolute are only the files that are named so
    files = {mesh.name: mesh} | {_place(path, mesh, each): each for each in drawn_on(mesh)}
    for place in files:
        if Path(place).parts[0].casefold() in {name.casefold() for name in reserved}:
            raise InputError(
                f"the mesh {str(path)!r} is made of a file {place!r}, and the new folder gets one of that name. Rename it, or write the "
                "mesh in one file."
            )
    return {place: _content(each) for place, each in files.items()}


def _place(path: Path, mesh: Path, each: Path) -> str:
    """Place of a file that the mesh draws on, as seen from the mesh's folder."""
    place = Path(os.path.relpath(each, mesh.parent))
    if each.is_absolute() or place.parts[0] == os.pardir:
        how = "by its absolute path" if each.is_absolute() else "outside of its own folder"
        raise InputError(
            f"the mesh {str(path)!r} includes {str(each)!r} {how}, so that a copy of both would still read the old one. Put that file "
            "beside the mesh or below it and include it from there, or write the mesh in one file."
        )
    return place.as_posix()


def _content(each: Path) -> bytes:
    try:
        return read_whole(each, LARGEST_FILE)
    except OSError as error:
        raise InputError(f"{str(each)!r} cannot be read ({error.strerror}). Fix the path, or give a regular file.") from error


DENSITY, MODULUS = 2700.0, 70e9
"""Density and Young's modulus of aluminium, in kg/m^3 and Pa."""
TIP_MASS_PART, PLANE_THICKNESS = 0.5, 0.1
"""Mass at the tip, in parts of the body's; thickness of a plane body, in parts of its length."""
TURN_DURATION = 0.14
"""Duration of the quarter of a turn in parts of sqrt(length / m) s: the tip is accelerated by some five times its weight."""
STEPS = 100
WRITTEN = ("body.toml", "scene.toml", "README.md", "body.h5")
"""Files that the folder gets besides the mesh, the last one by ffrf-preprocess."""
LIKELY = (1e-3, 20.0)
"""Extent in m of a body that is meant."""


@dataclass(frozen=True)
class NewSolid:
    """Mesh as it will lie in the folder, and the groups that the body is held and gripped at."""

    name: str  # of its file
    files: dict[str, bytes]  # place in the folder -> content, of this file and of all that it includes
    mesh: SolidMesh
    clamp: str
    grip: str


def new_solid(
    folder: str | Path, mesh: str | Path | None = None, clamp: str = "hub", grip: str = "tip", units: str = "mm-t-s"
) -> list[Path]:
    """Write a folder with a mesh and all that it includes, body.toml, scene.toml and README.md, and mesh.py if the mesh was drawn.

    Parameters
    ----------
    folder : new, or empty
    mesh : file of a mesh in the plane or in space, in the length of the units; without one an arm of 120 mm is drawn
    clamp, grip : groups of nodes of the mesh: where the motor holds the body, and where the weight is
    units : name of the system of units

    Raises
    ------
    InputError
        The folder is not empty or cannot be written, the mesh cannot be used, includes files outside of its folder, or has no such groups.
    """
    refuse_units(units)
    refuse_occupied(folder := Path(folder))
    if clamp == grip:
        raise InputError(f"the body cannot be held and gripped at the same group {clamp!r}. Give two groups: --clamp and --grip.")
    if mesh is None:
        if (clamp, grip) != ("hub", "tip"):
            raise InputError("--clamp and --grip are groups of a mesh of your own: give it with --mesh, or leave them out.")
        if units != "mm-t-s":
            raise InputError("the arm that is drawn is in mm: leave --units out, or give a mesh of your own with --mesh.")
        solid, script = drawn_arm()
    else:
        solid, script = _own(Path(mesh), clamp, grip), {}
    texts = {"body.toml": BODY, "scene.toml": SCENE, "README.md": README}
    filled = substituted(texts, _numbers(solid, folder, units, bool(script)))
    return write_folder(folder, {**solid.files, **script, **filled})


def size_question(mesh: str | Path, units: str) -> str:
    """Sentence on a mesh whose size makes its unit of length doubtful; empty if it does not."""
    length = unit(units, "length")
    size = read_mesh(Path(mesh)).size / PER_METRE[units]
    if LIKELY[0] <= size <= LIKELY[1]:
        return ""
    other = next(name for name in UNIT_SYSTEMS if name != units)
    return (
        f"The mesh is {size:g} m long if its numbers are {length}, as --units {units} says. If they are {unit(other, 'length')}, start "
        f"again in another folder with --units {other}."
    )


def _own(path: Path, clamp: str, grip: str) -> NewSolid:
    """Mesh from a file, whose groups are checked."""
    if not path.is_file():
        raise InputError(f"there is no mesh {str(path)!r}. Fix the path, or leave --mesh out: then an arm is drawn.")
    read = read_mesh(path)
    solid = NewSolid(path.name, mesh_files(path, WRITTEN), read, clamp, grip)
    for option, group in (("--clamp", clamp), ("--grip", grip)):
        if group not in solid.mesh.groups:
            known = ", ".join(map(repr, solid.mesh.groups)) or "none"
            near = meant(group, solid.mesh.groups)
            raise InputError(
                f"the mesh {path.name!r} has no group {group!r}{near}; there are {known}. Name one of them with {option}."
            )
    return solid


def drawn_arm() -> tuple[NewSolid, dict[str, bytes]]:
    """Mesh of the arm, and the script that has drawn it."""
    load_gmsh()  # says what to install if it is not there
    from preprocessing.projects import arm

    with TemporaryDirectory() as folder:
        arm.main(path := Path(folder) / "arm.msh")
        solid = NewSolid("arm.msh", {"arm.msh": path.read_bytes()}, read_mesh(path), "hub", "tip")
    return solid, {"mesh.py": Path(arm.__file__).read_bytes()}


DRAWN = """ `mesh.py` draws the mesh: change its numbers and run it. Its elements of 9 mm
are there to be quick: the stress is off by some 14 % in the energy norm, with SIZE = 5.0 and 20 elements round a bore by 9.5 %."""


def _numbers(solid: NewSolid, folder: Path, units: str, drawn: bool) -> dict[str, object]:
    """Numbers of the templates that the mesh and the units decide."""
    mesh, length, kilogram = solid.mesh, PER_METRE[units], PER_KILOGRAM[units]
    ends = [mesh.nodes[nodes_in(mesh, Region(group=group))] for group in (solid.clamp, solid.grip)]
    plane, size = mesh.dimension == 2, mesh.size
    reach = float(np.linalg.norm(ends[1].mean(axis=0) - ends[0].mean(axis=0)))
    width = _short(PLANE_THICKNESS * size)
    density = DENSITY * kilogram / length**3
    mass = TIP_MASS_PART * density * volume(mesh) * (width if plane else 1.0)
    inertia, down = mass * (0.1 * size) ** 2, 9.81 * length
    duration = _short(TURN_DURATION * np.sqrt(max(reach, 1e-3 * size) / length), 2)
    return {
        "what": "An arm" if drawn else "A solid", "words": WORDS[units], "units": units, "mesh": solid.name,
        "modulus": _short(MODULUS * kilogram / length), "density": _short(density), "clamp": solid.clamp, "grip": solid.grip,
        "section": f"\n[section]\nwidth = {width}\n" if plane else "", "count": 6 if plane else 4,
        "dimension": "" if plane else "\ndimension = 3", "axis": "" if plane else ", axis = [0.0, 0.0, 1.0]",
        "line_of_axis": "" if plane else "axis = [0.0, 0.0, 1.0]\n",
        "z": "" if plane else "-z", "measure": ', measure = "absolute"' if plane else "",
        "mass": _short(mass), "inertia": _short(inertia) if plane else [_short(inertia)] * 3, "heavier": f"{_short(2 * mass):g}",
        "gravity": [0.0, _short(-down)] if plane else [0.0, 0.0, _short(-down)],
        "duration": duration, "step": _short(duration / STEPS), "folder": shlex.quote(str(folder)),
        "drawn": DRAWN if drawn else "",
    }  # fmt: skip


def volume(mesh: SolidMesh) -> float:
    """Area of a plane mesh, volume of a spatial one."""
    corners = cut(mesh.nodes, mesh.blocks)[1].corners
    return float(np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum()) / (2 if mesh.dimension == 2 else 6)


def _short(number: float, digits: int = 5) -> float:
    return float(f"{number:.{digits}g}")
