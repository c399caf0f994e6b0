"""A scene whose cut bodies are reduced beside the same scene with all coordinates: where the parts of one are in the other.

Some force r_i is left there at the coordinates i that a part does not keep. At rest it would move these by

    delta_i = -(K_ii^-1 - Phi (Phi^T K_ii Phi)^-1 Phi^T) r_i

in shapes that were left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse import block_diag, csc_array, csr_array, eye_array
from scipy.sparse.linalg import splu

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.cut.framed_part import FramedPart, whole_design
from toolkit.reduced_model.cut.craig_bampton import PartShapes
from toolkit.reduced_model.cut.part import Part
from toolkit.scene.cut_scene import written
from toolkit.scene.scene import Scene
from toolkit.system.system import System, compile_scene


@dataclass(frozen=True)
class ReducedPart:
    """One part with all coordinates, what is kept of them, and where it is in the full scene."""

    part: Part
    shapes: PartShapes
    rows: slice  # of its elastic coordinates

    @property
    def columns(self) -> np.ndarray:
        """All elastic coordinates per reduced one."""
        return self.shapes.columns(self.part.invariants.stiffness)

    def moved(self, forces: np.ndarray, stiffness: np.ndarray | None = None) -> np.ndarray:
        """-delta (n_t, n_f) under forces r (n_t, n_f), by a stiffness of its own (n_f, n_f) or another one; all real, or all complex."""
        stiffness = self.part.invariants.stiffness if stiffness is None else stiffness
        inner = np.delete(np.arange(len(stiffness)), self.shapes.kept)
        own, phi, found = stiffness[np.ix_(inner, inner)], self.shapes.modes, np.zeros_like(forces)
        if inner.size:
            held = forces[:, inner].T
            found[:, inner] = (splu(csc_array(own)).solve(held) - phi @ np.linalg.solve(phi.T @ own @ phi, phi.T @ held)).T
        return found


@dataclass(frozen=True)
class FullScene:
    """With all coordinates of the bodies that are reduced."""

    system: System
    parts: dict[str, dict[str, ReducedPart]]  # of every such body, by name
    expanded: csr_array  # its coordinates per coordinate of the reduced scene, (n_q, n_q)


def reduced_bodies(scene: Scene) -> dict[str, CutBody]:
    """Cut bodies whose parts do not keep all coordinates."""
    cut = {name: body for name, body in scene.bodies.items() if isinstance(body, CutBody)}
    return {name: body for name, body in cut.items() if body.modes_per_frame is not None}  # type: ignore[attr-defined]


def full_scene(scene: Scene) -> FullScene | None:
    """None of a scene in which nothing is reduced."""
    bodies = reduced_bodies(scene)
    if not bodies:
        return None
    plain = written(scene)
    changed = {name: plain.bodies[name].model_copy(update={"modes_per_frame": None}) for name in bodies}
    system = compile_scene(plain.model_copy(update={"bodies": {**plain.bodies, **changed}}))
    parts = {name: _parts(scene, system, name, body) for name, body in bodies.items()}
    return FullScene(system, parts, _expansion(system, {name: each for own in parts.values() for name, each in own.items()}))


def _parts(scene: Scene, full: System, name: str, body: CutBody) -> dict[str, ReducedPart]:
    """Those of one body by name."""
    found, every = {}, full.scene.all_bodies()
    for part_name, reduced in body.parts(name).items():
        whole = every[part_name]
        assert isinstance(reduced, FramedPart)
        assert isinstance(whole, FramedPart)
        part, shapes = whole.part(full.scene), reduced.shapes(whole_design(scene, name).model)
        assert shapes is not None
        start = full.numbering.first[part_name] + whole.frame_coordinates
        found[part_name] = ReducedPart(part, shapes, slice(start, start + part.n_f))
    return found


def _expansion(full: System, parts: Mapping[str, ReducedPart]) -> csr_array:
    blocks, first = [], [*full.numbering.first.items()]
    for (name, start), (_, end) in zip(first, [*first[1:], ("", full.n_q)], strict=True):
        blocks.append(eye_array((parts[name].rows.start if name in parts else end) - start))
        if name in parts:
            blocks.append(csr_array(parts[name].columns))
    return csr_array(block_diag(blocks))
