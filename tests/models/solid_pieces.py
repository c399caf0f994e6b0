"""Bars of solid elements that are cut into pieces across, as mesh with groups, body.toml and scene."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np

import ffrf
from preprocessing import build, save
from tests.models.kept_files import write_once
from tests.models.solid_bodies import box
from toolkit.reduced_model.file import load
from toolkit.reduced_model.model import ReducedModel
from toolkit.scene.scene import Scene

LENGTHS = (1.0, 0.05, 0.04)
YOUNG = 1e9
BODY = """units = "m-kg-s"
mesh.file = "bar.inp"
material = { youngs_modulus = YOUNG, density = 1000.0, poisson_ratio = RATIO }
clamp.group = "left"
interface_points.root.group = "left"
interface_points.tip.group = "right"
"""
SCENE = """units = "m-kg-s"
dimension = 3
[points]
root = { body = "bar", interface = "root" }
tip = { body = "bar", interface = "tip" }
[bodies]
bar = { type = "flexible", model = "bar.h5", BODY }
"""


def write_bar(
    folder: Path,
    count: int,
    faces: str = "averaged",
    more: str = "",
    kind: str = "hexahedron20",
    cells: tuple[int, int, int] = (4, 1, 1),
    lengths: tuple[float, float, float] = LENGTHS,
    ratio: float = 0.3,
    young: float = YOUNG,
) -> Path:
    """body.toml of a bar along x in so many pieces of equal length, p0 at the clamp; in none with as static a basis for a count of 0."""
    mesh = box(kind, cells, lengths)
    blocks = mesh.blocks[kind]
    place = (mesh.nodes[blocks].mean(axis=1)[:, 0] / lengths[0] * max(count, 1)).astype(int)
    groups = {f"p{k}": [np.flatnonzero(place == k)] for k in range(max(count, 1))}
    ends = {name: mesh.groups[name] for name in ("left", "right")}
    meshio.write(folder / "bar.inp", meshio.Mesh(mesh.nodes, [(kind, blocks)], cell_sets=groups, point_sets=ends))
    cut = f'pieces = {{ groups = {[*groups]}, faces = "{faces}" }}\n' if count else 'basis.kind = "static"\n'
    path = folder / "bar.toml"
    path.write_text(BODY.replace("YOUNG", repr(young)).replace("RATIO", repr(ratio)) + cut + more)
    return path


def save_bar(folder: Path, *args, more: str = "", **kwargs) -> ReducedModel:
    """The reduced model of `write_bar`, beside its file; `more` may name files of the folder."""

    def write(place: Path) -> None:
        save(build(write_bar(place, *args, more=more, **kwargs)), place / "bar.h5")

    if more:
        write(folder)
    else:
        write_once(folder, (args, tuple(sorted(kwargs.items()))), write)
    return load(folder / "bar.h5")


def bar_scene(folder: Path, body: str, rest: str) -> Scene:
    """A scene with the body `bar`; `rest` is what follows in the file."""
    (folder / "scene.toml").write_text(SCENE.replace("BODY", body) + rest)
    return ffrf.read_scene(folder / "scene.toml")
