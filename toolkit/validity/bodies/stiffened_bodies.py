"""Bodies whose deflections the equations make too large, because tension, which they do not know as stiffness, holds them back.

A state of a scene with the stiffness across its tension, which the equations lack.

With K of the whole scene at the state, G_1 the geometric stiffness of the axial forces that the bodies know, and G_2 of those that their
deflection z gives them (`grown_elements`), which grow with its square, the true deflection z + d has

    (K + G_1 + t G_2) d = -(G_1 + t G_2) z,    t = (z + d)^T G_2 (z + d) / z^T G_2 z

For one shape that is the cubic of von Karman's beam: a part a of the deflection with a (1 + N_1 / P) + (N_2 / P) a^3 = 1 and the critical
force P of the same shape. d is looked for among what G_1 and G_2 lead to in two steps (Krylov's space). Small motions about the true state
have

    T = G_1 + t G_2 + 2 G_2 (z + d) (z + d)^T G_2 / z^T G_2 z

on top of K.

Looked at are those states alone in which tension would count if nothing else were stiff: where the axial forces are a part of the critical
one, or where the energy of the lines that grow is a part of that of the deflection.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.value_types import Matrix
from toolkit.system.solution import Solution, elastic_coordinates, flexible_body
from toolkit.validity.bodies.deformation import LIMIT, displacements, flexible_bodies, instants_of
from toolkit.validity.bodies.geometric_stiffness import Yielding, stiffening, yielding
from toolkit.validity.bodies.pulled_body import PulledBody, PulledChain, pulled_lines

DEPENDENT_DIRECTION = 1e-10
"""Part of the largest energy below which a direction is round-off of others."""
HALVINGS = 24
STIFFENING_ITERATIONS = 12
"""Iterations for the largest stiffening: a tenth of it is not felt in messages."""
Form = Callable[[np.ndarray], np.ndarray]


class StiffenedState(NamedTuple):
    """One state of a solution with the stiffness across its tension; coordinates are those of the whole scene."""

    instant: int
    yields: Yielding  # K^-1
    elastic: np.ndarray  # (n_q,) which coordinates are elastic ones
    there: np.ndarray  # z (n_q,), of these alone
    change: np.ndarray  # d (n_q,)
    adds: Form  # T of a motion (n_q,)
    pulls: Form  # G_1 + t G_2
    first: Form  # G_1
    growing: np.ndarray  # (n_q,) what its growth pulls with at the coordinates, t times the forces of z

    def largest(self) -> float:
        """Largest part by which T stiffens the scene against any motion, approximately."""
        x = self.yields(self.adds(np.random.default_rng(0).normal(size=len(self.there)) * self.elastic))
        found = 0.0
        for _ in range(STIFFENING_ITERATIONS):
            force = self.adds(x)
            if not (work := float(force @ x)) > 0:
                return found
            x, before = self.yields(force), x
            found = float(force @ x) / work
            x = x / np.abs(x).max() * np.abs(before).max()
        return found


def stiffened_state(solution: Solution, known: Mapping[str, PulledBody], n: int) -> StiffenedState | None:
    """The stiffened state at state `n` of a solution; None where the scene's compliance is not unique."""
    yields = yielding(solution, n)
    if yields is None:
        return None
    places = {body: elastic_coordinates(solution, body) for body in known}
    elastic = np.zeros(solution.system.n_q, bool)
    for where in places.values():
        elastic[where] = True
    there = np.where(elastic, np.real(solution.q[n]), 0.0)
    first = _form(places, {body: each.stiffness(there[places[body]]) for body, each in known.items()})
    found = {body: each.grown(there[places[body]]) for body, each in known.items()}
    forces = np.zeros(len(there))
    for body, each in found.items():
        forces[places[body]] = each.forces
    moved = yields(forces)
    second = _form(places, {body: each.stiffness(moved[places[body]]) for body, each in found.items()})
    change, part = _change(yields, first, second, there)
    return StiffenedState(
        n, yields, elastic, there, change, *_stiffness(first, second, there, change, part), first, part * forces
    )


def _form(places: Mapping[str, slice | np.ndarray], matrices: Mapping[str, Matrix]) -> Form:
    def form(motion: np.ndarray) -> np.ndarray:
        found = np.zeros(len(motion))
        for body, where in places.items():
            found[where] = matrices[body] @ motion[where]
        return found

    return form


def _stiffness(first: Form, second: Form, there: np.ndarray, change: np.ndarray, part: float) -> tuple[Form, Form]:
    grown_force, work = second(there + change), float(there @ second(there))

    def pulls(motion: np.ndarray) -> np.ndarray:
        return first(motion) + part * second(motion)

    def adds(motion: np.ndarray) -> np.ndarray:
        more = 2 * grown_force * (grown_force @ motion) / work if part > 0 else 0.0
        found: np.ndarray = pulls(motion) + more
        return found

    return adds, pulls


def _change(yields: Yielding, first: Form, second: Form, there: np.ndarray) -> tuple[np.ndarray, float]:
    """Change d of the deflection, and the part t of the second-order tension."""
    loads = [each for form in (first, second) if np.any(each := form(there))]
    moves = [yields(each) for each in loads]
    for form in (first, second):
        further = [form(each) for each in moves[:2]]
        loads += further
        moves += [yields(each) for each in further]
    if not moves:
        return np.zeros(len(there)), 0.0
    V = _independent(np.array(moves).T, np.array(loads).T)
    reduced = [np.array([form(each) for each in (*V.T, there)]) for form in (first, second)]
    squares, lines = [V.T @ each[:-1].T for each in reduced], [V.T @ each[-1] for each in reduced]
    work = float(there @ reduced[1][-1])

    def moved(part: float) -> np.ndarray:
        unit = np.eye(V.shape[1])
        found: np.ndarray = -np.linalg.solve(unit + squares[0] + part * squares[1], lines[0] + part * lines[1])
        return found

    part = _part(lambda t: (work + 2 * lines[1] @ (y := moved(t)) + y @ squares[1] @ y) / work) if work > 0 else 0.0
    return V @ moved(part), part


def _part(of: Callable[[float], float]) -> float:
    """Solution t of t = of(t), between none and all of the second-order tension."""
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if of(middle) > middle else (low, middle)
    return (low + high) / 2


def _independent(moves: np.ndarray, loads: np.ndarray) -> np.ndarray:
    """Independent motions of unit energy (n_q, m) that span those under loads."""
    size = np.abs(moves).max(axis=0)
    kept = size > 0
    moves, loads = moves[:, kept] / size[kept], loads[:, kept] / size[kept]
    energy = moves.T @ loads
    values, vectors = np.linalg.eigh((energy + energy.T) / 2)
    good = values > DEPENDENT_DIRECTION * values.max(initial=0.0)
    found: np.ndarray = moves @ (vectors[:, good] / np.sqrt(values[good]))
    return found


DERIVATIVE_FACTOR = 4.0
"""How much more derivatives of an equilibrium may lack than its deflections: three times as much, as tension grows with the square."""


class TooLarge(NamedTuple):
    """What of the deflection of a body is too much at one state."""

    body: str
    part: float  # of its largest displacement
    by_itself: bool  # whether its own deflection pulls at it, more than other forces do
    state: StiffenedState


def too_large(solution: Solution) -> TooLarge | None:
    """The body and the state where it is most; None where no body is near."""
    found = [each for state in stiffened_states(solution) for each in _of_bodies(solution, state)]
    return found[first_largest(np.array([each.part for each in found]))] if found else None


def stiffened_states(solution: Solution) -> list[StiffenedState]:
    """The states where tension may count: two at most."""
    if StiffenedState not in solution.known:
        known = pulled_bodies(solution)
        states = [] if solution.spins else _where_it_counts(solution, known)
        found = [stiffened_state(solution, known, n) for n in states]
        solution.known[StiffenedState] = [each for each in found if each is not None]
    states_of: list[StiffenedState] = solution.known[StiffenedState]
    return states_of


def pulled_bodies(solution: Solution) -> dict[str, PulledBody]:
    """Bodies whose tension is known, without those that ask for the stiffening of their spin, which would count twice."""
    scene = solution.system.scene
    asked = [body for body in flexible_bodies(scene) if flexible_body(scene, body).stiffening(scene) is None]
    found = {body: _pulled(solution, body) for body in asked}
    return {body: each for body, each in found.items() if each is not None}


def _pulled(solution: Solution, body: str) -> PulledBody | None:
    law = stiffening(solution.system.scene, body)
    return pulled_lines(solution, body) if law is None else PulledChain(law)


def _where_it_counts(solution: Solution, known: Mapping[str, PulledBody]) -> list[int]:
    """Numbers of the states of most tension, and of the largest growth of lines."""
    parts: list[list[tuple[float, int]]] = [[], []]
    for body, law in known.items():
        elastic = np.real(solution.q[:, elastic_coordinates(solution, body)])
        instants = instants_of(solution, body)
        for kind, each in enumerate(law.measures(elastic[instants])):
            worst = first_largest(each)
            parts[kind].append((float(each[worst]), int(instants[worst])))
    found = [max(each, key=lambda pair: pair[0]) for each in parts if each]
    enough = LIMIT / DERIVATIVE_FACTOR if solution.dq.shape[2] or not solution.steps else LIMIT
    return sorted({n for part, n in found if part > enough})


def _of_bodies(solution: Solution, state: StiffenedState) -> list[TooLarge]:
    scene, pulled = solution.system.scene, state.pulls(state.there)
    found: dict[str, TooLarge] = {}
    for body, law in pulled_bodies(solution).items():
        where, whole = elastic_coordinates(solution, body), getattr(scene.body(body), "whole", body)
        work = float(state.there[where] @ pulled[where])
        error = _moved(solution, law, body, state) if work > 0 else 0.0
        if error > 0:
            of_force = float(state.there[where] @ state.first(state.there)[where])
            each = TooLarge(whole, error / _size(solution, law, body, whole), of_force < work / 2, state)
            found[whole] = max(each, found.get(whole, each), key=lambda one: one.part)
    return list(found.values())


def _moved(solution: Solution, law: PulledBody, body: str, state: StiffenedState) -> float:
    """The largest distance by which a node is elsewhere; of a part of a cut body with that of its frame."""
    change = state.change
    found = float(law.distances(change[elastic_coordinates(solution, body)][None])[0])
    written: Any = solution.system.scene.body(body)
    if getattr(written, "whole", None) and written.frame_size:
        first = solution.coordinates(body).start
        found = max(found, float(np.linalg.norm(change[first : first + solution.system.scene.dimension])))
    return found


def _size(solution: Solution, law: PulledBody, body: str, whole: str) -> float:
    """The largest displacement of the body in the run."""
    elastic = np.real(solution.q[:, elastic_coordinates(solution, body)])
    instants = instants_of(solution, body)
    if whole != body:
        return float(displacements(solution, whole, instants).max())
    return float(law.distances(elastic[instants]).max())


def most_pulled(solution: Solution) -> str:
    """The body, cut or not, that axial forces or its own deflection would stiffen most."""
    known = pulled_bodies(solution)
    parts = []
    for body, law in known.items():
        elastic = np.real(solution.q[-1:, elastic_coordinates(solution, body)])
        parts.append(max(float(each[0]) for each in law.measures(elastic)))
    name = list(known)[first_largest(np.array(parts))]
    whole: str = getattr(solution.system.scene.body(name), "whole", name)
    return whole
