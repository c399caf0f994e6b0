"""The skin in space: the beams of the plane with width across it, so that it can also bend out of its plane and twist.

In its plane it is exactly the planar skin: without rotary inertia the mass lies on the middle line of every rectangle, see
`section_shape.strip`. Out of it the rectangle t x b bends with E t b^3 / 12 and twists with G J, see `section_shape.rectangle`,
G = E / (2 (1 + nu)).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from preprocessing.elements.kinds.beams import BeamPatch, SpatialBeam
from preprocessing.elements.section import Patch
from preprocessing.elements.section_shape import rectangle, strip
from preprocessing.mesh.curve_mesh import CurveMesh


def spatial_skin(
    mesh: CurveMesh, patches: Iterable[Patch], modulus_factor: Any, poisson_ratio: Any, rotary_inertia: bool
) -> SpatialBeam:
    """Spatial beams along the skin, in the plane z = 0, with the thickness in the plane and the width along z.

    Parameters
    ----------
    modulus_factor : by which E is multiplied in stretching and bending
    poisson_ratio : for G in torsion
    rotary_inertia : whether the mass is spread over the thickness
    """
    across = np.tile([0.0, 0.0, 1.0], (len(mesh.connectivity), 1))
    shape = rectangle() if rotary_inertia else strip()
    own = [BeamPatch(patch, shape, 1 / (2 * (1 + poisson_ratio)), modulus_factor) for patch in patches]
    return SpatialBeam(np.column_stack([mesh.nodes, np.zeros(len(mesh.nodes))]), mesh.connectivity, across, own)
