"""What the stress of beams in space, which is that along their fibres, lacks of von Mises': shear by twist, and bending between fibres.

With the torque T, bending moments M and the normal force N of an element, by Saint-Venant's torsion

    round, outer radius R:        tau = T R / (I_2 + I_3),   sigma = |N| / A + |M| R / I
    rectangle, sides a > b, in the middle of the long one:   tau = k_1 T b / J,   sigma = |N| / A + |M_b| b / (2 I_b)
    J = a b^3 / 3 (1 - 192 b / (pi^5 a) sum tanh(n pi a / 2 b) / n^5),   n = 1, 3, ...
    k_1 = 1 - 8 / pi^2 sum 1 / (n^2 cosh(n pi a / 2 b))

and von Mises' stress sqrt(sigma^2 + 3 tau^2); I_b, M_b are of bending about the long side (Timoshenko and Goodier, Theory of Elasticity,
section 109).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from toolkit.foundation.units import unit
from toolkit.foundation.verdict import Caution
from toolkit.kinematics.spatial import axes_along
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import deforming, elastic_coordinates, flexible_body, is_in_pieces
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.known_chain import chain
from toolkit.validity.bodies.chains.sides import sides_of
from toolkit.validity.bodies.deformation import LIMIT, largest_instants, whole_bodies
from toolkit.validity.description.mesh_cautions import bodies_of_stress

ODD = np.arange(1, 40, 2)
"""Terms of the series: they fall with exp(-n pi / 2) and 1 / n^5."""
SAME = 1e-6
"""Relative difference of lengths and second moments that is round-off of a section's numbers."""


ROUND_OFF = 1e-9
"""Part of von Mises' stress below which fibres tell none."""


class Sections(NamedTuple):
    """Of elements: lengths, directions, area, second moments about the axes of least and largest, and these axes; outer radius; whether
    they are round, or else rectangles; and tau over torque."""

    along: np.ndarray  # (n_e, 3)
    area: np.ndarray  # (n_e,)
    least: np.ndarray
    weak_axis: np.ndarray  # (n_e, 3), of bending with the least second moment
    radius: np.ndarray
    round: np.ndarray
    shear: np.ndarray  # nan of sections that are neither


def fibres_alone(solution: Solution) -> Iterator[Caution]:
    """Doubts about bodies of beams in space whose stress, where it is asked for, lacks a part that counts."""
    scene = solution.system.scene
    for body in whole_bodies(scene) if scene.dimension == 3 else ():
        if body in bodies_of_stress(scene) and not is_in_pieces(scene, body) and is_of_fibres(scene, body):
            yield from _lacking(solution, body)


def is_of_fibres(scene: Scene, body: str) -> bool:
    """Whether the stress of a body has one component, as that of beams."""
    return flexible_body(scene, body).design_point(scene).model.invariants.stress_operator.shape[1] == 1


def _lacking(solution: Solution, body: str) -> Iterator[Caution]:
    scene = solution.system.scene
    parts = [name for name, each in deforming(scene).items() if body in (name, getattr(each, "whole", None))]
    found = [_stresses(solution, body, name) for name in parts]
    known = [each for each in found if each is not None]
    told, whole = (max((each[k] for each in known), default=0.0) for k in range(2))
    part = 1 - told / whole if whole else 0.0
    if part > LIMIT:
        label, told = unit(scene.units, "stress"), told if told > ROUND_OFF * whole else 0.0
        yield Caution(
            "fibre-stress",
            f"the stress of {body} is that along its fibres, {told:.4g} {label} at most. With the shear of its twist, and with what bends "
            f"it between the fibres, von Mises' is {whole:.4g} {label}: the fibres lack {part:.0%} of that. Keep that much below what its "
            "material bears, or make a body of solid elements of it.",
        )
    elif len(known) < len(found):
        yield Caution(
            "fibre-stress",
            f"the stress of {body} is that along its fibres: the shear of its twist is not in it, and not known of its basis or sections.",
            doubt=False,
        )


def _stresses(solution: Solution, body: str, name: str) -> tuple[float, float] | None:
    """The largest stress that fibres tell, and von Mises' largest; None where elements or sections are not known."""
    scene = solution.system.scene
    behind = chain(scene, name)
    if behind is None:
        return None
    operator, owner = _rows(scene, body, name, len(behind.forms.dofs))
    found = sections_of(behind, operator, owner)
    if np.isnan(found.shear).any():
        return None
    elastic = np.real(solution.q[:, elastic_coordinates(solution, name)])
    u = behind.displacements(elastic[largest_instants(elastic)])
    told = np.abs(np.einsum("sp,tsp->ts", operator, u[:, behind.forms.dofs[owner]])).max(initial=0.0)
    forces = behind.forms.forces(u)
    tension, moments = np.abs(forces[:, :, 0]) / found.area, forces[:, :, 1:].reshape(*forces.shape[:2], 2, 3)
    torque = np.einsum("tei,ei->te", moments[:, :, 1], found.along)
    aside = moments - np.einsum("teni,ei->ten", moments, found.along)[..., None] * found.along[:, None]
    whole = np.linalg.norm(aside, axis=3).max(axis=2) * found.radius
    flat = np.abs(np.einsum("teni,ei->ten", aside, found.weak_axis)).max(axis=2) * np.sqrt(3 * found.least / found.area)
    sigma = tension + np.where(found.round, whole, flat) / found.least
    mises = np.sqrt(sigma**2 + 3 * (torque * found.shear) ** 2).max(initial=0.0)
    return float(told), max(float(told), float(mises))


def _rows(scene: Scene, body: str, name: str, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows (n_s, 12) of the stress operator on the coordinates of their elements, and the numbers of these among those of a part."""
    design = flexible_body(scene, body).design_point(scene, "elements", "stress", "element_derivatives", "element_affine")
    places, first = design.model.stress, getattr(scene.body(name), "first", 0)
    assert places is not None
    owner = places.element.astype(int) - first
    mine = (owner >= 0) & (owner < count)
    return np.real(design.value("elements.stress_operator"))[mine], owner[mine]


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
    return Sections(along, area, least, axes[:, :, 1], radius, *_shear(area, least, most, radius))


def _shear(area: np.ndarray, least: np.ndarray, most: np.ndarray, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Whether sections are round, and their largest shear stress over the torque; nan where they are neither round nor rectangles."""
    equal, squares = np.abs(most - least) < SAME * most, radius**2 * area
    round_ones = equal & (squares > (2 - SAME) * least) & (squares < (4 + SAME) * least)  # from a thin tube to a full circle
    corners = np.abs(squares - 3 * (least + most)) < SAME * squares
    ratio = np.sqrt(least / most)[:, None]
    sum_j, sum_k = (
        (np.tanh(ODD * np.pi / 2 / ratio) / ODD**5).sum(axis=1),
        (1 / ODD**2 / np.cosh(ODD * np.pi / 2 / ratio)).sum(axis=1),
    )
    torsion = 4 * least * (1 - 192 / np.pi**5 * ratio[:, 0] * sum_j)
    of_rectangle = np.sqrt(12 * least / area) * (1 - 8 / np.pi**2 * sum_k) / torsion
    return round_ones, np.where(round_ones, radius / (least + most), np.where(corners, of_rectangle, np.nan))
