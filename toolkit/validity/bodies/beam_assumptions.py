"""Bending and stretch by weight and inertia between nodes, which beam elements leave out whatever their motion.

What pulls at the middles of a body's elements, per mass: weight and forces of inertia, in the axes of its frame.

    A^T (g - r'') - alpha x p - omega x (omega x p) - 2 omega x p' - p'',    p = X + (u_1 + u_2) / 2 + l / 8 (phi_1 - phi_2) x e

with displacements u and rotations phi of an element's ends, as its shape functions have it.

Weight less inertia, and pressure on the side of a piece of a solid, p per length, bend an element of length l by moments of up to
p l^2 / 12 more than its shape functions say; displacements of the nodes are those of the exact beam. In parts of the
largest strain of a fibre at sqrt(3) r, as of a rectangle,

    (sqrt(3) p l^2 / (12 E A r)) / max (|N| / E A + sqrt(3) |M| / (E A r))

Along an element p makes the force at one of its ends p l / 2 larger than the mean, which is all that the element says of it.

A basis of few shapes lacks besides what p moves the nodes by and no shape knows.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from toolkit.bodies.cuttable_body import CuttableBody
from toolkit.bodies.framed_part import FramedPart
from toolkit.bodies.model_body import ModelBody
from toolkit.compilation.quantities import pressures_of
from toolkit.foundation.near_ties import spread
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.responses.energy import StrainEnergy
from toolkit.responses.local_stress import LocalStress
from toolkit.responses.over_time import OverTime
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import Solution, deforming, design_point, elastic_coordinates, elements_of
from toolkit.validity.bodies.carried_force import static_deflection
from toolkit.validity.bodies.chain import Chain, Sides, sides_of
from toolkit.validity.bodies.deformation import LIMIT, in_space, instants_of, whole_bodies
from toolkit.validity.bodies.known_chain import PlanarChain, chain
from toolkit.validity.scene_cautions import bodies_of_stress

CANCELLED = 1e-6
"""Weight and inertia that differ by less in their own parts are those of free fall, to what solvers leave."""


def has_inertia(solution: Solution) -> bool:
    """Whether its states are of a motion with inertia, or of a steady spin."""
    options = solution.options or solution.system.scene.solver
    return solution.spins or bool(solution.steps and not options.quasi_static)


def pull_on_elements(solution: Solution, name: str, behind: Chain, instants: np.ndarray) -> np.ndarray:
    """Force per mass on the middles of all elements at some instants, (n_t, n_e, d)."""
    scene = solution.system.scene
    body: Any = scene.body(name)
    q, v, a = (np.real(x[instants][:, solution.coordinates(name)]) for x in (solution.q, solution.v, solution.a))
    axes, sides = body.poses(q)[1], sides_of(behind)
    weight = _turned_back(axes, np.tile(np.real(scene.gravity), (len(q), 1)))[:, None]
    inertia = np.zeros((len(q), *sides.along.shape))
    if has_inertia(solution):
        place, rate, inertia = (middles(behind, sides, behind.displacements(x[:, body.frame_size :])) for x in (q, v, a))
        if body.moves:
            inertia = inertia + _turned_back(axes, a[:, : body.moves])[:, None]
        if body.turns:
            omega, alpha = (_cross(body.spins(q, x), behind.nodes.shape[1]) for x in (v, a))  # spins(v, v) = 0
            centre = behind.nodes[sides.ends].mean(axis=1) + place
            inertia = inertia + _applied(alpha + omega @ omega, centre) + 2 * _applied(omega, rate)
    found = weight - inertia
    sizes = np.linalg.norm(weight, axis=2) + np.linalg.norm(inertia, axis=2)
    return np.where((np.linalg.norm(found, axis=2) > CANCELLED * sizes)[:, :, None], found, 0.0)


def pull_of_frame(solution: Solution, name: str, instants: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Force per mass on all of a body at some instants: alike (n_t, d), by the place (n_t, d, d), and along each of its shapes (n_t, n_f).

        A^T (g - r''),   - alpha x - omega x (omega x .),   - q_f''

    All are in the axes of the reduced model.
    """
    scene = solution.system.scene
    body: Any = scene.body(name)
    q, v, a = (np.real(x[instants][:, solution.coordinates(name)]) for x in (solution.q, solution.v, solution.a))
    axes, d = body.poses(q)[1], scene.dimension
    alike = _turned_back(axes, np.tile(np.real(scene.gravity), (len(q), 1)))
    by_place, by_shape = np.zeros((len(q), d, d)), np.zeros(a[:, body.frame_size :].shape)
    if has_inertia(solution):
        by_shape = -a[:, body.frame_size :]
        if body.moves:
            alike = alike - _turned_back(axes, a[:, : body.moves])
        if body.turns:
            omega, alpha = (_cross(body.spins(q, x), d) for x in (v, a))  # spins(v, v) = 0
            by_place = -(alpha + omega @ omega)
    return alike, by_place, by_shape


def _turned_back(axes: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (n_t, d) in axes (n_t, d, d)."""
    found: np.ndarray = np.einsum("tij,ti->tj", axes, vectors)
    return found


def _cross(omega: np.ndarray, d: int) -> np.ndarray:
    """Matrices (n_t, d, d) of omega x; of the plane its own block."""
    return np.swapaxes(np.cross(omega[:, None], np.eye(3)), 1, 2)[:, :d, :d]


def _applied(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Matrices (n_t, d, d) times vectors (n_t, n_e, d)."""
    found: np.ndarray = np.einsum("tij,tej->tei", matrices, vectors)
    return found


def middles(behind: Chain, sides: Sides, u: np.ndarray) -> np.ndarray:
    """Displacements (n_t, n_e, d) of the elements' middles under nodal displacements (n_t, n)."""
    moved, turned = behind.by_node(u)
    first, last = sides.ends.T
    bend = turned[:, first] - turned[:, last]
    bend = bend if bend.shape[2] == 3 else bend * np.array([0.0, 0.0, 1.0])
    aside = np.cross(bend, in_space(sides.along[None]))[:, :, : moved.shape[2]]
    found: np.ndarray = (moved[:, first] + moved[:, last]) / 2 + sides.lengths[:, None] / 8 * aside
    return found


def is_pressed(scene: ResolvedScene) -> bool:
    """Whether any load is a pressure."""
    return bool(pressures_of(scene))


def pressure_on_elements(solution: Solution, name: str, behind: Chain, instants: np.ndarray) -> np.ndarray | float:
    """Forces per length of pressures on the elements of a body in pieces, or of a part of one, (n_t, n_e, 3); zero of others."""
    scene, found = solution.system.scene, 0.0
    part: Any = scene.body(name)
    whole, own = getattr(part, "whole", name), slice(getattr(part, "first", None), getattr(part, "last", None))
    for load in pressures_of(scene).values():
        if load.body != whole:
            continue
        design = scene.bodies[whole].design_point(scene, "elements", "piece_loads")  # type: ignore[attr-defined]
        if design.model.piece_loads is not None:
            force = np.real(design.value(f"piece_loads.{load.surface}.force"))[own] / sides_of(behind).lengths[:, None]
            factor = np.real(load.pressure) * np.real(load.curve.evaluate(solution.times[instants]))[:, 0]
            found = found + factor[:, None, None] * force
    return found


INSTANTS = 24
"""Number of instants among which the largest strain energy is sought."""
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
    """Beam elements of a chain, from how they deform; the radius is that of bending about the stiffer axis."""
    law, (ends, lengths, along) = behind.forms.law, sides_of(behind)
    stiffest = np.linalg.eigvalsh(_bending(behind))[:, -1] / 2
    return Beams(ends, lengths, along, law[:, 0, 0] * lengths, stiffest / law[:, 0, 0])


def _bending(behind: Chain) -> np.ndarray:
    """Bending stiffness 2 E I / L of the elements about the axes across them, (n_e, 1, 1) or (n_e, 3, 3)."""
    law, along = behind.forms.law, sides_of(behind)[2]
    turns = (law.shape[1] - 1) // 2
    bending: np.ndarray = law[:, 1 : 1 + turns, 1 : 1 + turns] - law[:, 1 : 1 + turns, 1 + turns :]
    if turns > 1:
        aside = np.eye(turns) - along[:, :, None] * along[:, None, :]
        bending = aside @ bending @ aside
    return bending


@check("weight-between-nodes", STATES)
def bent_between_nodes(solution: Solution) -> Iterator[Caution]:
    """A stress or a strain energy lacks what weight, pressure and inertia do between the nodes of beam elements.

    Limit: 5 % of the largest.
    Fix: more elements, or more modes.
    """
    scene, moving = solution.system.scene, has_inertia(solution)
    pressed, heavy = is_pressed(scene), moving or bool(np.real(scene.gravity).any())
    for body in whole_bodies(scene) if pressed or heavy else ():
        parts = [name for name, each in deforming(scene).items() if body in (name, getattr(each, "whole", None))]
        found = [_strains(solution, name) for name in parts] if body in bodies_of_stress(scene) else []
        across, along, largest = _missed([each for each in found if each is not None], _looks_anywhere(scene, body))
        lacking = across + along
        part = lacking / (largest + lacking) if lacking else 0.0
        if part > LIMIT:
            allowed = LIMIT * (largest + lacking)  # across / factor^2 + along / factor
            factor = (along + np.sqrt(along**2 + 4 * across * allowed)) / (2 * allowed)
            known = {"its weight": heavy, "pressures on it": pressed, "forces of inertia": moving}
            forces = " and ".join(words for words, there in known.items() if there)
            named = f"{forces} {'does' if forces == 'its weight' else 'do'}"
            yield bent_between_nodes.caution(
                f"the stress of {body} lacks what {named} between nodes, or what no shape of its basis knows of that. It is off by some "
                f"{part:.0%} of the largest, while interface points are where they should be. Fix: build the model with "
                f"{times_as_many(factor)} as many {elements_of(scene, body)}, or with more modes.",
            )


@check("weight-between-nodes", STATES)
def energy_between_nodes(solution: Solution) -> Iterator[Caution]:
    """Doubts about strain energies at an instant that lack what weight and inertia do between nodes."""
    scene, last = solution.system.scene, len(solution.times) - 1
    if not has_inertia(solution) and not np.real(scene.gravity).any():
        return
    for name, response in scene.responses.items():
        if isinstance(response, StrainEnergy) and (solution.steps or not response.needs_motion):
            step = response.step(solution)
            missing = _energy_missed(solution, response.body, step)
            largest = (
                max(float(np.real(response.at(solution, n).value)) for n in {step, *spread(last, INSTANTS)}) if missing else 0.0
            )
            if missing > LIMIT * (largest + missing):
                part = missing / (largest + missing)
                yield energy_between_nodes.caution(
                    f"{name} lacks what weight and forces of inertia bend and stretch elements by between their nodes. It is off by some "
                    f"{part:.0%} of the largest that it is, while interface points are where they should be. Fix: build the model with "
                    f"{times_as_many((part / LIMIT) ** 0.25)} as many elements.",
                )


def _energy_missed(solution: Solution, asked: str | None, step: int) -> float:
    """Strain energy of one body, or of all, that elements miss at one state.

    Of an element of length l that a force per length p bends and stretches between nodes that are right,

        (e x p)^2 l^5 / (1440 E I) + (e . p)^2 l^3 / (24 E A)
    """
    scene, total = solution.system.scene, 0.0
    for name, body in deforming(scene).items():
        behind = chain(scene, name)
        if behind is None or asked not in (None, name, getattr(body, "whole", None)):
            continue
        found, bending = beams_of(behind), _bending(behind)
        pull = _density(scene, body, found)[:, None] * pull_on_elements(solution, name, behind, np.array([step]))[0]
        across = _across(found.along, pull[None])[0]
        along = np.einsum("ei,ei->e", pull, found.along)
        bent = np.einsum("ei,eij,ej->e", across, np.linalg.pinv(bending, hermitian=True), across)
        total += float(np.sum(bent * found.lengths**4 / 720 + along**2 * found.lengths**3 / (24 * found.axial)))
    return total


def _density(scene: ResolvedScene, body: ModelBody, found: Beams) -> np.ndarray:
    """Mass per length of the elements (n_e,), as of one material."""
    (mass,) = body.some_invariants(scene, "mass")
    per_length: np.ndarray = float(np.real(mass)) * found.axial / (found.axial @ found.lengths)
    return per_length


ALMOST = 1e-3
"""Part of a tenth by which a factor may exceed the one in a message."""


def times_as_many(factor: float) -> str:
    """A phrase with a factor that is enough, not rounded down to what is there already."""
    return f"{max(np.ceil(10 * factor - ALMOST) / 10, 1.1):.3g} times"


class MissedStrains(NamedTuple):
    """Strains of fibres (n_t, n_e): missed by elements across and along, told by them, and both with their signs.

    The last is known where all shapes of the elements are there; a basis lacks shapes under forces of joints besides.
    """

    across: np.ndarray
    along: np.ndarray
    told: np.ndarray
    both: np.ndarray
    known: bool


def _missed(parts: list[MissedStrains], anywhere: bool) -> tuple[float, float, float]:
    """Parts of the largest strain that a body's elements miss, across and along, and the largest that they tell.

    The largest is what a response asks for. What elements miss where they are strained little does not count, unless it is asked for
    `anywhere`; nor is it all that is missed at most, where signs are known.
    """
    if not parts:
        return 0.0, 0.0, 0.0
    strains = [(each.across, each.along, each.told, each.both) for each in parts]
    across, along, told, both = (max(float(each.max()) for each in every) for every in zip(*strains, strict=True))
    at_most = anywhere or not all(each.known for each in parts)
    share = 1.0 if at_most else abs(both - told) / (across + along) if across + along else 0.0
    return share * across, share * along, told


def _looks_anywhere(scene: ResolvedScene, body: str) -> bool:
    """Whether a response asks for the body's stress at a place of its own, and not for the largest."""
    asked = [each.source if isinstance(each, OverTime) else each for each in scene.responses.values()]
    return any(isinstance(each, LocalStress) and each.body == body for each in asked)


def _strains(solution: Solution, name: str) -> MissedStrains | None:
    """Strains of a part at its largest deformations; None where these are not known."""
    scene = solution.system.scene
    behind, body = chain(scene, name), scene.body(name)
    if behind is None or not isinstance(body, CuttableBody | FramedPart):
        return None
    found, elastic = beams_of(behind), np.real(solution.q[:, elastic_coordinates(solution, name)])
    instants = instants_of(solution, name)
    pull = _density(scene, body, found)[:, None] * pull_on_elements(solution, name, behind, instants)
    pull = pull + pressure_on_elements(solution, name, behind, instants)
    along = np.einsum("tei,ei->te", pull, found.along)
    normal = pull - along[:, :, None] * found.along
    fibre = FIBRE / (found.axial * np.sqrt(found.gyration))
    between = np.linalg.norm(normal, axis=2) * found.lengths**2 / 12 * fibre
    stretched = np.abs(along) * found.lengths / 2 / found.axial
    told_apart = behind.is_full or behind.per_node > PlanarChain.per_node  # parts in space are looked at by `left_out_shapes`
    unknown = np.zeros((1, behind.forms.count)) if told_apart else _outside_the_basis(scene, name, behind, found, pull)
    u = behind.displacements(elastic[instants])
    across = between + _fibre_strains(found, behind.forms.forces(unknown))
    forces = behind.forms.forces(u)
    return MissedStrains(across, stretched, _fibre_strains(found, forces), _with_loads(found, forces, pull), told_apart)


def _with_loads(found: Beams, forces: np.ndarray, pull: np.ndarray) -> np.ndarray:
    """Largest strains (n_t, n_e) of elements under forces per length p (n_t, n_e, d) between nodes that are right.

    With e along the element, which tells M_1, M_2 and N, its ends and its middle have

        M_1 - (e x p) l^2 / 12,   M_2 + (e x p) l^2 / 12,   (M_2 - M_1) / 2 - (e x p) l^2 / 24,   N +- e . p l / 2
    """
    bend = _across(found.along, pull) * (found.lengths**2 / 12)[:, None]
    first, last = np.moveaxis(forces[:, :, 1:].reshape(*bend.shape[:2], 2, -1), 2, 0)
    stretch = np.einsum("tei,ei->te", pull, found.along) * found.lengths / 2
    moments = (first - bend, (last - first) / 2 - bend / 2, last + bend)
    normal = (forces[:, :, 0] + sign * stretch for sign in (1, 0, -1))
    return np.max([_strain(found, n, np.linalg.norm(m, axis=2)) for n, m in zip(normal, moments, strict=True)], axis=0)


def _across(along: np.ndarray, pull: np.ndarray) -> np.ndarray:
    """Cross product e x p of directions and forces per length, (n_t, n_e, 1 or 3)."""
    if along.shape[1] == 3:
        return np.cross(along[None], pull)
    return (along[:, 0] * pull[:, :, 1] - along[:, 1] * pull[:, :, 0])[:, :, None]


def _strain(found: Beams, normal: np.ndarray, moment: np.ndarray) -> np.ndarray:
    strain: np.ndarray = np.abs(normal) / found.axial + FIBRE * moment / (found.axial * np.sqrt(found.gyration))
    return strain


def _fibre_strains(found: Beams, forces: np.ndarray) -> np.ndarray:
    """Largest strains (n_t, n_e) of fibres, from forces of elements (n_t, n_e, k)."""
    moments = np.linalg.norm(forces[:, :, 1:].reshape(*forces.shape[:2], 2, -1), axis=3).max(axis=2)
    return _strain(found, forces[:, :, 0], moments)


def _outside_the_basis(scene: ResolvedScene, name: str, behind: Chain, found: Beams, pull: np.ndarray) -> np.ndarray:
    """Displacements of the plane's nodes under forces per length (n_t, n_e, 2) that no shape of the basis knows, (n_t, n)."""
    half = pull * found.lengths[:, None] / 2
    turn = (found.along[:, 0] * half[:, :, 1] - found.along[:, 1] * half[:, :, 0]) * found.lengths / 6
    loads = np.zeros((len(behind.nodes), len(pull), behind.per_node))
    for node, sign in zip(found.ends.T, (1, -1), strict=True):
        np.add.at(loads, node, np.swapaxes(np.concatenate([half, sign * turn[:, :, None]], axis=2), 0, 1))
    flat = np.swapaxes(loads, 0, 1).reshape(len(pull), -1)
    stiffness = np.real(design_point(scene, name).value("stiffness"))
    known: np.ndarray = static_deflection(stiffness, behind.shapes.T @ flat.T).T @ behind.shapes.T
    return behind.under(flat) - known
