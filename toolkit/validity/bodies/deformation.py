"""The small-deformation meter: how far a flexible body has left the range in which linear deformation in its frame is true.

A body is linear in its frame: an element that turns by an angle theta there grows by theta^2 / 2, and its forces keep their directions and
lever arms. The meter estimates by how much the nodes would be elsewhere if the same forces acted on the same elements, turning with them
(corotational): the displacement of second order of `second_order`.

It knows beam elements, in the plane and in space; `bent_surfaces` estimates it of solids.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.near_ties import first_largest
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.flexible_bodies import deforming, elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.known_chain import chain
from toolkit.validity.bodies.cut.joined_errors import BentPart, in_space, joined_errors
from toolkit.validity.bodies.cut.places import displacements, undeformed_places
from toolkit.validity.bodies.spinning.stiffened import kept_back

ROUND_OFF = 1e-12
"""Displacement, relative to a body's extent, below which it is round-off."""
LIMIT = 0.05
"""Part of the largest displacement that the geometric error may be: an element that turns by 0.1 rad, 6 degrees, is about there.
Up to here the estimate is good to some ten percent, and the errors of stresses and positions are of the same order as the number itself."""

INSTANTS = 50
"""Number of instants of a run that the meter examines, those of the largest elastic coordinates."""


@dataclass(frozen=True)
class Deformation:
    """Deformation of a body at the instant of the largest geometric error; lengths in the units of the scene."""

    rotation: float  # largest rotation of a node in the body's frame, rad
    displacement: float  # largest displacement of a node in the body's frame
    error: float  # estimated distance of a node to where the same forces would bring it if the elements turned
    size: float  # extent of the undeformed body
    time: float

    @property
    def relative(self) -> float:
        """Geometric error relative to the largest displacement; zero where this is round-off."""
        return self.error / self.displacement if self.displacement > ROUND_OFF * self.size else 0.0

    @property
    def exceeded(self) -> bool:
        """Whether the geometric error exceeds its limit, so that the linear body is out of its range."""
        return not self.relative <= LIMIT


def flexible_bodies(scene: ResolvedScene) -> list[str]:
    """Names of the bodies that deform; for a cut body the names of its parts."""
    return list(deforming(scene))


def deformations(solution: Solution) -> dict[str, Deformation | None]:
    """Measured deformation of every flexible body; None where the reduced model does not hold its finite elements."""
    if Deformation not in solution.known:
        solution.known[Deformation] = {name: deformation(solution, name) for name in whole_bodies(solution.system.scene)}
    found: dict[str, Deformation | None] = solution.known[Deformation]
    return found


def whole_bodies(scene: ResolvedScene) -> list[str]:
    """Names of the flexible bodies, cut or not."""
    return [name for name, body in scene.bodies.items() if isinstance(body, ModelBody)]


def deformation(solution: Solution, body: str) -> Deformation | None:
    """Measured deformation of one body; None where its finite elements are not known."""
    written = solution.system.scene.bodies.get(body)
    if isinstance(written, CutBody):
        return _of_parts(solution, body, written)
    behind = chain(solution.system.scene, body)
    return None if behind is None else deformation_of(behind, solution, body)


def _of_parts(solution: Solution, body: str, written: CutBody) -> Deformation | None:
    """The meter's numbers for a cut body.

    The errors of its parts, each in its own frame, add up to one of the whole, relative to the whole's displacement.
    """
    scene = solution.system.scene
    instants = instants_of(solution, body)
    found = [_bent_part(solution, name, instants) for name in written.parts(body)]
    parts = [each[0] for each in found if each is not None]
    if len(parts) < len(found):
        return None
    lost = joined_errors(parts, _held_node(scene, written))
    error, moved = np.linalg.norm(lost, axis=2).max(axis=1), displacements(solution, body, instants).max(axis=1)
    worst = first_largest(error)
    rotation = max(each[1][worst] for each in found if each is not None)
    extent = np.ptp(undeformed_places(scene, body), axis=0).max()
    time = solution.times[instants[worst]]
    return Deformation(float(rotation), float(moved[worst]), float(error[worst]), float(extent), float(time))


def _bent_part(solution: Solution, name: str, instants: np.ndarray) -> tuple[BentPart, np.ndarray] | None:
    """A part with its errors, and the largest rotation of its nodes in its frame, (n_t,); None without known elements."""
    scene = solution.system.scene
    part: Any = scene.body(name)
    behind = chain(scene, name)
    if behind is None:
        return None
    u = behind.displacements(np.real(solution.q[instants][:, elastic_coordinates(solution, name)]))
    origins, axes = part.poses(np.real(solution.q[instants][:, solution.coordinates(name)]))
    moved, (lost, lost_turn) = behind.by_node(u)[0], behind.by_node(behind.second_order(u))
    places = origins[:, None] + np.einsum("tij,tnj->tni", axes, behind.nodes + moved)
    turn = np.einsum("tij,tnj->tni", axes, lost_turn) if lost_turn.shape[2] == 3 else lost_turn
    errors = in_space(np.einsum("tij,tnj->tni", axes, lost), turn)
    return BentPart(part.node_numbers(scene), in_space(places), errors), behind.rotations(u).max(axis=1)


def _held_node(scene: ResolvedScene, written: Any) -> int | None:
    """Number of a node that holds a grounded body; None of other bodies."""
    model = scene.model(written.model, "elements", "mesh")
    if written.frame != "grounded" or model.elements is None:
        return None
    return int(model.elements.held_nodes(model.mesh)[0])


def deformation_of(behind: Chain, solution: Solution, body: str) -> Deformation:
    """Measured deformation of one body whose finite elements are known."""
    elastic, instants = np.real(solution.q[:, elastic_coordinates(solution, body)]), instants_of(solution, body)
    u, held_back = behind.displacements(elastic[instants]), kept_back(solution, body, instants)
    lacks = behind.second_order(u)
    if held_back is not None:
        lacks = lacks + behind.displacements(held_back)
    moved, error = behind.distances(u), behind.distances(lacks)
    worst = first_largest(error.max(axis=1))
    extent = np.ptp(behind.nodes, axis=0).max()
    rotation, time = behind.rotations(u)[worst].max(), solution.times[instants[worst]]
    return Deformation(float(rotation), float(moved[worst].max()), float(error[worst].max()), float(extent), float(time))


def instants_of(solution: Solution, body: str) -> np.ndarray:
    """Instants of the largest deformation of a body, or of a part of one, by `largest_instants`, found once."""
    key = largest_instants, body
    if key not in solution.known:
        solution.known[key] = largest_instants(np.real(solution.q[:, elastic_coordinates(solution, body)]))
    found: np.ndarray = solution.known[key]
    return found


def largest_instants(elastic: np.ndarray, count: int = INSTANTS) -> np.ndarray:
    """Numbers of the instants at which elastic coordinates (n_t, n_f) are largest in their own scale, in order of time."""
    scale = np.abs(elastic).max(axis=0)
    size = np.linalg.norm(elastic / np.where(scale > 0, scale, 1.0), axis=1)
    return np.sort(np.argsort(-size, kind="stable")[:count])
