"""Beam elements of equal rectangles in the plane: their sections, and the corotational elements that are judges of other formulations."""

from __future__ import annotations

import numpy as np

from toolkit.reduced_model.model import StressPoints
from toolkit.reduced_model.parts import BeamSections
from toolkit.validity.bodies.corotational_beams import Corotational
from toolkit.validity.bodies.known_chain import PlanarChain


def rectangles(count: int, modulus: float, thickness: float, width: float) -> BeamSections:
    """Sections of some elements, without shear and mass; four fibres each, as `points_of` counts them."""
    one, none = np.ones(count), np.zeros(count)
    area, moment = width * thickness, width * thickness**3 / 12
    return BeamSections(
        axis=np.tile([0.0, 0.0, 1.0], (count, 1)),
        stress_per_strain=modulus * one,
        axial_stiffness=modulus * area * one,
        bending_stiffness=modulus * moment * one[:, None],
        torsional_stiffness=none,
        shear_stiffness=none,
        mass_per_length=none,
        fibre_distance=np.tile([-thickness / 2, thickness / 2], 2 * count)[:, None],
    )


def points_of(count: int) -> StressPoints:
    """For every element its ends 0 and 1, at each end the fibres +1 and -1."""
    element, end, fibre = np.meshgrid(np.arange(count), [0, 1], [1, -1], indexing="ij")
    return StressPoints(element.ravel(), end.ravel(), fibre.ravel())


def corotational(nodes: np.ndarray, connectivity: np.ndarray, modulus: float, thickness: float, width: float) -> Corotational:
    """Elements that turn with their chords."""
    return Corotational(nodes, connectivity, rectangles(len(connectivity), modulus, thickness, width))


def linear_chain(nodes: np.ndarray, connectivity: np.ndarray, held: np.ndarray, made_of: BeamSections) -> PlanarChain:
    """Linear elements with all their coordinates."""
    return PlanarChain(np.eye(3 * len(nodes)), held, nodes, connectivity, made_of)
