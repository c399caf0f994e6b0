"""How far bodies bend whose finite elements are not at hand: beams in space by the lines of their surface, solids by its points.

A line that turns by theta in the body's frame stays as long as it is and so loses theta^2 / 2 of its length along where it was, which a
linear body gains instead. The mean of that over all lines that turn, times the body's extent L, is how far its end is off: with d the
deflection of a cantilever's tip 0.6 d^2 / L, of an arc between the ends that hold its frame 2.7 d^2 / L. What a body without lines has is
taken for a cantilever; members of a frame that rest do not count.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import Caution
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import design_point, elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.known_chain import has_chain
from toolkit.validity.bodies.cut.more_frames import divided
from toolkit.validity.bodies.cut.places import displacements
from toolkit.validity.bodies.deformation import (
    LIMIT,
    Measured,
    deformations,
    largest_instants,
    whole_bodies,
)

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
    rotation: float  # largest angle that a line turns by in the frame, rad; nan of a body without lines
    size: float  # extent of the undeformed body

    @property
    def relative(self) -> float:
        """The error in parts of the displacement."""
        return self.error / self.displacement if self.displacement else 0.0


def bent_surfaces(solution: Solution) -> Iterator[Caution]:
    """Bodies in space, and meshed ones, that leave the range of small deformations."""
    for body in whole_bodies(solution.system.scene):
        found = bending(solution, body)
        if found is not None and not found.relative <= LIMIT:
            yield Caution("large-deformation", _told(solution.system.scene, body, found))


def geometric_errors(solution: Solution) -> dict[str, Measured | None]:
    """What the meters estimate of every flexible body; None of those that no meter knows."""
    return {body: bending(solution, body) if found is None else found for body, found in deformations(solution).items()}


def bending(solution: Solution, body: str) -> Bending | None:
    """How far one body bends; None where its finite elements tell it better, or nothing does.

    What all parts of a cut body lose adds up, in parts of the displacement of the whole.
    """
    written = solution.system.scene.bodies[body]
    names = list(written.parts(body)) if isinstance(written, CutBody) else [body]
    instants = largest_instants(np.real(solution.q[:, elastic_coordinates(solution, body)]))
    found = [each for name in names if (each := _bent(solution, name, instants)) is not None]
    if len(found) < len(names):
        return None
    whole = np.max([each.distance for each in found], axis=0)
    if isinstance(written, CutBody):  # a part that is twisted moves its surface, and none of the nodes on its axis
        whole = np.maximum(whole, displacements(solution, body, instants).max(axis=1))
    error = np.sum([each.error for each in found], axis=0)
    k = first_largest(error)
    size = np.ptp(np.concatenate([each.points for each in found]), axis=0).max()
    turned = max(each.turned[k] for each in found)
    return Bending(float(whole[k]), float(error[k]), float(solution.times[instants[k]]), float(turned), float(size))


class _Bent(NamedTuple):
    """One body, or part of one, in its frame."""

    distance: np.ndarray  # (n_t,) largest displacement of a point
    error: np.ndarray  # (n_t,)
    turned: np.ndarray  # (n_t,) largest angle of a line
    points: np.ndarray  # (n, d) undeformed


def _bent(solution: Solution, body: str, instants: np.ndarray) -> _Bent | None:
    """How far one body, or part of one, bends; None where that is known better, or not at all."""
    scene = solution.system.scene
    if has_chain(scene, body):
        return None
    design = design_point(scene, body, "surface", "outline")
    shown = "surface" if design.model.surface is not None else "outline" if design.model.outline is not None else ""
    if not shown:
        return None
    position = np.real(design.value(f"{shown}.position"))
    elastic = np.real(solution.q[instants][:, elastic_coordinates(solution, body)])
    moved = np.einsum("pdf,tf->tpd", position[:, :, 1:], elastic)
    distance = np.linalg.norm(moved, axis=2).max(axis=1)
    extent = float(np.ptp(position[:, :, 0], axis=0).max())
    lines = design.model.surface.lines if design.model.surface is not None else np.zeros((0, 2), int)
    if not len(lines):
        return _Bent(distance, CANTILEVER * distance**2 / extent, np.full(len(distance), np.nan), position[:, :, 0])
    lost, turned = _lost(position[:, :, 0], moved, lines)
    return _Bent(distance, extent * lost, turned, position[:, :, 0])


def _lost(points: np.ndarray, moved: np.ndarray, lines: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean of theta^2 / 2 over the lines that turn, by their length, and the largest theta, (n_t,)."""
    first, last = lines.T
    along = points[last] - points[first]
    length = np.linalg.norm(along, axis=1)
    change = (moved[:, last] - moved[:, first]) / length[:, None]
    sideways = np.sum(change**2, axis=2) - np.einsum("tld,ld->tl", change, along / length[:, None]) ** 2
    turning = np.where(sideways >= RESTING * sideways.max(axis=1, keepdims=True), length, 0.0)
    whole = turning.sum(axis=1)
    mean = np.divide(np.sum(sideways * turning, axis=1), 2 * whole, out=np.zeros(len(whole)), where=whole > 0)
    return mean, np.arctan(np.sqrt(np.maximum(sideways.max(axis=1), 0.0)))


def _told(scene: Scene, body: str, found: Bending) -> str:
    length = unit(scene.units, "length")
    where = "" if isinstance(scene.bodies[body], CutBody) else " in its frame"
    return (
        f"{body} leaves the range of small deformations: it is displaced by up to {found.displacement:.3g} {length}{where} at "
        f"t = {found.time:.4g}, and bodies that bend so far are off by some {found.error:.2g} {length}, {found.relative:.0%} of that "
        f"(limit {LIMIT:.0%}), because their lines grow where they turn. A stiffer body, or "
        f"{divided(scene, body, found.relative / LIMIT)}, make it smaller."
    )
