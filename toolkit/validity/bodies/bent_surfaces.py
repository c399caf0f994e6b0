"""How far bodies bend whose finite elements are not at hand: beams in space by the lines of their surface, solids by its points.

A line that turns by theta in the body's frame stays as long as it is and so loses theta^2 / 2 of its length along where it was, which a
linear body gains instead. The mean of that over all lines that turn, times the body's extent L, is how far its end is off: with d the
deflection of a cantilever's tip 0.6 d^2 / L, of an arc between the ends that hold its frame 2.7 d^2 / L. What a body without lines has is
taken for a cantilever; members of a frame that rest do not count.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from toolkit.bodies.cut.framed_part import FramedPart
from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import Caution
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import deforming, design_point, elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.deformation import LIMIT, chain, largest_instants

CANTILEVER = 0.6
"""Of d^2 / L, for a force at its tip."""
RESTING = 1e-2
"""Lines that turn by less than a tenth of the largest angle belong to members that hardly bend; of a cantilever they are a twentieth."""


@dataclass(frozen=True)
class Bending:
    """The instant of the largest estimated error; lengths in the units of the scene."""

    displacement: float  # largest displacement of a point in the body's frame
    error: float
    time: float

    @property
    def relative(self) -> float:
        """The error in parts of the displacement."""
        return self.error / self.displacement if self.displacement else 0.0


def bent_surfaces(solution: Solution) -> Iterator[Caution]:
    """Bodies in space, and meshed ones, that leave the range of small deformations; of a cut body its worst part speaks."""
    scene = solution.system.scene
    worst: dict[str, Bending] = {}
    for body, each in deforming(scene).items():
        found = bending(solution, body)
        whole = each.whole if isinstance(each, FramedPart) else body
        if found is not None and (whole not in worst or found.relative > worst[whole].relative):
            worst[whole] = found
    for body, found in worst.items():
        if not found.relative <= LIMIT:
            yield Caution("large-deformation", _told(scene, body, found))


def bending(solution: Solution, body: str) -> Bending | None:
    """How far one body bends; None where its finite elements tell it better, or nothing does."""
    scene = solution.system.scene
    if chain(scene, body) is not None:
        return None
    design = design_point(scene, body, "surface", "outline")
    shown = "surface" if design.model.surface is not None else "outline" if design.model.outline is not None else ""
    if not shown:
        return None
    position = np.real(design.value(f"{shown}.position"))
    elastic = np.real(solution.q[:, elastic_coordinates(solution, body)])
    instants = largest_instants(elastic)
    moved = np.einsum("pdf,tf->tpd", position[:, :, 1:], elastic[instants])
    distance = np.linalg.norm(moved, axis=2).max(axis=1)
    extent = float(np.ptp(position[:, :, 0], axis=0).max())
    lines = design.model.surface.lines if design.model.surface is not None else np.zeros((0, 2), int)
    error = extent * _lost(position[:, :, 0], moved, lines) if len(lines) else CANTILEVER * distance**2 / extent
    k = first_largest(error)
    return Bending(float(distance[k]), float(error[k]), float(solution.times[instants[k]]))


def _lost(points: np.ndarray, moved: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """Mean of theta^2 / 2 over the lines that turn, by their length, (n_t,)."""
    first, last = lines.T
    along = points[last] - points[first]
    length = np.linalg.norm(along, axis=1)
    change = (moved[:, last] - moved[:, first]) / length[:, None]
    sideways = np.sum(change**2, axis=2) - np.einsum("tld,ld->tl", change, along / length[:, None]) ** 2
    turning = np.where(sideways >= RESTING * sideways.max(axis=1, keepdims=True), length, 0.0)
    whole = turning.sum(axis=1)
    return np.divide(np.sum(sideways * turning, axis=1), 2 * whole, out=np.zeros(len(whole)), where=whole > 0)


def _told(scene: Scene, body: str, found: Bending) -> str:
    length = unit(scene.units, "length")
    return (
        f"{body} leaves the range of small deformations: it is displaced by up to {found.displacement:.3g} {length} in its frame at "
        f"t = {found.time:.4g}, and bodies that bend so far are off by some {found.error:.2g} {length}, {found.relative:.0%} of that "
        f"(limit {LIMIT:.0%}), because their lines grow where they turn. A stiffer body, or several in a row, make it smaller; a body of "
        "beams takes more `frames`."
    )
