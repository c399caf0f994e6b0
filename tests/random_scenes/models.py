"""Small reduced models of random scenes, built where they are missing."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from preprocessing import build
from preprocessing.elements.section import Section
from preprocessing.reduction.basis import BasisChoice
from tests.models.beam_models import save_beam
from tests.models.solid_bodies import box, write_body
from toolkit.reduced_model.file import load, save

BEAM = Section(youngs_modulus=2e9, density=1200.0, thickness=0.02, width=0.03, damping_mass=0.05, damping_stiffness=1e-3)
STRAIGHT, BENT = ((0.0, 0.0), (0.5, 0.0), (1.0, 0.0)), ((0.0, 0.0), (0.3, 0.1), (0.6, 0.35), (0.8, 0.7))
FINE = tuple((k / 6, 0.0) for k in range(7))
PLANAR = {
    "straight": (STRAIGHT, BasisChoice("full")),
    "bent": (BENT, BasisChoice("full")),
    "modes": (FINE, BasisChoice("eigenmodes", count=3)),
    "free": (BENT, BasisChoice("eigenmodes", boundary="free", count=4)),
    "craig": (FINE, BasisChoice("craig-bampton", count=2)),
}
"""Name -> polygon and basis of the beams in the plane; points start, middle, end."""

FRAME = """units = "m-kg-s"
clamp = ["A"]
nodes = {{ A = [0.0, 0.0, 0.0], B = {middle}, C = {end} }}
beams = [
    {{ from = "A", to = "B", section = "bar", elements = {elements} }},
    {{ from = "B", to = "C", section = "bar", elements = {elements} }},
]
damping = {{ mass = 0.05, stiffness = 1e-3 }}
interface_points = {{ start = {{ node = "A" }}, middle = {{ node = "B" }}, end = {{ node = "C" }} }}
basis = {{ {basis} }}
[sections]
bar = {{ {section}, material = "plastic" }}
[materials]
plastic = {{ youngs_modulus = 2e9, poisson_ratio = 0.35, density = 1200.0 }}
"""
BAR, TUBE = 'kind = "rectangle", thickness = 0.02, width = 0.035', 'kind = "tube", diameter = 0.03, wall = 0.004'
SPATIAL = {
    "mast": ([0.5, 0.1, 0.0], [0.9, 0.4, 0.2], 1, 'kind = "full"', BAR),
    "pipe": ([0.4, 0.05, 0.02], [0.8, 0.0, -0.1], 2, 'kind = "eigenmodes", count = 4', TUBE),
    "bar": ([0.5, 0.0, 0.0], [1.0, 0.0, 0.0], 2, 'kind = "craig-bampton", count = 2', BAR),
}
"""Name -> nodes, elements per beam, basis and section of the frames in space; points start, middle, end."""

PERIODS = {
    "straight": 0.24,
    "bent": 0.2,
    "modes": 0.24,
    "free": 0.1,
    "craig": 0.24,
    "mast": 0.3,
    "pipe": 0.1,
    "bar": 0.24,
    "block": 0.04,
}
"""About the longest period of each, clamped or free as its basis is."""


def model_file(directory: Path, name: str) -> str:
    """The name of the reduced model's file in the directory, which is built if it is missing."""
    path = directory / f"{name}.h5"
    if not path.exists():
        _build(directory, name, path)
    return path.name


FINER = 4
"""Elements of a finer model in place of each of a model."""


def finer_file(directory: Path, name: str) -> str | None:
    """The name of a file like that of `model_file` with more elements and all of their shapes; None where it is no beam."""
    path = directory / f"{name}_finer.h5"
    if name not in PLANAR and name not in SPATIAL:
        return None
    if not path.exists():
        _build(directory, name, path, finer=FINER)
    return path.name


def _build(directory: Path, name: str, path: Path, finer: int = 1) -> None:
    if name in PLANAR:
        polygon, basis = PLANAR[name]
        nodes = np.array(polygon)
        lengths = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(nodes, axis=0), axis=1)))
        places = {"start": 0.0, "middle": float(lengths[len(lengths) // 2]), "end": float(lengths[-1])}
        save_beam(path, _refined(nodes, finer), BEAM, places, basis=basis if finer == 1 else BasisChoice("full"))
    elif name in SPATIAL:
        middle, end, elements, basis, section = SPATIAL[name]
        basis = basis if finer == 1 else 'kind = "full"'
        text = FRAME.format(middle=middle, end=end, elements=finer * elements, basis=basis, section=section)
        path.with_suffix(".toml").write_text(text)
        save(build(path.with_suffix(".toml")), path)
    else:
        folder = directory / name
        folder.mkdir(exist_ok=True)
        top = "[pressure_surfaces.top]\nbox = [0.0, -0.075, 0.06, 0.6, 0.075, 0.06]"
        brick = write_body(folder, box("hexahedron", (1, 1, 1), (0.6, 0.15, 0.12)), more=top)
        save(build(brick, values={"youngs_modulus": 1e7, "density": 1100.0, "damping_stiffness": 3e-4}), path)


def _refined(nodes: np.ndarray, parts: int) -> np.ndarray:
    """Nodes (n, 2) with so many elements in place of each."""
    steps = np.arange(parts * (len(nodes) - 1) + 1) / parts
    return np.stack([np.interp(steps, np.arange(len(nodes)), each) for each in nodes.T], axis=1)


@cache
def local_places(path: Path) -> dict[str, np.ndarray]:
    """Undeformed positions of the interface points in the body's frame."""
    interfaces = load(path, ("interfaces",)).interfaces or {}
    return {name: np.array(point.here[0][:, 0]) for name, point in interfaces.items()}
