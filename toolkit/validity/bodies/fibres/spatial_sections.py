"""Sections of the elements of a chain in space, read back from how they deform and where their fibres are: second moments, and shear.

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

from toolkit.kinematics.spatial import axes_along
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.sides import sides_of

ODD = np.arange(1, 40, 2)
"""Terms of the series: they fall with exp(-n pi / 2) and 1 / n^5."""
SAME = 1e-6
"""Relative difference of lengths and second moments that is round-off of a section's numbers."""


class Sections(NamedTuple):
    """Of elements: directions, areas, least second moments with their axes, outer radii, whether they are round or else rectangles, and the
    largest shear stress over the torque."""

    along: np.ndarray  # (n_e, 3)
    area: np.ndarray  # (n_e,)
    least: np.ndarray
    weak_axis: np.ndarray  # (n_e, 3), of bending with the least second moment
    radius: np.ndarray
    round: np.ndarray
    shear: np.ndarray  # nan of sections that are neither


def sections_of(behind: Chain, operator: np.ndarray, owner: np.ndarray) -> Sections:
    """Sections of the elements of a chain in space, from how they deform and where their fibres are.

    Parameters
    ----------
    operator, owner
        Rows (n_s, 12) that tell the stress of fibres of their elements, and whose they are (n_s,).
    """
    law, (_, lengths, along) = behind.forms.law, sides_of(behind)
    across = np.array([axes_along(each)[:, :2].T for each in along])  # (n_e, 2, 3)
    stretch, bends = np.zeros((len(along), 12)), np.zeros((len(along), 2, 12))
    stretch[:, 6:9] = along * lengths[:, None]
    bends[:, :, 3:6], bends[:, :, 9:] = -across / 2, across / 2  # the ends turn against each other by 1 rad
    modulus = np.einsum("sp,sp->s", operator, stretch[owner])
    offset = np.einsum("sp,snp->sn", operator, bends[owner]) * (lengths[owner] / modulus)[:, None]
    radius, youngs = np.zeros(len(along)), np.zeros(len(along))
    np.maximum.at(radius, owner, np.linalg.norm(offset, axis=1))
    youngs[owner] = modulus
    projection = np.eye(3) - along[:, :, None] * along[:, None, :]
    bending = projection @ (law[:, 1:4, 1:4] - law[:, 1:4, 4:]) @ projection  # 2 E I / L
    values, axes = np.linalg.eigh(bending)
    area, (least, most) = law[:, 0, 0] * lengths / youngs, (values[:, 1:] * lengths[:, None] / (2 * youngs[:, None])).T
    twisting = np.einsum("ei,eij,ej->e", along, law[:, 4:, 4:], along) * lengths / youngs  # G J / E
    return Sections(along, area, least, axes[:, :, 1], radius, *_shear(area, least, most, radius, twisting))


def _shear(
    area: np.ndarray, least: np.ndarray, most: np.ndarray, radius: np.ndarray, twisting: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Whether sections are round, and their largest shear stress over the torque; nan where they are neither round nor rectangles: where
    fibres lie elsewhere, or G J / E stands for no modulus of shear, from 1/3 E to E."""
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
