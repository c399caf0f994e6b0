"""The finite elements behind a body of a scene, if its reduced model tells them: by its mesh in the plane, by its elements in space."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from toolkit.bodies.cut.framed_part import FramedPart, whole_design
from toolkit.reduced_model.cut.part import Part
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import design_point, flexible_body
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.planar_chain import planar_chain
from toolkit.validity.bodies.chains.second_order import clamped_rows
from toolkit.validity.bodies.chains.spatial_chain import SpatialChain, rows_of_part


def has_chain(scene: Scene, body: str) -> bool:
    """Whether the reduced model of a flexible body holds the finite elements behind it."""
    return chain(scene, body) is not None


def chain(scene: Scene, body: str) -> Chain | None:
    """The finite elements behind a flexible body at the scene's parameter values; None if its reduced model does not hold them.

    Those of solids do not, nor those of reduced beams in space.
    """
    return _FINDERS[scene.dimension](scene, body)


def _in_plane(scene: Scene, body: str) -> Chain | None:
    design = design_point(scene, body, "mesh", "stress", "interfaces")
    if Chain not in design.kept:
        design.kept[Chain] = planar_chain(design)
    found: Chain | None = design.kept[Chain]
    return found


def _in_space(scene: Scene, body: str) -> Chain | None:
    written = flexible_body(scene, body)
    if isinstance(written, FramedPart):
        return _of_part(scene, written)
    design = written.design_point(scene, "elements", "element_derivatives", "element_affine")
    elements = design.model.elements
    shapes = None if elements is None else elements.shapes(design.model.mesh)
    if elements is None or shapes is None:
        return None
    if Chain not in design.kept:
        places, stiffness = (np.real(design.value(f"elements.{name}")) for name in ("nodes", "stiffness"))
        held = clamped_rows(shapes, SpatialChain.per_node)
        design.kept[Chain] = SpatialChain(shapes, held, places, elements.connectivity, stiffness)
    found: Chain = design.kept[Chain]
    return found


def _of_part(scene: Scene, written: FramedPart) -> Chain:
    """Elements of a part of a cut body, numbered from its first node."""
    design, part = whole_design(scene, written.whole), written.part(scene)
    key = (Chain, *written.own)
    if key not in design.kept:
        design.kept[key] = _chain_of_part(part, np.real(design.value("elements.stiffness")))
    found: Chain = design.kept[key]
    return found


def _chain_of_part(part: Part, stiffness: np.ndarray) -> Chain:
    first = np.arange(part.last - part.first)
    connectivity, nodes = np.column_stack([first, first + 1]), np.real(part.nodes)
    return SpatialChain(
        np.real(part.recovery[:, 1:]), rows_of_part(nodes), nodes, connectivity, stiffness[part.first : part.last]
    )


_FINDERS: Mapping[int, Callable[[Scene, str], Chain | None]] = {2: _in_plane, 3: _in_space}
"""By the dimension of space."""
