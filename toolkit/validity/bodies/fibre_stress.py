"""Stress along fibres of beams in space beside von Mises' one, and skins so thick that their inner fibres fold.

Sections of the elements of a chain in space, from what their reduced model keeps: second moments, and shear.

By Saint-Venant's torsion the largest shear stress is, for a torque T,

    round, outer radius R:    tau = T R / (I_2 + I_3)
    rectangle, sides a > b:   tau = k_1 T b / J, in the middle of the long side
    J = a b^3 / 3 (1 - 192 b / (pi^5 a) sum tanh(n pi a / 2 b) / n^5),   n = 1, 3, ...
    k_1 = 1 - 8 / pi^2 sum 1 / (n^2 cosh(n pi a / 2 b))

(Timoshenko and Goodier, Theory of Elasticity, section 109).

Difference of the stress along fibres of beams in space to von Mises': shear by twist, and bending between fibres.

With the torque T, bending moments M and the normal force N of an element, and the shear stress tau of its section,

    round, outer radius R:                          sigma = |N| / A + |M| R / I
    rectangle, in the middle of its long side a:    sigma = |N| / A + |M_b| b / (2 I_b),   I_b, M_b of bending about that side

and von Mises' stress sqrt(sigma^2 + 3 tau^2).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from toolkit.components.bodies.model_body import ModelBody
from toolkit.foundation.itself import Itself
from toolkit.foundation.kinematics.beam_elements import BeamElements
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.reduced_model.model import Mesh
from toolkit.reduced_model.parts import BeamSections
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import Solution, deforming, elastic_coordinates, flexible_body, is_in_pieces
from toolkit.validity.bodies.chain import Chain, sides_of
from toolkit.validity.bodies.deformation import LIMIT, instants_of, whole_bodies
from toolkit.validity.bodies.known_chain import SECTIONS, chain
from toolkit.validity.scene_cautions import bodies_of_stress

ODD = np.arange(1, 40, 2)
"""Odd numbers n of the terms of the series, which fall with exp(-n pi / 2) and 1 / n^5."""
SECTION_TOLERANCE = 1e-6
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
    equal, squares = np.abs(most - least) < SECTION_TOLERANCE * most, radius**2 * area
    solid = (squares > (2 - SECTION_TOLERANCE) * least) & (
        squares < (4 + SECTION_TOLERANCE) * least
    )  # from a thin tube to a full circle
    round_ones = equal & solid & _is_modulus(twisting / (least + most))
    corners = np.abs(squares - 3 * (least + most)) < SECTION_TOLERANCE * squares
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


ROUND_OFF = 1e-9
"""Part of von Mises' stress below which the stress along fibres is round-off."""


@check("fibre-stress", STATES)
def fibres_alone(solution: Solution) -> Iterator[Caution]:
    """The stress of a beam in space is that along its fibres: the shear of its twist is not in it, nor bending between two fibres.

    Limit: 5 % of von Mises' stress.
    Fix: fibres in the frame file, or a body of solid elements.
    """
    scene = solution.system.scene
    for body in whole_bodies(scene):
        if body in bodies_of_stress(scene) and not is_in_pieces(scene, body) and is_of_fibres(scene, body):
            yield from _lacking(solution, body)


def is_of_fibres(scene: ResolvedScene, body: str) -> bool:
    """Whether the stress of a body is that of beams in space: one component at every point, where solids have six."""
    _, *components, _ = flexible_body(scene, body).design_point(scene).model.invariants.stress_operator.shape
    return components == [1]


def _lacking(solution: Solution, body: str) -> Iterator[Caution]:
    scene = solution.system.scene
    parts = [name for name, each in deforming(scene).items() if body in (name, getattr(each, "whole", None))]
    found = [_stresses(solution, body, name) for name in parts]
    known = [each for each in found if each is not None]
    if any(np.isinf(each).any() for each in known):
        yield fibres_alone.caution(
            f"the stress of {body} is that along the middle of its sections, which bending does not reach: some of them name no other "
            "fibres. Fix: write where they are, fibres = [[y_2, y_3], ...], in their tables of the frame file.",
        )
        return
    told, whole = (max((each[k] for each in known), default=0.0) for k in range(2))
    part = 1 - told / whole if whole else 0.0
    if part > LIMIT:
        label, told = unit(scene.units, "stress"), told if told > ROUND_OFF * whole else 0.0
        yield fibres_alone.caution(
            f"the stress of {body} is that along its fibres, {told:.4g} {label} at most. With the shear of its twist, and with what bends "
            f"it between the fibres, von Mises' is {whole:.4g} {label}: the fibres lack {part:.0%} of that. Fix: keep that much below "
            "what its material bears, or make a body of solid elements of it.",
        )
    elif len(known) < len(found):
        yield fibres_alone.caution(
            f"the stress of {body} is that along its fibres: the shear of its twist is not in it, and not known of its basis or sections.",
            doubt=False,
        )


def _stresses(solution: Solution, body: str, name: str) -> tuple[float, float] | None:
    """Largest stress along fibres, and the largest von Mises stress.

    None where elements or sections are not known, infinite where a section has no fibre but its middle.
    """
    scene = solution.system.scene
    behind = chain(scene, name)
    if behind is None:
        return None
    fibres = _fibres(scene, body, name, len(behind.forms.dofs))
    if fibres is None:
        return None
    operator, owner = fibres.operator, fibres.owner
    found = sections_of(behind, fibres.made_of, fibres.distance, owner)
    if np.any(found.radius**2 * found.area < SECTION_TOLERANCE * found.least):
        return np.inf, np.inf
    if np.isnan(found.shear).any():
        return None
    elastic = np.real(solution.q[:, elastic_coordinates(solution, name)])
    u = behind.displacements(elastic[instants_of(solution, name)])
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


class Fibres(NamedTuple):
    """Fibres of a part at which stress is evaluated."""

    operator: np.ndarray  # (n_s, 12) rows of their stress on the coordinates of their elements
    owner: np.ndarray  # (n_s,) numbers of these among those of the part
    distance: np.ndarray  # (n_s, 2) from the middle of the section, along e_2 and e_3
    made_of: BeamSections  # of all elements of the part


def _fibres(scene: ResolvedScene, body: str, name: str, count: int) -> Fibres | None:
    """Fibres of a part with so many elements; None where its sections are not known."""
    design = flexible_body(scene, body).design_point(
        scene, "stress", "elements", "element_derivatives", "element_affine", *SECTIONS
    )
    places, first, made_of = design.model.stress, getattr(scene.body(name), "first", 0), design.sections()
    if places is None or made_of is None:
        return None
    owner = places.element.astype(int) - first
    mine = (owner >= 0) & (owner < count)
    operator, distance = np.real(design.value("elements.stress_operator")), np.real(made_of.fibre_distance)
    return Fibres(operator[mine], owner[mine], distance[mine], made_of.of_elements(first, first + count).real)


POINTS_PER_NODE = 2
"""How many times as many points as nodes the outline of a skin has at least, whose curvature it shows; that of a frame has its nodes."""


@check("folded-skin", STATES)
def folded_skins(solution: Solution) -> Iterator[Caution]:
    """Half the thickness of a skin exceeds the smallest radius of its contour: its inner side folds, and its stress means nothing there.

    Limit: half the thickness above the radius; a doubt where its stress is asked for.
    Fix: a thinner skin, or solid elements.

    There the inner fibre has no length, so that the curved beam that a straight element stands for does not exist; mass is counted twice.
    """
    scene = solution.system.scene
    for name, body in scene.bodies.items():
        if not isinstance(body, ModelBody) or is_in_pieces(scene, name):
            continue
        model = scene.model(body.model, "mesh")
        values = {**model.nominal, **body.model_values()}
        thickness = min((float(np.real(t)) for key, t in values.items() if key.startswith("thickness")), default=0.0)
        radius = smallest_radius(Itself(model.mesh)) if thickness > 0 and model.mesh is not None else np.inf
        if thickness > 2 * radius:
            yield folded_skins.caution(
                f"half the thickness of {name} ({thickness / 2:.3g} {unit(scene.units, 'length')}) exceeds the smallest radius of the line "
                f"that it follows ({radius:.3g}). Inner fibres fold there, and stresses mean nothing. Fix: make it thinner than "
                f"{2 * radius:.3g}, or of solid elements.",
                doubt=name in bodies_of_stress(scene),
            )


@lru_cache(maxsize=16)
def smallest_radius(same: Itself[Mesh]) -> float:
    """Smallest radius of circles through three successive points of a skin's contour; inf of a mesh that shows no contour of its own."""
    outline, nodes = np.real(same.item.outline), np.real(same.item.nodes)
    if len(outline) < POINTS_PER_NODE * len(nodes):
        return np.inf
    ends = sorted(int(np.argmin(np.linalg.norm(outline - node, axis=1))) for node in (nodes[0], nodes[-1]))
    sides = np.diff(outline[ends[0] : ends[1] + 1], axis=0)
    before, after = sides[:-1], sides[1:]
    area = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
    product = np.prod([np.linalg.norm(each, axis=1) for each in (before, after, before + after)], axis=0)
    return float(np.min(product[area > 0] / (2 * area[area > 0]), initial=np.inf))
