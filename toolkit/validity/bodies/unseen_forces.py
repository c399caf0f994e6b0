"""Forces along bodies whose bases hold no shape that stretches them: of loads, weight and inertia, and what they do.

Forces along bodies whose bases hold no shape that stretches them: what they do to deflections is in no equation, and is found by hand.

Known are the forces at the interface points, those of loads and joints, and those of weight and inertia. What the basis misses of the
axial forces N of the elements under them has the geometric stiffness G, and deflections z of the equations, with the compliance Y of the
whole scene, should be z + d:

    (1 + Y G) d = -Y G z

Bases that hold no shape which stretches a body: the checks read axial forces from its stretch, and see none where forces pull at it.

What forces at points, weight and inertia do is then found without the basis (`unseen_forces`).

Judged by unit forces f at the points of the body: the axial forces N = F K^-1 Psi^T f of the basis against
those of all its elements.

So it is with eigenmodes of a beam in space, or of a slender solid. On the line of length L along e from what holds the frame to the
farthest point that is used, with the body's mass m spread evenly, they pull with

    N(x) = m int_x^1 e . f(s) ds + e . F

where f is weight and the inertia of the frame per mass and F the force at the point, of which `carried_force` knows what it compresses. On
the edges beside the line, of slope s across it, G is L mean(N s^T s). What that does to deflections, `doubts_of_unseen` says: as of beams
in the plane, whose elements are known.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.scene.resolution import ResolvedScene
from toolkit.solvers.static.static_matrix import as_dense
from toolkit.system.solution import Solution, design_point, elastic_coordinates, flexible_body, used_interfaces
from toolkit.validity.bodies.beam_assumptions import pull_of_frame
from toolkit.validity.bodies.carried_force import lines_between, static_deflection, still_points
from toolkit.validity.bodies.chain import Chain
from toolkit.validity.bodies.deformation import LIMIT, divided, flexible_bodies, instants_of
from toolkit.validity.bodies.geometric_stiffness import Stiffening, forces_at_points, stiffening, yielding
from toolkit.validity.bodies.known_chain import chain, has_chain
from toolkit.validity.bodies.pulled_body import Edges, Shown, compliance_along, edges_beside, shown_of

EXAMINED_INSTANTS = 24
"""Instants, evenly spread over the motion, among which the largest force along a body is looked for."""
UNCOUNTED_FACTOR = 20.0
"""Times that a number is off above which they are not counted."""


class Unseen(NamedTuple):
    """What forces along a body do that its basis does not see."""

    time: float
    load: float  # in parts of what makes the scene give way; negative in tension
    off: float  # part of the deflection: how much is missing, or too much if negative; inf from the critical load on


def unseen_forces(
    solution: Solution, body: str, missing: Mapping[str, np.ndarray], by_mass: Callable[[np.ndarray], np.ndarray]
) -> Iterator[Caution]:
    """Doubts about one body.

    Parameters
    ----------
    missing
        Interface point -> axial forces (d, n_e) under unit forces there that the basis does not show.
    by_mass
        From numbers of instants (n_t,) to axial forces (n_t, n_e) by weight and inertia that it does not show.
    """
    law = stiffening(solution.system.scene, body)
    if law is not None:
        states = [(n, as_dense(law.of_axial(axial))) for n, axial in _states(solution, body, law, missing, by_mass)]
        yield from doubts_of_unseen(solution, body, states, partial(_distances, law))


def doubts_of_unseen(
    solution: Solution, body: str, states: Iterable[tuple[int, np.ndarray]], distances: Callable[[np.ndarray], np.ndarray]
) -> Iterator[Caution]:
    """A doubt about the worst of some states of one body.

    Parameters
    ----------
    states
        Numbers of states, and the geometric stiffness G (n_f, n_f) there that no equation knows.
    distances
        From elastic coordinates (n_t, n_f) to the largest displacements (n_t,).
    """
    known = [found for n, stiffness in states if (found := _at(solution, body, n, stiffness, distances)) is not None]
    if known:
        worst = known[first_largest(np.array([min(np.abs(each.off), UNCOUNTED_FACTOR) for each in known]))]
        if not np.abs(worst.off) <= LIMIT:
            part = worst.off if worst.load > 0 else -worst.off / (1 + worst.off) if worst.off > -1 else np.inf
            yield Caution("critical-load" if worst.load > 0 else "tension", _told(solution, body, worst), body=body, part=part)


def _states(
    solution: Solution,
    body: str,
    law: Stiffening,
    missing: Mapping[str, np.ndarray],
    by_mass: Callable[[np.ndarray], np.ndarray],
) -> Iterator[tuple[int, np.ndarray]]:
    """Numbers of the states of most compression and of most tension, and the axial forces (n_e,) there that the basis does not show."""
    instants = _instants(solution)
    forces = forces_at_points(solution, body, instants) if missing else {}
    axial = sum((forces[name] @ each for name, each in missing.items() if name in forces), by_mass(instants))
    softer = -(axial * law.compliances).sum(axis=1)
    for sign in (1.0, -1.0):
        k = first_largest(sign * softer)
        if sign * softer[k] > LIMIT / 2:
            yield int(instants[k]), axial[k]


def _instants(solution: Solution) -> np.ndarray:
    """Numbers of the states among which those of the largest forces are looked for."""
    return np.unique(np.linspace(0, len(solution.times) - 1, EXAMINED_INSTANTS).astype(int))


def _at(
    solution: Solution, body: str, n: int, stiffness: np.ndarray, distances: Callable[[np.ndarray], np.ndarray]
) -> Unseen | None:
    where, yields = elastic_coordinates(solution, body), yielding(solution, n)
    elastic = np.real(solution.q[:, where])
    largest = elastic[instants_of(solution, body)]
    z = largest[first_largest(distances(largest))]
    size = float(distances(z[None])[0])
    if yields is None or not size > 0:
        return None
    unit = np.zeros((solution.system.n_q, elastic.shape[1]))
    unit[where] = np.eye(elastic.shape[1])
    compliance = np.stack([yields(each)[where] for each in unit.T], axis=1)
    added = compliance @ stiffness
    softened = -np.linalg.eigvals(added).real
    load = float(softened.max() if softened.max() > -softened.min() else softened.min())
    if load >= 1:
        return Unseen(float(solution.times[n]), load, np.inf)
    change = -np.linalg.solve(np.eye(len(added)) + added, added @ z)
    part = float(distances(change[None])[0]) / size
    return Unseen(float(solution.times[n]), load, part if load > 0 else -part)


def _distances(law: Stiffening, elastic: np.ndarray) -> np.ndarray:
    return np.array([law.behind.distances(law.behind.displacements(each[None])).max() for each in elastic])


def _told(solution: Solution, body: str, found: Unseen) -> str:
    when = f" at t = {found.time:.4g}" if solution.steps else ""
    how = "compress" if found.load > 0 else "pull at"
    if found.off == np.inf:
        what = "it buckles if that lasts, which these numbers do not show"
    elif found.load > 0:
        what = f"its deflections lack {found.off:.2g} times themselves, and frequencies are lower"
    else:
        what = _stiffer(found)
    return (
        f"forces {how} {body}{when} with {np.abs(found.load):.2g} times the critical load, which its basis does not show: "
        f"{what}. Linear FFRF has no geometric stiffness of a body in its frame. Fix: "
        f"{divided(solution.system.scene, body, 1.0)}."
    )


def _stiffer(found: Unseen) -> str:
    times = 1 / (1 + found.off) if found.off > -1 else np.inf
    told = f"{times:.3g} times" if times < UNCOUNTED_FACTOR else "many times"
    return f"its deflections are {told} as large as they should be, and frequencies across it are higher"


MISSED_FORCE_PART = 0.2
"""Part of the axial forces that a basis may miss without a word."""


@check("tension", STATES)
def unseen_tension(solution: Solution) -> Iterator[Caution]:
    """Flexible bodies whose points forces pull at that their bases do not see, or whose weight and inertia do."""
    scene = solution.system.scene
    for body in flexible_bodies(scene):
        behind = chain(scene, body)
        if behind is not None and not behind.is_full:
            yield from unseen_forces(solution, body, _missing(scene, body, behind), partial(_by_mass, solution, body, behind))


def _pulls(scene: ResolvedScene, body: str, behind: Chain) -> dict[str, np.ndarray]:
    """Unit loads (d, n) on the nodes in all directions at interface points that the scene uses.

    The frame is no such point: forces at it do not stretch the body.
    """
    design, nodes = design_point(scene, body, "interfaces"), behind.nodes
    found = {}
    for name in used_interfaces(scene, body):
        place = np.real(design.interface(name).here[0])[:, 0]
        found[name] = _on(behind, [int(np.argmin(((nodes - place) ** 2).sum(axis=1)))])
    return found


def _by_mass(solution: Solution, body: str, behind: Chain, instants: np.ndarray) -> np.ndarray:
    """Axial forces (n_t, n_e) by weight and by the inertia of the frame's motion that the basis does not show; zero where a spin's
    stiffening is in the equations already."""
    scene = solution.system.scene
    alike, by_place, _ = pull_of_frame(solution, body, instants)
    pulls = alike[:, None] + np.einsum("tij,nj->tni", by_place, behind.nodes)
    if not np.any(pulls) or flexible_body(scene, body).stiffening(scene) is not None:
        return np.zeros((len(instants), 1))
    loads = np.zeros((len(instants), len(behind.nodes), behind.per_node))
    loads[:, :, : pulls.shape[2]] = pulls * _nodal_masses(scene, body, behind)[:, None]
    true, shown = axial_forces(scene, body, behind, loads.reshape(len(instants), -1))
    return true - shown


def _nodal_masses(scene: ResolvedScene, body: str, behind: Chain) -> np.ndarray:
    """Mass of the body by its nodes, (n_nodes,): of each element as its stiffness along it says, as of one material."""
    ends = behind.forms.dofs[:, [0, -1]] // behind.per_node
    lengths = np.linalg.norm(behind.nodes[ends[:, 1]] - behind.nodes[ends[:, 0]], axis=1)
    parts = behind.forms.law[:, 0, 0] * lengths**2
    found = np.zeros(len(behind.nodes))
    for side in (0, 1):
        np.add.at(found, ends[:, side], parts / 2)
    whole: np.ndarray = np.real(design_point(scene, body).value("mass")) * found / found.sum()
    return whole


def _on(behind: Chain, loaded: Iterable[int]) -> np.ndarray:
    d = behind.nodes.shape[1]
    loads = np.zeros((d, len(behind.nodes), behind.per_node))
    for axis in range(d):
        loads[axis, list(loaded), axis] = 1.0
    return loads.reshape(d, -1)


def _missing(scene: ResolvedScene, body: str, behind: Chain) -> dict[str, np.ndarray]:
    """Where forces pull -> axial forces (d, n_e) under unit forces that the basis does not show, if they are more than
    `MISSED_FORCE_PART`."""
    found = {}
    for name, loads in _pulls(scene, body, behind).items():
        true, shown = axial_forces(scene, body, behind, loads)
        if np.linalg.norm(shown - true) > MISSED_FORCE_PART * np.linalg.norm(true):
            found[name] = true - shown
    return found


def axial_forces(scene: ResolvedScene, body: str, behind: Chain, loads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Axial forces of the elements (n_t, n_e) under loads (n_t, n) on the nodes, and what the basis shows of them."""
    stiffness = np.real(design_point(scene, body).value("stiffness"))
    elastic = static_deflection(stiffness, behind.shapes.T @ loads.T).T
    return behind.axial_forces(behind.under(loads)), behind.axial_forces(behind.displacements(elastic))


class UnseenLine(NamedTuple):
    """The line of one body, and what is beside it."""

    point: str
    start: np.ndarray
    side: np.ndarray  # L e (d,)
    edges: Edges
    shown: Shown


@check("tension", STATES)
def unseen_lines(solution: Solution) -> Iterator[Caution]:
    """Doubts about bodies that their weight or inertia pulls at, or compresses, unseen."""
    scene: Any = solution.system.scene
    for body in () if solution.spins else flexible_bodies(scene):
        known = has_chain(scene, body) or flexible_body(scene, body).stiffening(scene) is not None
        line = None if known else _line(solution, body)
        if line is not None:
            yield from doubts_of_unseen(solution, body, _far_states(solution, body, line), partial(_along, line))


def _line(solution: Solution, body: str) -> UnseenLine | None:
    """The longest; None where the basis shows a force along any."""
    scene: Any = solution.system.scene
    design = design_point(scene, body, "surface", "outline", "interfaces")
    key = (UnseenLine, *used_interfaces(scene, body))
    if key not in design.kept:
        design.kept[key] = _found(solution, body, design)
    found: UnseenLine | None = design.kept[key]
    return found


def _found(solution: Solution, body: str, design: DesignPoint) -> UnseenLine | None:
    shown, stiffness = shown_of(design), np.real(design.value("stiffness"))
    still = None if shown is None else still_points(shown.places, shown.shapes)
    ends = [*lines_between(solution, body, still)]
    if shown is None or not ends or any(compliance_along(stiffness, motion, motion[:, 0]) > 0 for *_, motion in ends):
        return None
    point, start, motion = max(ends, key=lambda each: float(np.linalg.norm(each[2][:, 0])))
    edges = edges_beside(shown, start, motion[:, 0])
    return None if edges is None else UnseenLine(point, start, motion[:, 0], edges, shown)


def _far_states(solution: Solution, body: str, line: UnseenLine) -> Iterator[tuple[int, np.ndarray]]:
    """Numbers of the states of most compression and of most tension, and G there."""
    instants = _instants(solution)
    by_mass, at_point = _forces(solution, body, line, instants)
    stiffness = np.real(design_point(solution.system.scene, body).value("stiffness"))
    for sign, forces in ((1.0, by_mass), (-1.0, by_mass + at_point[:, None])):
        every = [_geometric(line, each) for each in forces]
        softer = np.array([-sign * np.trace(static_deflection(stiffness, each)) for each in every])
        k = first_largest(softer)
        if softer[k] > LIMIT / 2:
            yield int(instants[k]), every[k]


def _forces(solution: Solution, body: str, line: UnseenLine, instants: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """N at the middles of the edges by the mass (n_t, n_e), and by what is at the point (n_t,)."""
    design = design_point(solution.system.scene, body)
    alike, by_place, _ = pull_of_frame(solution, body, instants)
    along = line.side / np.linalg.norm(line.side)
    at_start = (alike + np.einsum("tij,j->ti", by_place, line.start)) @ along
    growing = np.einsum("i,tij,j->t", along, by_place, line.side)
    x = line.edges.places
    by_mass = float(np.real(design.value("mass"))) * (at_start[:, None] * (1 - x) + growing[:, None] * (1 - x * x) / 2)
    none = np.zeros((len(instants), len(along)))
    return by_mass, forces_at_points(solution, body, instants).get(line.point, none) @ along


def _geometric(line: UnseenLine, forces: np.ndarray) -> np.ndarray:
    """G (n_f, n_f) of forces at the edges (n_e,)."""
    weights = np.linalg.norm(line.side) * line.edges.weights * forces
    found: np.ndarray = np.einsum("e,edi,edj->ij", weights, line.edges.slopes, line.edges.slopes)
    return found


def _along(line: UnseenLine, elastic: np.ndarray) -> np.ndarray:
    """Largest displacement of a point of the surface (n_t,)."""
    found: np.ndarray = np.linalg.norm(np.einsum("pdf,tf->tpd", line.shown.shapes, elastic), axis=2).max(axis=1)
    return found
