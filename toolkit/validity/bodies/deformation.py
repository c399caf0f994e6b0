"""The small-deformation meter: how far a flexible body has left the range in which linear deformation in its frame is true.

A body is linear in its frame: an element that turns by an angle theta there grows by theta^2 / 2, and its forces keep their directions and
lever arms. The meter estimates by how much the nodes would be elsewhere if the same forces acted on the same elements, turning with them
(corotational): the displacement of second order of `second_order`.

It knows the beam elements of the plane only; `bent_surfaces` estimates it of solids and of bodies in space.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolkit.bodies.cut.framed_part import FramedPart
from toolkit.foundation.near_ties import first_largest
from toolkit.reduced_model.chord_condition import chord_of
from toolkit.reduced_model.model import MEAN_AXES, ReducedModel
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import deforming, design_point, elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chord_rows import chord_rows
from toolkit.validity.bodies.element_sections import Elements, Sections, sections
from toolkit.validity.bodies.second_order import clamped_rows, mean_rows, second_order_displacement

LIMIT = 0.05
"""Part of the largest displacement that the geometric error may be: an element that turns by 0.1 rad, 6 degrees, is about there.
Up to here the estimate is good to some ten percent, and the errors of stresses and positions are of the same order as the number itself."""

INSTANTS = 50
"""The meter looks at so many instants of a run, those of the largest elastic coordinates."""


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


def flexible_bodies(scene: Scene) -> list[str]:
    """Names of the bodies that deform; of a cut body those of its parts."""
    return list(deforming(scene))


def chain(scene: Scene, body: str) -> Chain | None:
    """The finite elements behind a flexible body at the scene's parameter values; None if its reduced model does not hold them.

    Those of bodies in space and of solids do not.
    """
    design = design_point(scene, body, "mesh", "stress", "interfaces")
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
    """The meter's numbers for every flexible body; None where the reduced model does not hold its finite elements.

    A cut body is as far off as the worst of its parts: each bends in its own frame, and the whole by what its parts bend.
    """
    found: dict[str, Deformation | None] = {}
    for body, each in deforming(solution.system.scene).items():
        name = each.whole if isinstance(each, FramedPart) else body
        found[name] = _worse(found.get(name), deformation(solution, body))
    return found


def _worse(one: Deformation | None, other: Deformation | None) -> Deformation | None:
    if one is None or other is None:
        return one or other
    return other if other.relative > one.relative else one


def deformation(solution: Solution, body: str) -> Deformation | None:
    """The meter's numbers for one body."""
    behind = chain(solution.system.scene, body)
    return None if behind is None else deformation_of(behind, solution, body)


def deformation_of(behind: Chain, solution: Solution, body: str) -> Deformation:
    """The meter's numbers for one body whose finite elements are known."""
    elastic = np.real(solution.q[:, elastic_coordinates(solution, body)])
    instants = largest_instants(elastic)
    u = behind.displacements(elastic[instants])
    moved, error = distances(u), distances(behind.second_order(u))
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
