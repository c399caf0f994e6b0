"""Deflection of reduced parts by the forces of a run in shapes that were left out.

The full scene is put into the states of the run, where its equations are not in balance, inertia included. What is left of the forces would
move the parts by delta (see `full_scene`): their part in the motion as long as none of these shapes vibrates.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from toolkit.equations.equations import Inputs
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.reduced_model.cut.part import Part
from toolkit.system.flexible_bodies import elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.cut.places import STRAIGHT, largest_displacement, undeformed_places
from toolkit.validity.bodies.deformation import LIMIT
from toolkit.validity.bodies.reduced.full_scene import FullScene, ReducedPart, full_scene_of

INSTANTS = 50
"""Number of states of a run that are examined, equally far apart."""


@dataclass(frozen=True)
class LeftOut:
    """Largest displacement and stress, at any of the instants, that the left-out shapes of one body would add."""

    displacement: float  # of a node, in parts of the largest displacement of the body
    stress: float  # in parts of its largest stress


def left_out_shapes(solution: Solution) -> dict[str, LeftOut]:
    """Displacement and stress that every body lacks whose parts do not keep all coordinates, by name."""
    if LeftOut not in solution.known:
        full = full_scene_of(solution)
        forces = np.zeros(0) if full is None else _unbalanced(solution, full)
        parts = {} if full is None else full.parts
        solution.known[LeftOut] = {name: _of_body(solution, name, [*own.values()], forces) for name, own in parts.items()}
    found: dict[str, LeftOut] = solution.known[LeftOut]
    return found


@check("left-out-shapes", STATES)
def shapes_missed(solution: Solution) -> Iterator[Caution]:
    """Doubts about bodies whose parts keep too few shapes."""
    for name, found in left_out_shapes(solution).items():
        if not max(found.displacement, found.stress) <= LIMIT:
            modes = solution.system.scene.bodies[name].modes_per_frame  # type: ignore[attr-defined]
            yield shapes_missed.caution(
                f"the parts of {name} keep {modes} {'mode' if modes == 1 else 'modes'} each: those that were left out would move it by "
                f"{found.displacement:.1%} of its largest displacement and change its stress by {found.stress:.1%} of the largest (limit "
                f"{LIMIT:.0%}). Write a larger bodies.{name}.modes_per_frame, or leave it out to keep all coordinates.",
            )


def shapes_measured(solution: Solution) -> dict[str, Any]:
    """Body -> displacement and stress that its parts lack, as a record."""
    return {name: asdict(each) for name, each in left_out_shapes(solution).items()}


def _unbalanced(solution: Solution, full: FullScene) -> np.ndarray:
    """Residual forces at the coordinates of the full scene in states of the run, (n_t, n_q)."""
    n = np.unique(np.linspace(0, len(solution.times) - 1, INSTANTS).round().astype(int))
    system, n_q = full.system, full.system.n_q
    states: np.ndarray = np.zeros((3, len(n), system.n))
    for state, known in zip(states, (solution.q, solution.v, solution.a), strict=True):
        state[:, :n_q] = known[n] @ full.expanded.T
    states[2, :, n_q:] = solution.multipliers[n]
    inertia = not (solution.options or solution.system.scene.solver).quasi_static
    curves, curves_x = system.curves(solution.times[n])
    left = np.zeros((len(n), n_q))
    for k, (q, v, acc) in enumerate(zip(*states, strict=True)):
        terms = system.evaluate(Inputs(curves[k], curves_x[k], 1.0, np.zeros(3), inertia, False), q, v, acc, linearize=False)
        left[k] = (terms.inertial + terms.applied)[:n_q]
    return left


def _of_body(solution: Solution, name: str, parts: list[ReducedPart], forces: np.ndarray) -> LeftOut:
    scene = solution.system.scene
    body: Any = scene.bodies[name]
    moved = [(each.part, each.moved(forces[:, each.rows])) for each in parts]
    displacement, size = largest_displacement(solution, name), np.ptp(undeformed_places(scene, name), axis=0).max()
    away = max(_farthest(part, elastic) for part, elastic in moved)
    stress = _largest_stress(body.stress_operator(scene), solution.q[:, elastic_coordinates(solution, name)])
    changed = max(_largest_stress(part.invariants.stress_operator, elastic) for part, elastic in moved)
    return LeftOut(away / displacement if displacement > STRAIGHT * size else 0.0, changed / stress if stress > 0 else 0.0)


def _farthest(part: Part, elastic: np.ndarray) -> float:
    """Largest displacement of a node by elastic coordinates (n_t, n_f)."""
    moves = (elastic @ part.recovery[:, 1:].T).reshape(len(elastic), -1, part.per_node)[:, :, : part.nodes.shape[1]]
    return float(np.sqrt((moves * moves).sum(axis=2)).max())


def _largest_stress(operator: np.ndarray, elastic: np.ndarray) -> float:
    """Largest stress by elastic coordinates (n_t, n_f)."""
    return float(np.abs(elastic @ operator.reshape(-1, operator.shape[-1]).T).max(initial=0.0))
