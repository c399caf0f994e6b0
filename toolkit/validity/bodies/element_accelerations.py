"""What pulls at the middles of a body's elements, per mass: weight and forces of inertia, in the axes of its frame.

    A^T (g - r'') - alpha x p - omega x (omega x p) - 2 omega x p' - p'',    p = X + (u_1 + u_2) / 2 + l / 8 (phi_1 - phi_2) x e

with displacements u and rotations phi of an element's ends, as its shape functions have it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.sides import Sides, sides_of
from toolkit.validity.bodies.cut.joined_errors import in_space

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
