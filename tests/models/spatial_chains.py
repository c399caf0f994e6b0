"""Chains of beams through any nodes in the plane or in space, as frame.toml and scene, for tests of bodies with several frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import ffrf
from preprocessing import build, save
from tests.models.kept_files import write_once
from toolkit.scene.scene import Scene

FRAME = """units = "m-kg-s"
dimension = DIMENSION
clamp = ["N0"]
nodes = { NODES }
beams = [BEAMS]
interface_points = { root = { node = "N0" }, middle = { node = "NMIDDLE" }, tip = { node = "NLAST" } }
damping = { stiffness = DAMPING }
[sections]
s = { SECTION, material = "m" }
[materials]
m = { youngs_modulus = YOUNG, RATIO density = 1000.0 }
"""
SCENE = """units = "m-kg-s"
dimension = DIMENSION
[points]
root = { body = "beam", interface = "root" }
middle = { body = "beam", interface = "middle" }
tip = { body = "beam", interface = "tip" }
[bodies]
beam = { type = "flexible", model = "beam.h5", BODY }
"""
WHERE = "".join(f'{axis} = {{ type = "displacement", body = "beam", point = "tip", component = "{axis}" }}\n' for axis in "xyz")


def save_chain(
    folder: Path,
    nodes: np.ndarray,
    section: str = 'kind = "rectangle", thickness = 0.01, width = 0.02',
    young: float = 1e9,
    ratio: float = 0.3,
    damping: float = 0.0,
    orientation: tuple[float, float, float] = (0.0, 0.0, 1.0),
) -> None:
    """One element from node to node, clamped at the first; the point `middle` is the node half way."""
    space = nodes.shape[1] == 3
    across = f", orientation = {list(orientation)}" if space else ""
    listed = ", ".join(f"N{k} = {[float(x) for x in node]}" for k, node in enumerate(nodes))
    beams = ", ".join(f'{{ from = "N{k}", to = "N{k + 1}", section = "s", elements = 1{across} }}' for k in range(len(nodes) - 1))
    text = (
        FRAME.replace("DIMENSION", str(nodes.shape[1]))
        .replace("NODES", listed)
        .replace("BEAMS", beams)
        .replace("SECTION", section)
    )
    text = text.replace("NMIDDLE", f"N{(len(nodes) - 1) // 2}").replace("NLAST", f"N{len(nodes) - 1}")
    text = (
        text.replace("YOUNG", repr(young))
        .replace("RATIO", f"poisson_ratio = {ratio}," if space else "")
        .replace("DAMPING", repr(damping))
    )
    write_once(folder, text, lambda own: _build(own, text))


def _build(folder: Path, text: str) -> None:
    (folder / "frame.toml").write_text(text)
    save(build(folder / "frame.toml"), folder / "beam.h5")


def chain_scene(folder: Path, body: str, rest: str, dimension: int = 3) -> Scene:
    """A scene with the body `beam`; `rest` is what follows in the file."""
    (folder / "scene.toml").write_text(SCENE.replace("DIMENSION", str(dimension)).replace("BODY", body) + rest)
    return ffrf.read_scene(folder / "scene.toml")
