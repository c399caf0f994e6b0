"""Weight and inertia along bodies whose elements are not known and whose basis holds no shape that stretches them.

So it is with eigenmodes of a beam in space, or of a slender solid. On the line of length L along e from what holds the frame to the
farthest point that is used, with the body's mass m spread evenly, they pull with

    N(x) = m int_x^1 e . f(s) ds + e . F

where f is weight and the inertia of the frame per mass and F the force at the point, of which `carried_force` knows what it compresses. On
the edges beside the line, of slope s across it, G is L mean(N s^T s). What that does to deflections, `doubts_of_unseen` says: as of beams
in the plane, whose elements are known.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.system.flexible_bodies import design_point, flexible_body, used_interfaces
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.known_chain import has_chain
from toolkit.validity.bodies.compressed.carried_force import lines_between, still_points
from toolkit.validity.bodies.compressed.forces_at_points import forces_at_points
from toolkit.validity.bodies.compressed.unseen_forces import doubts_of_unseen
from toolkit.validity.bodies.deformation import LIMIT, flexible_bodies
from toolkit.validity.bodies.element_accelerations import pull_of_frame
from toolkit.validity.bodies.static_deflection import static_deflection
from toolkit.validity.bodies.tension.pulled_lines import Edges, Shown, compliance_along, edges_beside, shown_of

LOOKED_AT = 24
"""Instants, evenly spread over a motion, among which the largest force along a body is looked for."""


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
            yield from doubts_of_unseen(solution, body, _states(solution, body, line), partial(_distances, line))


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


def _states(solution: Solution, body: str, line: UnseenLine) -> Iterator[tuple[int, np.ndarray]]:
    """Numbers of the states of most compression and of most tension, and G there."""
    instants = np.unique(np.linspace(0, len(solution.times) - 1, LOOKED_AT).astype(int))
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


def _distances(line: UnseenLine, elastic: np.ndarray) -> np.ndarray:
    """Largest displacement of a point of the surface (n_t,)."""
    found: np.ndarray = np.linalg.norm(np.einsum("pdf,tf->tpd", line.shown.shapes, elastic), axis=2).max(axis=1)
    return found
