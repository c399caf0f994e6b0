"""A state of a scene with the stiffness across its tension, which the equations lack.

With K of the whole scene at the state, G_1 the geometric stiffness of the axial forces that the bodies know, and G_2 of those that their
deflection z gives them (`grown_elements`), which grow with its square, the true deflection z + d has

    (K + G_1 + t G_2) d = -(G_1 + t G_2) z,    t = (z + d)^T G_2 (z + d) / z^T G_2 z

For one shape that is the cubic of von Karman's beam: a part a of the deflection with a (1 + N_1 / P) + (N_2 / P) a^3 = 1 and the critical
force P of the same shape. d is looked for among what G_1 and G_2 lead to in two steps (Krylov's space). Small motions about the true state
have

    T = G_1 + t G_2 + 2 G_2 (z + d) (z + d)^T G_2 / z^T G_2 z

on top of K.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from toolkit.system.flexible_bodies import elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.compressed.yielding_scene import Yielding, yielding
from toolkit.validity.bodies.tension.pulled_body import PulledBody

DEPENDENT = 1e-10
"""Part of the largest energy below which a direction is round-off of others."""
HALVINGS = 24
STEPS = 12
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
        for _ in range(STEPS):
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


def _form(places: Mapping[str, Any], matrices: Mapping[str, Any]) -> Form:
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
    good = values > DEPENDENT * values.max(initial=0.0)
    found: np.ndarray = moves @ (vectors[:, good] / np.sqrt(values[good]))
    return found
