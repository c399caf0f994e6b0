"""What beam elements leave out whatever their motion: bending and stretch by weight and inertia between nodes.

Weight less inertia, and pressure on the side of a piece of a solid, p per length, bend an element of length l by moments of up to
p l^2 / 12 more than its shape functions say; displacements of the nodes are those of the exact beam. In parts of the
largest strain of a fibre at sqrt(3) r, as of a rectangle,

    (sqrt(3) p l^2 / (12 E A r)) / max (|N| / E A + sqrt(3) |M| / (E A r))

Along an element p makes the force at one of its ends p l / 2 larger than the mean, which is all that the element says of it.

A basis of few shapes lacks besides what p moves the nodes by and no shape knows.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from toolkit.bodies.cut.cuttable_body import CuttableBody
from toolkit.bodies.cut.framed_part import FramedPart
from toolkit.foundation.verdict import Caution
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import deforming, design_point, elastic_coordinates, elements_of
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.known_chain import chain
from toolkit.validity.bodies.chains.planar_chain import PlanarChain
from toolkit.validity.bodies.chains.sides import sides_of
from toolkit.validity.bodies.deformation import LIMIT, largest_instants, whole_bodies
from toolkit.validity.bodies.element_accelerations import has_inertia, pull_on_elements
from toolkit.validity.bodies.pressed_pieces import is_pressed, pressure_on_elements
from toolkit.validity.bodies.static_deflection import static_deflection
from toolkit.validity.description.mesh_cautions import bodies_of_stress

FIBRE = np.sqrt(3.0)
"""Distance of the outer fibre of a rectangle in radii of gyration."""


class Beams(NamedTuple):
    """Elements of a chain: nodes, lengths, directions, stretching stiffness E A and squares of the radii of gyration."""

    ends: np.ndarray  # (n_e, 2)
    lengths: np.ndarray  # (n_e,)
    along: np.ndarray  # (n_e, d)
    axial: np.ndarray  # (n_e,)
    gyration: np.ndarray  # (n_e,)


def beams_of(behind: Chain) -> Beams:
    """What the elements are, from how they deform; the radius is that of bending about the stiffer axis."""
    law, (ends, lengths, along) = behind.forms.law, sides_of(behind)
    turns = (law.shape[1] - 1) // 2
    bending = law[:, 1 : 1 + turns, 1 : 1 + turns] - law[:, 1 : 1 + turns, 1 + turns :]  # 2 E I / L
    if turns > 1:
        aside = np.eye(turns) - along[:, :, None] * along[:, None, :]
        bending = aside @ bending @ aside
    stiffest = np.linalg.eigvalsh(bending)[:, -1] / 2
    return Beams(ends, lengths, along, law[:, 0, 0] * lengths, stiffest / law[:, 0, 0])


def bent_between_nodes(solution: Solution) -> Iterator[Caution]:
    """Bodies of whose stress, where it is asked for, weight and inertia between their nodes are a part that counts."""
    scene, moving = solution.system.scene, has_inertia(solution)
    pressed, heavy = is_pressed(scene), moving or bool(np.real(scene.gravity).any())
    for body in whole_bodies(scene) if pressed or heavy else ():
        parts = [name for name, each in deforming(scene).items() if body in (name, getattr(each, "whole", None))]
        found = [_strains(solution, name) for name in parts] if body in bodies_of_stress(scene) else []
        told = [each for each in found if each is not None]
        across, along, largest = (max((each[k] for each in told), default=0.0) for k in range(3))
        lacking = across + along
        part = lacking / (largest + lacking) if lacking else 0.0
        if part > LIMIT:
            allowed = LIMIT * (largest + lacking)  # across / factor^2 + along / factor
            factor = (along + np.sqrt(along**2 + 4 * across * allowed)) / (2 * allowed)
            known = {"its weight": heavy, "pressures on it": pressed, "forces of inertia": moving}
            forces = " and ".join(words for words, there in known.items() if there)
            named = f"{forces} {'does' if forces == 'its weight' else 'do'}"
            yield Caution(
                "weight-between-nodes",
                f"the stress of {body} lacks what {named} between nodes, or what no shape of its basis knows of that: some "
                f"{part:.0%} of the largest, while interface points are where they should be. Build the model with "
                f"{times_as_many(factor)} as many {elements_of(scene, body)}, or with more modes.",
            )


ALMOST = 1e-3
"""Of a tenth, by which a factor may be more than the one that is told."""


def times_as_many(factor: float) -> str:
    """A factor that is enough, in words, not rounded down to what is there already."""
    return f"{max(np.ceil(10 * factor - ALMOST) / 10, 1.1):.3g} times"


def _strains(solution: Solution, name: str) -> tuple[float, float, float] | None:
    """The largest strains that these add between nodes, across the elements and along them, and the largest that the elements tell; None
    where these are not known."""
    scene = solution.system.scene
    behind, body = chain(scene, name), scene.body(name)
    if behind is None or not isinstance(body, CuttableBody | FramedPart):
        return None
    found, elastic = beams_of(behind), np.real(solution.q[:, elastic_coordinates(solution, name)])
    instants = largest_instants(elastic)
    (mass,) = body.some_invariants(scene, "mass")
    density = float(np.real(mass)) * found.axial / (found.axial @ found.lengths)
    pull = density[:, None] * pull_on_elements(solution, name, behind, instants)
    pull = pull + pressure_on_elements(solution, name, behind, instants)
    along = np.einsum("tei,ei->te", pull, found.along)
    normal = pull - along[:, :, None] * found.along
    fibre = FIBRE / (found.axial * np.sqrt(found.gyration))
    between = np.linalg.norm(normal, axis=2) * found.lengths**2 / 12 * fibre
    stretched = np.abs(along) * found.lengths / 2 / found.axial
    told_apart = behind.is_full or behind.per_node > PlanarChain.per_node  # parts in space are looked at by `left_out_shapes`
    unknown = np.zeros((1, behind.forms.count)) if told_apart else _outside_the_basis(scene, name, behind, found, pull)
    told = _fibre_strains(behind, found, behind.displacements(elastic[instants]))
    across = between + _fibre_strains(behind, found, unknown)
    return float(across.max()), float(stretched.max()), float(told.max())


def _fibre_strains(behind: Chain, found: Beams, u: np.ndarray) -> np.ndarray:
    """Largest strains (n_t, n_e) of nodal displacements (n_t, n)."""
    forces = behind.forms.forces(u)
    moments = np.linalg.norm(forces[:, :, 1:].reshape(*forces.shape[:2], 2, -1), axis=3).max(axis=2)
    strains: np.ndarray = np.abs(forces[:, :, 0]) / found.axial + FIBRE * moments / (found.axial * np.sqrt(found.gyration))
    return strains


def _outside_the_basis(scene: Scene, name: str, behind: Chain, found: Beams, pull: np.ndarray) -> np.ndarray:
    """What of the displacements of the plane's nodes under forces per length (n_t, n_e, 2) no shape of the basis knows, (n_t, n)."""
    half = pull * found.lengths[:, None] / 2
    turn = (found.along[:, 0] * half[:, :, 1] - found.along[:, 1] * half[:, :, 0]) * found.lengths / 6
    loads = np.zeros((len(behind.nodes), len(pull), behind.per_node))
    for node, sign in zip(found.ends.T, (1, -1), strict=True):
        np.add.at(loads, node, np.swapaxes(np.concatenate([half, sign * turn[:, :, None]], axis=2), 0, 1))
    flat = np.swapaxes(loads, 0, 1).reshape(len(pull), -1)
    stiffness = np.real(design_point(scene, name).value("stiffness"))
    known: np.ndarray = static_deflection(stiffness, behind.shapes.T @ flat.T).T @ behind.shapes.T
    return behind.under(flat) - known
