"""Bending and stretch by weight and inertia between nodes, which beam elements leave out whatever their motion.

What pulls at the middles of a body's elements, per mass: weight, forces of inertia and c times the velocity, in the axes of its frame.

    A^T (g - r'' - c r') - (alpha + c omega) x p - omega x (omega x p) - 2 omega x p' - p'' - c p'
    p = X + (u_1 + u_2) / 2 + l / 8 (phi_1 - phi_2) x e

with the mass-proportional damping c, and displacements u and rotations phi of an element's ends, as its shape functions have it.

Weight less inertia, and pressure on the side of a piece of a solid, p per length, bend an element of length l by moments of up to
p l^2 / 12 more than its shape functions say; displacements of the nodes are those of the exact beam. In parts of the
largest strain of a fibre at sqrt(3) r, as of a rectangle,

    (sqrt(3) p l^2 / (12 E A r)) / max (|N| / E A + sqrt(3) |M| / (E A r))

Along an element p makes the force at one of its ends p l / 2 larger than the mean, which is all that the element says of it.

A basis of few shapes lacks besides what p, and the forces at points that go with it, move the nodes by and no shape knows. All of it is
added with its sign to what the elements tell, at every instant, and the largest is compared: what bends a beam where it is bent little,
or the other way, is nothing of its largest stress.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from toolkit.components.bodies.cuttable_body import CuttableBody
from toolkit.components.bodies.framed_part import FramedPart
from toolkit.components.bodies.model_body import ModelBody
from toolkit.foundation.near_ties import spread
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.responses.energy import StrainEnergy
from toolkit.responses.local_stress import LocalStress
from toolkit.responses.over_time import OverTime
from toolkit.responses.stress import StressResponse
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.quantities import pressures_of
from toolkit.system.solution import Solution, deforming, design_point, elastic_coordinates, elements_of
from toolkit.validity.bodies.carried_force import static_deflection
from toolkit.validity.bodies.chain import Chain, Sides, motion_rows, sides_of
from toolkit.validity.bodies.deformation import LIMIT, in_space, instants_of, whole_bodies
from toolkit.validity.bodies.geometric_stiffness import wrenches_at_points
from toolkit.validity.bodies.known_chain import PlanarChain, chain

FREE_FALL_DIFFERENCE = 1e-6
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
        drag = np.real(body.mass_damping(scene)) if solution.steps else 0.0
        inertia = inertia + drag * rate
        if body.moves:
            inertia = inertia + _turned_back(axes, a[:, : body.moves] + drag * v[:, : body.moves])[:, None]
        if body.turns:
            omega, alpha = (_cross(body.spins(q, x), behind.nodes.shape[1]) for x in (v, a))  # spins(v, v) = 0
            centre = behind.nodes[sides.ends].mean(axis=1) + place
            inertia = inertia + _applied(alpha + omega @ omega + drag * omega, centre) + 2 * _applied(omega, rate)
    found = weight - inertia
    sizes = np.linalg.norm(weight, axis=2) + np.linalg.norm(inertia, axis=2)
    return np.where((np.linalg.norm(found, axis=2) > FREE_FALL_DIFFERENCE * sizes)[:, :, None], found, 0.0)


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
        missed = _missed(solution, body)
        if missed.part > LIMIT:
            known = {"its weight": heavy, "pressures on it": pressed, "forces of inertia": moving}
            forces = " and ".join(words for words, there in known.items() if there)
            named = f"{forces} {'does' if forces == 'its weight' else 'do'}"
            yield bent_between_nodes.caution(
                f"the stress of {body} lacks what {named} between nodes, or what no shape of its basis knows of that. It is off by some "
                f"{missed.part:.0%} of the largest, while interface points are where they should be. Fix: build the model with "
                f"{times_as_many(missed.finer)} as many {elements_of(scene, body)}, or with more modes.",
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


FACTOR_ROUNDING = 1e-3
"""Part of a tenth by which a factor may exceed the one in a message."""


def times_as_many(factor: float) -> str:
    """A phrase with a factor that is enough, not rounded down to what is there already."""
    return f"{max(np.ceil(10 * factor - FACTOR_ROUNDING) / 10, 1.1):.3g} times"


class AskedStress(NamedTuple):
    """When and where a response looks at the stress of a body: at some states or all, at some ends of elements or all."""

    steps: np.ndarray | None = None
    ends: np.ndarray | None = None  # (n, 2) element and its end, 0 or 1
    signed: bool = False  # whether compression does not count


class Missed(NamedTuple):
    """Part of a stress that is missed, and parts of the largest strain that elements miss across and along them at most."""

    part: float = 0.0
    across: float = 0.0
    along: float = 0.0

    @property
    def finer(self) -> float:
        """How many times as many elements miss no more than the limit: across / factor^2 + along / factor."""
        across, along = self.part / (self.across + self.along) * np.array([self.across, self.along])
        return float(along + np.sqrt(along**2 + 4 * across * LIMIT)) / (2 * LIMIT)


class PartStrains(NamedTuple):
    """Strains of fibres of a part's elements (n_e) at some instants (n_t), by what acts between nodes: told, true and missed.

    Those by the normal force and by bending are at the beginning, the end and the middle of each element, (2, 3, n_t, n_e).
    """

    instants: np.ndarray  # (n_t,)
    elements: np.ndarray  # (n_e,) numbers in the body
    across: np.ndarray  # (n_t, n_e) missed at most, by weight, pressure and inertia alone
    along: np.ndarray
    told: np.ndarray
    true: np.ndarray
    missed: np.ndarray

    def seen(self, asked: AskedStress) -> np.ndarray:
        """Strains (5, 3, n_t, n_e) that a response looks at: missed at most across and along, told, true, missed; none elsewhere."""
        found = np.zeros((5, *self.told.shape[1:]))
        found[:2] = np.stack([self.across, self.along])[:, None]
        for k, (normal, bend) in enumerate((self.told, self.true, self.missed), start=2):
            found[k] = (normal if asked.signed and k < 4 else np.abs(normal)) + bend
        if asked.ends is not None:
            where = np.zeros((len(self.elements), 3))
            there = np.isin(asked.ends[:, 0], self.elements)
            where[asked.ends[there, 0] - self.elements[0], asked.ends[there, 1]] = 1.0
            found *= where.T[:, None]
        return found


def _missed(solution: Solution, body: str) -> Missed:
    """What elements miss of the stress of a body, by the response that is off most."""
    scene = solution.system.scene
    asked = [*_asked_stresses(solution, body)]
    steps = np.concatenate([np.zeros(0, int), *(each.steps for each in asked if each.steps is not None)])
    parts = [name for name, each in deforming(scene).items() if body in (name, getattr(each, "whole", None))]
    found = [each for name in parts if asked and (each := _strains(solution, name, steps)) is not None]
    return max((_off(each, found) for each in asked), default=Missed()) if found else Missed()


def _off(asked: AskedStress, parts: list[PartStrains]) -> Missed:
    """What is missed of a response, in parts of the largest that it looks at during the motion.

    It counts where weight, pressure and inertia alone make up half of the limit at most: what forces at points do in left-out shapes is
    looked at by `missed_statics`. What is missed where elements are strained little is nothing of the largest stress; at a place of its
    own all of it is.
    """
    seen = [each.seen(asked) for each in parts]
    at = [slice(None) if asked.steps is None else np.isin(each.instants, asked.steps) for each in parts]
    across, along, told, true, _ = (max(float(np.abs(each[k]).max()) for each in seen) for k in range(5))
    then = [each[:, :, when] for each, when in zip(seen, at, strict=True)]
    told_then, true_then, missed = (max(float(each[k].max()) for each in then) for k in (2, 3, 4))
    lacking, largest = (abs(true_then - told_then), true) if asked.ends is None else (missed, told + missed)
    least = FREE_FALL_DIFFERENCE * max(float(each.told.max()) for each in parts)
    if across + along <= LIMIT / 2 * (told + across + along) or lacking <= least:
        return Missed()
    return Missed(lacking / max(largest, least), across, along)


def _asked_stresses(solution: Solution, body: str) -> Iterator[AskedStress]:
    """Where responses look at the stress of a body."""
    scene, last = solution.system.scene, len(solution.times) - 1
    response: Any
    for response in scene.responses.values():
        source = response.source if isinstance(response, OverTime) else response
        if isinstance(source, StressResponse) and source.body == body:
            yield AskedStress(None if source.when == "all" else np.array([last]), signed=source.measure == "signed")
        elif isinstance(source, LocalStress) and source.body == body and (solution.steps or not response.needs_motion):
            steps = np.array([source.step(solution)]) if response is source else None
            yield AskedStress(steps, _ends(scene, source))


def _ends(scene: ResolvedScene, asked: LocalStress) -> np.ndarray:
    """Ends (n, 2) of elements that a response looks at; all where the model does not say whose its stress points are."""
    body: Any = scene.bodies[asked.body]
    model, rows = scene.model(body.model, "stress", "elements"), asked.rows(scene)
    points, elements = model.stress, model.elements
    if points is None:
        count = 0 if elements is None else len(elements.connectivity)
        return np.stack(np.meshgrid(np.arange(count), (0, 1)), axis=-1).reshape(-1, 2)
    return np.column_stack([points.element[rows], points.end[rows]]).astype(int)


def _strains(solution: Solution, name: str, steps: np.ndarray) -> PartStrains | None:
    """Strains of a part at its largest deformations and at some states; None where its elements are not known."""
    scene = solution.system.scene
    behind, body = chain(scene, name), scene.body(name)
    if behind is None or not isinstance(body, CuttableBody | FramedPart):
        return None
    found, elastic = beams_of(behind), np.real(solution.q[:, elastic_coordinates(solution, name)])
    instants = np.union1d(instants_of(solution, name), steps)
    pull = _density(scene, body, found)[:, None] * pull_on_elements(solution, name, behind, instants)
    pull = pull + pressure_on_elements(solution, name, behind, instants)
    along = np.einsum("tei,ei->te", pull, found.along)
    normal = pull - along[:, :, None] * found.along
    fibre = FIBRE / (found.axial * np.sqrt(found.gyration))
    between = np.linalg.norm(normal, axis=2) * found.lengths**2 / 12 * fibre
    by_mass, by_points = (behind.forms.forces(each) for each in _outside_the_basis(solution, name, behind, pull, instants))
    told = behind.forms.forces(behind.displacements(elastic[instants]))
    return PartStrains(
        instants,
        getattr(body, "first", 0) + np.arange(len(found.axial)),
        between + np.abs(_strains_at_places(found, by_mass)).sum(axis=0).max(axis=0),
        np.abs(along) * found.lengths / 2 / found.axial,
        _strains_at_places(found, told),
        _strains_at_places(found, told + by_mass + by_points, pull),
        _strains_at_places(found, by_mass + by_points, pull),
    )


def _strains_at_places(found: Beams, forces: np.ndarray, pull: np.ndarray | float = 0.0) -> np.ndarray:
    """Largest strains by normal force and bending (2, 3, n_t, n_e) of elements under forces per length p between nodes that are right.

    With e along the element, which tells M_1, M_2 and N, its ends and its middle have

        M_1 - (e x p) l^2 / 12,   M_2 + (e x p) l^2 / 12,   (M_2 - M_1) / 2 - (e x p) l^2 / 24,   N +- e . p l / 2
    """
    pull = np.broadcast_to(pull, (*forces.shape[:2], found.along.shape[1]))
    bend = _across(found.along, pull) * (found.lengths**2 / 12)[:, None]
    first, last = np.moveaxis(forces[:, :, 1:].reshape(*bend.shape[:2], 2, -1), 2, 0)
    stretch = np.einsum("tei,ei->te", pull, found.along) * found.lengths / 2
    moments = np.linalg.norm([first - bend, last + bend, (last - first) / 2 - bend / 2], axis=3)
    normal = np.stack([forces[:, :, 0] + sign * stretch for sign in (1, -1, 0)])
    strains: np.ndarray = np.stack([normal / found.axial, FIBRE * moments / (found.axial * np.sqrt(found.gyration))])
    return strains


def _across(along: np.ndarray, pull: np.ndarray) -> np.ndarray:
    """Cross product e x p of directions and forces per length, (n_t, n_e, 1 or 3)."""
    if along.shape[1] == 3:
        return np.cross(along[None], pull)
    return (along[:, 0] * pull[:, :, 1] - along[:, 1] * pull[:, :, 0])[:, :, None]


def _outside_the_basis(
    solution: Solution, name: str, behind: Chain, pull: np.ndarray, instants: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Displacements (n_t, n) of the plane's nodes that no shape of the basis knows, under forces per length (n_t, n_e, 2) and at points.

    Parts keep the coordinates of their points; those in space are looked at by `left_out_shapes`.
    """
    scene, none = solution.system.scene, np.zeros((len(instants), behind.forms.count))
    if behind.is_full or behind.per_node > PlanarChain.per_node:
        return none, none
    found, half = sides_of(behind), pull * sides_of(behind).lengths[:, None] / 2
    turn = _across(found.along, half) * found.lengths[:, None] / 6
    loads = np.zeros((len(behind.nodes), len(pull), behind.per_node))
    for node, sign in zip(found.ends.T, (1, -1), strict=True):
        np.add.at(loads, node, np.swapaxes(np.concatenate([half, sign * turn], axis=2), 0, 1))
    at_points = none
    for interface, wrench in ({} if name not in scene.bodies else wrenches_at_points(solution, name, instants)).items():
        place = np.real(design_point(scene, name, "interfaces").interface(interface).here[0][:, 0])
        at_points = at_points + wrench @ motion_rows(behind.nodes, found.ends, place)
    stiffness = np.real(design_point(scene, name).value("stiffness"))
    by_mass, by_points = (
        behind.under(flat) - static_deflection(stiffness, behind.shapes.T @ flat.T).T @ behind.shapes.T
        for flat in (np.swapaxes(loads, 0, 1).reshape(len(pull), -1), at_points)
    )
    return by_mass, by_points
