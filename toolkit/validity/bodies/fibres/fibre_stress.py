"""Difference of the stress along fibres of beams in space to von Mises': shear by twist, and bending between fibres.

With the torque T, bending moments M and the normal force N of an element, and the shear stress tau of `spatial_sections`,

    round, outer radius R:                          sigma = |N| / A + |M| R / I
    rectangle, in the middle of its long side a:    sigma = |N| / A + |M_b| b / (2 I_b),   I_b, M_b of bending about that side

and von Mises' stress sqrt(sigma^2 + 3 tau^2).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from toolkit.foundation.units import unit
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.reduced_model.parts import BeamSections
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.flexible_bodies import deforming, elastic_coordinates, flexible_body, is_in_pieces
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.known_chain import SECTIONS, chain
from toolkit.validity.bodies.deformation import LIMIT, instants_of, whole_bodies
from toolkit.validity.bodies.fibres.spatial_sections import SAME, sections_of
from toolkit.validity.description.mesh_cautions import bodies_of_stress

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
    if np.any(found.radius**2 * found.area < SAME * found.least):
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
