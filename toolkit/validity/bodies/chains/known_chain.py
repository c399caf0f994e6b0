"""The finite elements behind a body of a scene, if its reduced model tells them: by its mesh in the plane, by its elements in space."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from toolkit.bodies.cut.framed_part import FramedPart, whole_design
from toolkit.reduced_model.cut.part import Part
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.flexible_bodies import flexible_body
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.chord_rows import chord_rows
from toolkit.validity.bodies.chains.planar_chain import PlanarChain, planar_chain
from toolkit.validity.bodies.chains.second_order import clamped_rows
from toolkit.validity.bodies.chains.spatial_chain import SpatialChain, rows_of_part

SECTIONS = ("sections", "section_derivatives", "section_affine")
"""Parts of a reduced model that tell what its beams are made of, at every design."""


def has_chain(scene: ResolvedScene, body: str) -> bool:
    """Whether the reduced model of a flexible body holds the finite elements behind it."""
    return chain(scene, body) is not None


def chain(scene: ResolvedScene, body: str) -> Chain | None:
    """The finite elements behind a flexible body at the scene's parameter values; None if its reduced model does not hold them.

    Those of solids do not, nor those of reduced beams in space.
    """
    return _FINDERS[scene.dimension](scene, body)


def _in_plane(scene: ResolvedScene, body: str) -> Chain | None:
    written = flexible_body(scene, body)
    if isinstance(written, FramedPart):
        return _of_part(scene, written)
    design = written.design_point(scene, "mesh", "interfaces", *SECTIONS)
    if Chain not in design.kept:
        design.kept[Chain] = planar_chain(design)
    found: Chain | None = design.kept[Chain]
    return found


def _in_space(scene: ResolvedScene, body: str) -> Chain | None:
    written = flexible_body(scene, body)
    if isinstance(written, FramedPart):
        return _of_part(scene, written)
    design = written.design_point(scene, "elements", "element_derivatives", "element_affine")
    elements, shapes = design.model.elements, design.model.nodal_shapes
    if elements is None or shapes is None:
        return None
    if Chain not in design.kept:
        places, stiffness = (np.real(design.value(f"elements.{name}")) for name in ("nodes", "stiffness"))
        held = clamped_rows(shapes, SpatialChain.per_node)
        design.kept[Chain] = SpatialChain(shapes, held, places, elements.connectivity, stiffness)
    found: Chain = design.kept[Chain]
    return found


def _of_part(scene: ResolvedScene, written: FramedPart) -> Chain | None:
    """Elements of a part of a cut body, numbered from its first node."""
    design, part = whole_design(scene, written.whole), written.part(scene)
    key = (Chain, *written.own)
    if key not in design.kept:
        design.kept[key] = _CHAINS[scene.dimension](scene, written, part)
    found: Chain | None = design.kept[key]
    return found


def _spatial_part(scene: ResolvedScene, written: FramedPart, part: Part) -> Chain:
    stiffness = np.real(whole_design(scene, written.whole).value("elements.stiffness"))
    nodes = np.real(part.nodes)
    rows, own = rows_of_part(nodes), stiffness[part.first : part.last]
    return SpatialChain(np.real(part.recovery[:, 1:]), rows, nodes, _one_by_one(part), own)


def _planar_part(scene: ResolvedScene, written: FramedPart, part: Part) -> Chain | None:
    made_of = flexible_body(scene, written.whole).design_point(scene, *SECTIONS).sections()
    if made_of is None:
        return None
    nodes, connectivity = np.real(part.nodes), _one_by_one(part)
    rows, own = chord_rows(nodes, connectivity, nodes[0], nodes[-1]), made_of.of_elements(part.first, part.last).real
    return PlanarChain(np.real(part.recovery[:, 1:]), rows, nodes, connectivity, own)


def _one_by_one(part: Part) -> np.ndarray:
    """First and second node of every element of a part, (n_e, 2)."""
    first = np.arange(part.last - part.first)
    return np.column_stack([first, first + 1])


_CHAINS: Mapping[int, Callable[[ResolvedScene, FramedPart, Part], Chain | None]] = {2: _planar_part, 3: _spatial_part}
_FINDERS: Mapping[int, Callable[[ResolvedScene, str], Chain | None]] = {2: _in_plane, 3: _in_space}
"""By the dimension of space."""
