"""The skin in space: the beams of the plane with width across it, so that it can also bend out of its plane and twist.

In its plane it is exactly the planar skin: the mass lies on the middle line of every rectangle, see `section_shape.strip`. Out of it the
rectangle t x b bends with E t b^3 / 12 and twists with G (b t^3 / 3 - 0.21 t^4), G = E / (2 (1 + nu)).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from preprocessing.assembly.spatial_assembly import BeamMesh, SpatialPatch, assemble
from preprocessing.discretisation.spatial_discretisation import SpatialDiscretisation
from preprocessing.elements.section import Patch
from preprocessing.elements.section_shape import strip
from preprocessing.recipes.skin.geometry import Geometry


def spatial_skin(
    geometry: Geometry, patches: Iterable[Patch], places: Mapping[str, Any], modulus_factor: Any, poisson_ratio: Any
) -> SpatialDiscretisation:
    """Spatial beams along the skin, in the plane z = 0, with the thickness in the plane and the width along z.

    Parameters
    ----------
    places : interface point -> its arc length
    modulus_factor : by which E is multiplied in stretching and bending
    poisson_ratio : for G in torsion
    """
    nodes = geometry.mesh.nodes
    across = np.tile([0.0, 0.0, 1.0], (len(geometry.mesh.connectivity), 1))
    mesh = BeamMesh(np.column_stack([nodes, np.zeros(len(nodes))]), geometry.mesh.connectivity, across)
    own = [SpatialPatch(patch, strip(), 1 / (2 * (1 + poisson_ratio)), modulus_factor) for patch in patches]
    return SpatialDiscretisation(mesh, own, assemble(mesh, own), places, geometry.arc_lengths, target=geometry.target)
