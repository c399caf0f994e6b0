"""The skin as a solid: its middle line thickened along the normal and drawn to its width, as a mesh and a body.toml that builds from it."""

from __future__ import annotations

import json
from pathlib import Path

import meshio
import numpy as np

from preprocessing.builders.recipe import Remark
from preprocessing.builders.skin_file import SkinFile
from preprocessing.builders.skin_geometry import Geometry, read_geometry
from preprocessing.builders.skin_recipe import SkinRecipe
from preprocessing.builders.tables import InputTable
from preprocessing.elements.solid_elements import CUBE, CUBE_MIDDLES
from preprocessing.mesh.input_files import at_key
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import replaced, write_whole
from toolkit.foundation.files.toml_file import read_toml

NODE_DISTANCE = 1e-9
"""Part of the skin's length within which an interface point is on a station of the mesh."""
HEXAHEDRON = np.vstack([2 * CUBE, 2 * CUBE_MIDDLES]).round().astype(int)[:20]
"""Places of the 20 nodes in steps of half an element along the skin, through it and across it."""
MOST_NODES = 3_000_000
"""Largest number of nodes of the grid; a body of so many takes hours to reduce."""
FACE = np.array([[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1]])
"""The same of the 8 nodes of a section's faces, through the skin and across it."""


def extrude(path: Path, target: Path, layers: int = 8, remark: Remark | None = None) -> list[Path]:
    """Write the mesh of a skin.toml as a solid (gmsh's format), and beside it a body.toml with its groups.

    One hexahedron of 20 nodes through the thickness, one for each beam along the skin, `layers` across the width, from z = -width / 2 to
    width / 2. The groups are the sections at both ends, F and G, and those at the interface points. Solid elements round a sharp
    nose are stiffer than beams until they are shorter than its radius: 30 equal ones of the morphing wing by 16 %, 30 with
    spacing = "curvature" by 2 %.

    Returns
    -------
    files : the mesh and its description, which has the same name and the ending .toml

    Raises
    ------
    InputError
        The ending is not .msh, a file is in the way or cannot be used, the skin has what a solid of one material has not, or it is
        thicker than its nose is round.
    """
    described = target.with_suffix(".toml")
    if target.suffix != ".msh" or described.resolve() == path.resolve() or layers < 1:
        raise InputError(
            f"{str(target)!r} with {layers} layers is invalid: name a file *.msh, called otherwise than {path.name}, and a number of "
            "layers of at least 1."
        )
    if taken := [str(each) for each in (target, described) if each.exists()]:
        raise InputError(f"{' and '.join(taken)} would be overwritten. Move it away, or name another file.")
    content = read_toml(path, f"a {SkinRecipe.name}")
    if not SkinRecipe.means(content) and "skin" not in content:
        raise InputError(
            f"{path.name} describes no skin, and skins alone are extruded. Give a {SkinRecipe.name}, or leave --extrude out."
        )
    file = SkinRecipe.of(content, path).file
    refuse_what_is_lost(path, file)
    geometry = read_geometry(path, file, remark)
    with at_key(path, "section.thickness"):
        mesh = _mesh(geometry, file, places(path, geometry, file), layers)
    with replaced(target) as temporary:
        meshio.write(temporary, mesh, file_format="gmsh22", binary=False)
    write_whole(described, _description(file, target.name).encode())
    return [target, described]


def refuse_what_is_lost(path: Path, file: SkinFile) -> None:
    """Refuse a skin that is not one solid of one material and thickness.

    Raises
    ------
    InputError
        Names the key.
    """
    lost = {
        "groups": (
            bool(file.groups),
            "has groups of elements of their own, and a solid one material and thickness. Leave them out.",
        ),
        "skin.separate": (
            bool(file.skin.separate),
            "gives every element its own parameters, which a solid has not. Leave it out.",
        ),
        "material.state": (
            file.material.state == "plane-strain",
            "is plane strain, which the width of a solid decides. Leave it out.",
        ),
        "material": (file.material.poisson_ratio is None, "has no poisson_ratio, which a solid needs. Add it."),
    }
    for key, (found, why) in lost.items():
        if found:
            with at_key(path, key):
                raise InputError(f"the skin {why}")


def places(path: Path, geometry: Geometry, file: SkinFile) -> dict[str, float]:
    """Arc lengths of both ends and of the interface points."""
    found = {"F": 0.0, "G": float(np.real(geometry.skin.length))}
    for name, place in file.interface_points.items():
        with at_key(path, f"interface_points.{name}"):
            s = geometry.skin.locate(**place.model_dump(), stations=geometry.arc_lengths).real
            if name == "skin" or abs(s - found.get(name, s)) > NODE_DISTANCE * found["G"]:
                raise InputError("the solid's groups F, G and skin are its ends and all of it. Give the point another name.")
            found[name] = s
    return found


def _mesh(geometry: Geometry, file: SkinFile, at: dict[str, float], layers: int) -> meshio.Mesh:
    """Structured mesh, from a grid with two steps for each element along the skin, through it and across it."""
    ends = np.sort(np.concatenate([geometry.arc_lengths, list(at.values())]))
    stations = ends[np.append(True, np.diff(ends) > NODE_DISTANCE * ends[-1])]
    s = np.sort(np.concatenate([stations, (stations[1:] + stations[:-1]) / 2]))
    if (count := 3 * len(s) * (2 * layers + 1)) > MOST_NODES:
        raise InputError(
            f"{layers} layers make {count} nodes, and more than {MOST_NODES} are not written. Give fewer with --layers."
        )
    nodes = _grid(geometry, s, file.section.thickness, np.linspace(-0.5, 0.5, 2 * layers + 1) * file.section.width)
    number = np.arange(nodes[..., 0].size).reshape(nodes.shape[:3])
    solids = [number[tuple((2 * np.array([i, 0, k]) + HEXAHEDRON).T)] for i in range(len(stations) - 1) for k in range(layers)]
    blocks, tags = [("hexahedron20", np.array(solids))], [np.ones(len(solids), int)]
    for tag, place in enumerate(at.values(), 2):
        section = number[2 * int(np.argmin(np.abs(stations - place)))]
        blocks.append(("quad8", np.array([section[tuple((np.array([0, 2 * k]) + FACE).T)] for k in range(layers)])))
        tags.append(np.full(layers, tag))
    used, blocks = _used(blocks)
    names = {"skin": np.array([1, 3])} | {name: np.array([tag, 2]) for tag, name in enumerate(at, 2)}
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    return meshio.Mesh(nodes.reshape(-1, 3)[used], blocks, cell_data=data, field_data=names)


def _grid(geometry: Geometry, s: np.ndarray, thickness: float, z: np.ndarray) -> np.ndarray:
    """Positions at arc lengths, on the outer side, the middle line and the inner side, and at widths, (n_s, 3, n_z, 3)."""
    skin = geometry.skin
    sharpest = float(np.abs(skin.curvature(np.linspace(0, s[-1], 100 * len(s)))).max())
    if thickness / 2 * sharpest >= 1:
        raise InputError(f"half of the thickness {thickness:g} is more than the smallest radius of the skin, {1 / sharpest:.3g}.")
    angle = skin.tangent_angle(s)
    inward = np.column_stack([-np.sin(angle), np.cos(angle)])  # the contour runs anticlockwise
    across = thickness * np.array([-0.5, 0.0, 0.5])
    plane = skin.position(s)[:, None] + across[:, None] * inward[:, None]
    return np.concatenate(
        [np.broadcast_to(plane[:, :, None], (len(s), 3, len(z), 2)), np.broadcast_to(z[:, None], (len(s), 3, len(z), 1))], axis=3
    )


def _used(blocks: list[tuple[str, np.ndarray]]) -> tuple[np.ndarray, list[tuple[str, np.ndarray]]]:
    """Numbers of the nodes that elements have, and the elements by these."""
    used = np.unique(blocks[0][1])
    return used, [(kind, np.searchsorted(used, block)) for kind, block in blocks]


def _description(file: SkinFile, mesh: str) -> str:
    """Text of the body.toml."""
    points = {name: f"{{ group = {json.dumps(name)} }}" for name in file.interface_points}
    clamp = [] if file.basis.chord or file.basis.boundary == "free" else [f'clamp = {{ group = "{file.clamp}" }}']
    material = {key: getattr(file.material, key) for key in ("youngs_modulus", "density", "poisson_ratio")}
    basis = file.basis if file.basis.kind != "full" else file.basis.model_copy(update={"kind": "craig-bampton", "count": 10})
    lines = [
        "# The skin as a solid; its groups are sections of the mesh, F and G its ends.",
        f"units = {json.dumps(file.units)}",
        f"mesh = {{ file = {json.dumps(mesh)} }}",
        f"material = {_inline(material)}",
        f"damping = {_inline(file.damping)}",
        *clamp,
        f"basis = {_inline(basis)}",
        *(["", "[interface_points]"] if points else []),
        *(f"{json.dumps(name)} = {place}" for name, place in points.items()),
    ]
    return "\n".join(lines) + "\n"


def _inline(table: InputTable | dict[str, object]) -> str:
    """A table on one line."""
    given = table if isinstance(table, dict) else table.model_dump(exclude_none=True)
    return "{ " + ", ".join(f"{key} = {json.dumps(value)}" for key, value in given.items()) + " }"
