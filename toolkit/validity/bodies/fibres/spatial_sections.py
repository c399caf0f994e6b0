"""Sections of the elements of a chain in space, from what their reduced model keeps: second moments, and shear.

By Saint-Venant's torsion the largest shear stress is, for a torque T,

    round, outer radius R:    tau = T R / (I_2 + I_3)
    rectangle, sides a > b:   tau = k_1 T b / J, in the middle of the long side
    J = a b^3 / 3 (1 - 192 b / (pi^5 a) sum tanh(n pi a / 2 b) / n^5),   n = 1, 3, ...
    k_1 = 1 - 8 / pi^2 sum 1 / (n^2 cosh(n pi a / 2 b))

(Timoshenko and Goodier, Theory of Elasticity, section 109).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.kinematics.beam_elements import BeamElements
from toolkit.reduced_model.parts import BeamSections
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.sides import sides_of

ODD = np.arange(1, 40, 2)
"""Odd numbers n of the terms of the series, which fall with exp(-n pi / 2) and 1 / n^5."""
SAME = 1e-6
"""Relative difference of lengths and second moments that is round-off of a section's numbers."""


class Sections(NamedTuple):
    """Sections of elements in space.

    They are directions, areas, least second moments with their axes, outer radii, whether they are round or else rectangles, and
    the largest shear stress over the torque.
    """

    along: np.ndarray  # (n_e, 3)
    area: np.ndarray  # (n_e,)
    least: np.ndarray
    weak_axis: np.ndarray  # (n_e, 3), of bending with the least second moment
    radius: np.ndarray
    round: np.ndarray
    shear: np.ndarray  # nan of sections that are neither


def sections_of(behind: Chain, made_of: BeamSections, fibres: np.ndarray, owner: np.ndarray) -> Sections:
    """Sections of the elements of a chain in space.

    Parameters
    ----------
    made_of
        What the reduced model keeps of the elements.
    fibres, owner
        Distances (n_s, 2) of fibres from the middle along e_2 and e_3, and whose they are (n_s,).
    """
    sides, axes = behind.nodes[sides_of(behind).ends], made_of.axis
    triads, youngs = BeamElements.in_space(sides, axes).axes, made_of.stress_per_strain
    radius = np.zeros(len(youngs))
    np.maximum.at(radius, owner, np.linalg.norm(fibres, axis=1))
    moments = made_of.bending_stiffness / youngs[:, None]
    weak = np.where(moments[:, :1] <= moments[:, 1:], triads[:, 2], triads[:, 1])  # what deflects along e_2 bends about e_3
    area, least, most = made_of.axial_stiffness / youngs, moments.min(axis=1), moments.max(axis=1)
    shear = _shear(area, least, most, radius, made_of.torsional_stiffness / youngs)
    return Sections(triads[:, 0], area, least, weak, radius, *shear)


def _shear(
    area: np.ndarray, least: np.ndarray, most: np.ndarray, radius: np.ndarray, twisting: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Whether sections are round, and their largest shear stress over the torque.

    It is nan where they are neither round nor rectangles: where fibres lie elsewhere, or G J / E stands for no modulus of shear,
    from 1/3 E to E.
    """
    equal, squares = np.abs(most - least) < SAME * most, radius**2 * area
    solid = (squares > (2 - SAME) * least) & (squares < (4 + SAME) * least)  # from a thin tube to a full circle
    round_ones = equal & solid & _is_modulus(twisting / (least + most))
    corners = np.abs(squares - 3 * (least + most)) < SAME * squares
    ratio = np.sqrt(least / most)[:, None]
    fall = np.exp(-ODD * np.pi / 2 / ratio)
    sum_j, sum_k = (np.tanh(ODD * np.pi / 2 / ratio) / ODD**5).sum(axis=1), (2 * fall / (1 + fall**2) / ODD**2).sum(axis=1)
    torsion = 4 * least * (1 - 192 / np.pi**5 * ratio[:, 0] * sum_j)
    of_rectangle = np.sqrt(12 * least / area) * (1 - 8 / np.pi**2 * sum_k) / torsion
    corners &= _is_modulus(twisting / torsion)
    return round_ones, np.where(round_ones, radius / (least + most), np.where(corners, of_rectangle, np.nan))


def _is_modulus(part: np.ndarray) -> np.ndarray:
    """Whether G / E is that of an isotropic material, 1 / (2 (1 + nu)); J of rectangles is known to 0.4 %."""
    found: np.ndarray = (part > 0.99 / 3) & (part < 1.0)
    return found
