"""Forces of joints that hold a body at both ends: its deflection pulls at them long before it is stiffer by that.

A load across a body is held in proportion to the deflection w, the tension of the body grows with w^2: of a clamped bar that is bent by a
fifth of its thickness the joints hold three times as much along it as across it, while its deflection is 3 % off.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import Caution, check
from toolkit.responses.joint_force import JointForce
from toolkit.responses.over_time import OverTime
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.cut.more_frames import divided
from toolkit.validity.bodies.deformation import LIMIT, instants_of
from toolkit.validity.bodies.tension.pulled_body import PulledBody
from toolkit.validity.bodies.tension.stiffened_bodies import most_pulled, pulled_bodies
from toolkit.validity.bodies.tension.stiffened_state import stiffened_state

FELT, FELT_BY_GRADIENTS = 1e-5, 1e-6
"""Part of the critical force of a body below which its tension is no twentieth of what joints hold across it, and changes no gradient of
that by as much."""
STEEP = 5e-3
"""Part of a joint's force that a deflection pulls with from which its gradients are looked at: this part grows with the square of the
deflection or more, by a thickness with ten times its relative change."""
MANY = 100.0
"""Factor by which a force is off above which a message gives no factor."""
HARDLY = 0.1
"""Part of the largest force in any joint below which a force does not count."""
NAMED = 3
"""Largest number of responses that are named."""
LOOKED_AT = 24
"""Number of instants among which the largest force of a joint is sought."""


class Lacking(NamedTuple):
    """Part of a joint's force that the equations lack."""

    missing: float
    size: float  # the largest that it is in the motion
    counts: float  # the same, but at least a part of the largest force in any joint


@check("tension")
def pulled_joints(solution: Solution) -> Iterator[Caution]:
    """Doubts about responses that are joint forces, at the end or over time, and lack the pull of a deflection."""
    low = {name: each for name, each in lacking_joints(solution).items() if abs(each.missing) > LIMIT * each.counts > 0}
    if low:
        body, scene = most_pulled(solution), solution.system.scene
        asked = joint_forces(scene)
        told = [
            f"{name} by {abs(each.missing):.3g} {unit(scene.units, asked[name][0].unit_quantity)}, where it is {each.size:.3g} at the most"
            for name, each in list(low.items())[:NAMED]
        ]
        much = max(abs(each.missing) / each.size if each.size > 0 else MANY for each in low.values())
        yield pulled_joints.caution(
            f"the deflection of {body} pulls at what holds its ends, which these equations do not know: forces of joints are off, "
            f"{', '.join(told)}. Linear FFRF knows this between frames, and not inside of one. Fix: "
            f"{divided(scene, body, min(much, MANY) / LIMIT)}.",
        )


def lacking_joints(solution: Solution) -> dict[str, Lacking]:
    """Responses that are joint forces, with the pull of deflections that each lacks; empty where nothing grows."""
    if Lacking not in solution.known:
        solution.known[Lacking] = _lacking(solution)
    found: dict[str, Lacking] = solution.known[Lacking]
    return found


def _lacking(solution: Solution) -> dict[str, Lacking]:
    asked = joint_forces(solution.system.scene)
    known = pulled_bodies(solution) if asked and not solution.spins else {}
    grown = _most_grown(solution, known)
    found: dict[str, Lacking] = {}
    for n in set() if grown is None else {grown, len(solution.times) - 1}:
        mine = {name: each for name, (each, at_end) in asked.items() if n == (len(solution.times) - 1 if at_end else grown)}
        found |= _low(solution, known, n, mine)
    return found


def joint_forces(scene: Scene) -> dict[str, tuple[JointForce, bool]]:
    """Responses that are joint forces, or made of them, by name; and whether they are those at the end."""
    found = {name: (getattr(each, "of", each), not isinstance(each, OverTime)) for name, each in scene.responses.items()}
    return {name: (each, at_end) for name, (each, at_end) in found.items() if isinstance(each, JointForce)}


def _most_grown(solution: Solution, known: Mapping[str, PulledBody]) -> int | None:
    """Number of the state where deflections make lines grow most; None where no joint would feel it."""
    parts: list[tuple[float, int]] = []
    for body, law in known.items():
        elastic = np.real(solution.q[:, elastic_coordinates(solution, body)])
        instants = instants_of(solution, body)
        grown = law.measures(elastic[instants])[1]
        worst = first_largest(grown)
        parts.append((float(grown[worst]), int(instants[worst])))
    part, n = max(parts, default=(0.0, 0))
    return n if part > (FELT_BY_GRADIENTS if solution.dq.shape[2] else FELT) else None


def _low(solution: Solution, known: Mapping[str, PulledBody], n: int, asked: Mapping[str, JointForce]) -> dict[str, Lacking]:
    """Joint forces that responses lack at one state, by name."""
    state = stiffened_state(solution, known, n) if asked else None
    if state is None or not np.any(state.growing):
        return {}
    more = np.array(solution.multipliers)
    more[n] = more[n] + state.yields.multipliers(state.growing)
    pulled, found = replace(solution, multipliers=more), dict[str, Lacking]()
    steps = np.unique(np.linspace(0, len(solution.times) - 1, LOOKED_AT).astype(int))
    held = HARDLY * float(np.abs(np.real(solution.multipliers[n])).max(initial=0.0))
    for name, response in asked.items():
        here, there = (float(np.real(response.at(each, n).value)) for each in (solution, pulled))
        size = max([abs(here), *(abs(float(np.real(response.at(solution, int(k)).value))) for k in steps)])
        found[name] = Lacking(there - here, size, max(size, held))
    return found
