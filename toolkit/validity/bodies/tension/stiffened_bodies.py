"""Bodies whose deflections the equations make too large, because tension, which they do not know as stiffness, holds them back.

Looked at are those states alone in which tension would count if nothing else were stiff: where the axial forces are a part of the critical
one, or where the energy of the lines that grow is a part of that of the deflection.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.system.flexible_bodies import elastic_coordinates, flexible_body
from toolkit.system.solution import Solution
from toolkit.validity.bodies.compressed.geometric_stiffness import stiffening
from toolkit.validity.bodies.cut.places import displacements
from toolkit.validity.bodies.deformation import LIMIT, flexible_bodies, instants_of
from toolkit.validity.bodies.tension.pulled_body import PulledBody
from toolkit.validity.bodies.tension.pulled_chain import PulledChain
from toolkit.validity.bodies.tension.pulled_lines import pulled_lines
from toolkit.validity.bodies.tension.stiffened_state import StiffenedState, stiffened_state

OF_DERIVATIVES = 4.0
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
    enough = LIMIT / OF_DERIVATIVES if solution.dq.shape[2] or not solution.steps else LIMIT
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
