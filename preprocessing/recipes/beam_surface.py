"""The surface of spatial beams among the fields of a reduced model."""

from __future__ import annotations

from typing import Any

from preprocessing.discretisation.fibre_lines import fibre_lines, fibre_polynomial
from preprocessing.elements.kinds.beams import SpatialBeam
from preprocessing.reduction.reduced import Reduced
from toolkit.reduced_model.spatial_model import SURFACE_POSITION


def beam_surface(found: Reduced, beams: SpatialBeam) -> dict[str, Any]:
    """Surface of beams at the nominal design; at others too where the shapes are those of the nominal one."""
    z, values = found.basis.z, found.space.values
    surface = {"surface": fibre_lines(beams, z, values)}
    if not found.basis.constant:
        return surface
    return {**surface, "affine": {**found.affine, SURFACE_POSITION: fibre_polynomial(beams, z, list(values))}}
