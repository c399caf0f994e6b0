"""The small-deformation meter: how far a flexible body has left the range in which linear deformation in its frame is true.

A body is linear in its frame: an element that turns by an angle theta there grows by theta^2 / 2, and its forces keep their directions and
lever arms. The meter estimates by how much the nodes would be elsewhere if the same forces acted on the same elements, turning with them
(corotational): the displacement of second order of `second_order`.

It knows the beam elements of the plane only; `bent_surfaces` estimates it of solids and of bodies in space.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.near_ties import first_largest
from toolkit.reduced_model.chord_condition import chord_of
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.model import MEAN_AXES, ReducedModel
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import deforming, design_point, elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chord_rows import chord_rows
from toolkit.validity.bodies.cut.joined_errors import BentPart, joined_errors
from toolkit.validity.bodies.cut.places import displacements, undeformed_places
from toolkit.validity.bodies.element_sections import Elements, Sections, sections
from toolkit.validity.bodies.second_order import clamped_rows, displacements_under, mean_rows, second_order_displacement
from toolkit.validity.bodies.spinning.stiffened import kept_back

LIMIT = 0.05
"""Part of the largest displacement that the geometric error may be: an element that turns by 0.1 rad, 6 degrees, is about there.
Up to here the estimate is good to some ten percent, and the errors of stresses and positions are of the same order as the number itself."""

INSTANTS = 50
"""The meter looks at so many instants of a run, those of the largest elastic coordinates."""


class Measured(Protocol):
    """How far a body is deformed, and its estimated error."""

    @property
    def rotation(self) -> float:
        """Largest rotation in the frame, rad."""

    @property
    def displacement(self) -> float:
        """Largest displacement."""

    @property
    def error(self) -> float:
        """A distance."""

    @property
    def size(self) -> float:
        """Extent of the undeformed body."""

    @property
    def time(self) -> float:
        """The instant of the largest error."""

    @property
    def relative(self) -> float:
        """The error in parts of the largest displacement."""


@dataclass(frozen=True)
class Deformation:
    """How far a body is deformed at the instant of the largest geometric error; lengths in the units of the scene."""

    rotation: float  # largest rotation of a node in the body's frame, rad
    displacement: float  # largest displacement of a node in the body's frame
    error: float  # estimated distance of a node to where the same forces would bring it if the elements turned
    size: float  # extent of the undeformed body
    time: float

    @property
    def relative(self) -> float:
        """The error in parts of the largest displacement."""
        return self.error / self.displacement if self.displacement else 0.0

    @property
    def exceeded(self) -> bool:
        """Whether the linear body is out of its range."""
        return not self.relative <= LIMIT


@dataclass(frozen=True)
class Chain:
    """The finite elements behind a body: what they are made of, and how the elastic coordinates move them."""

    elements: Elements
    made_of: Sections
    shapes: np.ndarray  # (n, n_f)
    held: np.ndarray  # (m, n) rows of displacements that the body's frame does not feel

    def displacements(self, elastic: np.ndarray) -> np.ndarray:
        """Nodal displacements (n_t, n) of elastic coordinates (n_t, n_f)."""
        return elastic @ self.shapes.T

    def second_order(self, u: np.ndarray) -> np.ndarray:
        """What the linear displacements (n_t, n) lack, to second order."""
        return second_order_displacement(self.elements, self.made_of, self.held, u)

    def under(self, loads: np.ndarray) -> np.ndarray:
        """Linear displacements (n_t, n) of all elements under loads (n_t, n), whatever the basis holds."""
        return displacements_under(self.elements, self.made_of, self.held, loads)


def flexible_bodies(scene: Scene) -> list[str]:
    """Names of the bodies that deform; of a cut body those of its parts."""
    return list(deforming(scene))


def has_chain(scene: Scene, body: str) -> bool:
    """Whether the reduced model of a flexible body holds the finite elements behind it."""
    model = design_point(scene, body, "mesh", "stress", "interfaces").model
    return model.mesh is not None and model.stress is not None


def chain(scene: Scene, body: str) -> Chain | None:
    """The finite elements behind a flexible body at the scene's parameter values; None if its reduced model does not hold them.

    Those of bodies in space and of solids do not.
    """
    design = design_point(scene, body, "mesh", "stress", "interfaces")
    if Chain not in design.kept:
        design.kept[Chain] = _chain(design)
    found: Chain | None = design.kept[Chain]
    return found


def _chain(design: DesignPoint) -> Chain | None:
    mesh, places = design.model.mesh, design.model.stress
    if mesh is None or places is None:
        return None
    modulus = next((value for name, value in design.model.nominal.items() if name.startswith("youngs_modulus")), 1.0)
    operator, stiffness = (np.real(design.value(item)) for item in ("stress_operator", "stiffness"))
    elements, shapes = Elements(mesh.nodes, mesh.connectivity), mesh.recovery[:, 1:]
    held = _held(design.model, elements, shapes)
    return Chain(elements, sections(mesh, places, operator, stiffness, modulus), shapes, held)


def _held(model: ReducedModel, elements: Elements, shapes: np.ndarray) -> np.ndarray:
    """Rows of displacements that the reference condition keeps at zero."""
    if model.reference_condition == MEAN_AXES:
        return mean_rows(elements)
    if chord := chord_of(model.reference_condition):
        return chord_rows(elements, *((model.interfaces or {})[name].position[0, :, 0] for name in chord))
    return clamped_rows(elements, shapes)


def deformations(solution: Solution) -> dict[str, Deformation | None]:
    """The meter's numbers for every flexible body; None where the reduced model does not hold its finite elements."""
    if Deformation not in solution.known:
        solution.known[Deformation] = {name: deformation(solution, name) for name in whole_bodies(solution.system.scene)}
    found: dict[str, Deformation | None] = solution.known[Deformation]
    return found


def whole_bodies(scene: Scene) -> list[str]:
    """Names of the flexible bodies, cut or not."""
    return [name for name, body in scene.bodies.items() if isinstance(body, ModelBody)]


def deformation(solution: Solution, body: str) -> Deformation | None:
    """The meter's numbers for one body."""
    written = solution.system.scene.bodies.get(body)
    if isinstance(written, CutBody):
        return _of_parts(solution, body, written)
    behind = chain(solution.system.scene, body)
    return None if behind is None else deformation_of(behind, solution, body)


def _of_parts(solution: Solution, body: str, written: CutBody) -> Deformation | None:
    """Of a cut body: the errors of its parts, each in its own frame, add up to one of the whole, which the whole is measured by."""
    scene = solution.system.scene
    instants = largest_instants(np.real(solution.q[:, elastic_coordinates(solution, body)]))
    found = [_bent_part(solution, name, instants) for name in written.parts(body)]
    parts = [each[0] for each in found if each is not None]
    if len(parts) < len(found):
        return None
    lost = joined_errors(parts, _held_node(scene, written))
    error, moved = np.hypot(lost[:, :, 0], lost[:, :, 1]).max(axis=1), displacements(solution, body, instants).max(axis=1)
    worst = first_largest(error)
    rotation = max(each[1][worst] for each in found if each is not None)
    extent = np.ptp(undeformed_places(scene, body), axis=0).max()
    time = solution.times[instants[worst]]
    return Deformation(float(rotation), float(moved[worst]), float(error[worst]), float(extent), float(time))


def _bent_part(solution: Solution, name: str, instants: np.ndarray) -> tuple[BentPart, np.ndarray] | None:
    """A part where it is, and the largest rotation of its nodes in its frame, (n_t,); None where its elements are not known."""
    scene = solution.system.scene
    part: Any = scene.body(name)
    behind = chain(scene, name)
    if behind is None:
        return None
    u = behind.displacements(np.real(solution.q[instants][:, elastic_coordinates(solution, name)]))
    origins, axes = part.poses(np.real(solution.q[instants][:, solution.coordinates(name)]))
    bent, lacks = (each.reshape(len(instants), -1, 3) for each in (u, behind.second_order(u)))
    places = origins[:, None] + np.einsum("tij,tnj->tni", axes, behind.elements.nodes + bent[:, :, :2])
    turned = np.concatenate([np.einsum("tij,tnj->tni", axes, lacks[:, :, :2]), lacks[:, :, 2:]], axis=2)
    return BentPart(part.node_numbers(scene), places, turned), np.abs(u[:, 2::3]).max(axis=1)


def _held_node(scene: Scene, written: Any) -> int | None:
    """A node that holds a grounded body."""
    model = scene.model(written.model, "elements", "mesh")
    if written.frame != "grounded" or model.elements is None:
        return None
    return int(model.elements.held_nodes(model.mesh)[0])


def deformation_of(behind: Chain, solution: Solution, body: str) -> Deformation:
    """The meter's numbers for one body whose finite elements are known."""
    elastic = np.real(solution.q[:, elastic_coordinates(solution, body)])
    instants = largest_instants(elastic)
    u, held_back = behind.displacements(elastic[instants]), kept_back(solution, body, instants)
    lacks = behind.second_order(u)
    if held_back is not None:
        lacks = lacks + behind.displacements(held_back)
    moved, error = distances(u), distances(lacks)
    worst = first_largest(error.max(axis=1))
    extent = np.ptp(behind.elements.nodes, axis=0).max()
    rotation, time = np.abs(u[worst, 2::3]).max(), solution.times[instants[worst]]
    return Deformation(float(rotation), float(moved[worst].max()), float(error[worst].max()), float(extent), float(time))


def largest_instants(elastic: np.ndarray) -> np.ndarray:
    """Numbers of the instants at which elastic coordinates (n_t, n_f) are largest in their own scale, in order of time."""
    scale = np.abs(elastic).max(axis=0)
    size = np.linalg.norm(elastic / np.where(scale > 0, scale, 1.0), axis=1)
    return np.sort(np.argsort(-size, kind="stable")[:INSTANTS])


def distances(u: np.ndarray) -> np.ndarray:
    """Lengths (n_t, n_nodes) of nodal displacements (n_t, 3 n_nodes)."""
    return np.hypot(u[:, 0::3], u[:, 1::3])
