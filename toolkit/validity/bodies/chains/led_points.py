"""Joints that lead a point along a line or in a plane on a flexible body, and what the deformed body in its place would change.

The line goes through the joint's point on the body, along its axis there. A block that is led along the body for real stays on the deformed
body and loads it where it is; the joint has it on the tangent, and loads the body at the joint's point over a rigid arm. The difference is
one Newton step to a joint at the material point X of the body beside the block, with the normals n and the offsets c of the joint's rows:

    [K  J_X^T; J_X  0] [dq; dlambda] = -[(J_X - J)^T lambda; n . (r_a - r_X) - c],   J_X = n . (d r_a / dq - d r_X / dq)

with K of an equilibrium; of a motion K + M / T^2, T its length, so that what is free to move has an answer, too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import takewhile
from typing import Any

import numpy as np
import scipy

from toolkit.bodies.model_body import ModelBody
from toolkit.scene.resolution import ResolvedScene
from toolkit.solvers.static.equilibrium import LEVELS, static_matrix
from toolkit.system.marker_states import marker_states
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.known_chain import chain

AXES = {
    2: {"normal": 1, "contact": 1, "axis": 0},
    3: {"first normal": 0, "second normal": 1, "normal": 2, "axis": 2},
}
"""Dimension -> name of a row that holds a point of body a at an offset along an axis of body b -> which of the joint's axes: of sliders,
rolling discs and position drivers, and in space of prismatic and cylindrical joints, points on planes and position drivers. They are a
joint's first."""
NOTHING = 1e-9
"""Part of the model size by which a block that stands at the joint's point may be off it."""
BESIDE = 0.01
"""Of the body's length: a line that is further from the undeformed body than this is a rail beside it, and no line on it."""


@dataclass(frozen=True)
class Line:
    """A line or plane on a flexible body that a joint leads a point along."""

    joint: Any
    name: str
    markers: tuple[int, int]
    row: int
    axes: tuple[int, ...]  # along which the joint holds the point
    body: str
    chain: Chain


@dataclass(frozen=True)
class Beside:
    """What the deformed body in the place of its tangent changes in one state."""

    travel: float  # from the joint's point on the body
    gap: float  # of the body from its tangent there
    rows: np.ndarray  # J_X (n, n_q)
    change: np.ndarray  # (n,) of coordinates and multipliers


def lines(solution: Solution) -> Iterator[Line]:
    """All of a scene, on bodies whose finite elements are known."""
    system, scene = solution.system, solution.system.scene
    known = AXES[scene.dimension]
    for number, (name, joint) in enumerate(scene.joints.items()):
        axes = tuple(known[row] for row in takewhile(known.__contains__, joint.row_names))
        if not axes or not isinstance(scene.bodies.get(joint.bodies[1]), ModelBody):
            continue
        first, second = system.plan.joints.marker[number].tolist()
        body = scene.piece(*system.numbering.markers[second][:2])
        found = chain(scene, body)
        if found is not None:
            yield Line(joint, name, (first, second), int(system.plan.joints.row[number]), axes, body, found)


def beside(solution: Solution, line: Line, instant: int) -> Beside | None:
    """What the body beside the block changes; None if the block is at the joint's point or beyond the body, or the line is not on it."""
    system, q = solution.system, np.real(solution.q[instant])
    d, (a, b) = system.scene.dimension, line.markers
    state = marker_states(system, q)
    poses, places = np.real(state.y), _jacobian(system, state, a, d)
    normals, away = _axes(line, poses[b])[list(line.axes)], poses[a, :d] - poses[b, :d]
    offset = normals @ away  # zero, a radius, or what a driver leads to
    way = away - offset @ normals
    travel = float(np.sqrt(way @ way))
    under = _under(solution, line, q, poses[b], way / travel, travel) if travel > NOTHING * system.scene.size else None
    if under is None:
        return None
    place, slope = _material(solution, line, q, under)
    gap, rows = normals @ (poses[a, :d] - place) - offset, normals @ (places - slope)
    return Beside(travel, float(np.sqrt(gap @ gap)), rows, _step(solution, line, instant, rows, gap))


def _axes(line: Line, pose: np.ndarray) -> np.ndarray:
    """The joint's axes (d, d), one a row, by the pose of its point on the body."""
    if len(pose) > 3:
        return pose[3:12].reshape(3, 3)
    x, y = np.array(line.joint.axis, float) / np.hypot(*line.joint.axis)
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.array([[c * x - s * y, s * x + c * y], [-s * x - c * y, c * x - s * y]])


def _jacobian(system: Any, state: Any, marker: int, d: int) -> np.ndarray:
    """d r / dq of a marker, (d, n_q)."""
    columns = slice(system.plan.markers.start[marker], system.plan.markers.start[marker + 1])
    found: np.ndarray = np.zeros((d, system.n_q))
    found[:, system.plan.markers.coordinate[columns]] = np.real(state.B[columns, :d]).T
    return found


def _under(
    solution: Solution, line: Line, q: np.ndarray, pose: np.ndarray, along: np.ndarray, travel: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """Undeformed place in the body, and displacement per elastic coordinate, of what is beside the block; None if nothing is."""
    nodes, shapes, d = line.chain.nodes, _shapes(line), len(along)
    here = np.array(
        [
            _place(solution.system.scene, line, _own(solution, line, q), node, shape)
            for node, shape in zip(nodes, shapes, strict=True)
        ]
    )
    ways = (here - pose[:d]) @ along
    for i, j in _connectivity(line):
        if min(ways[i], ways[j]) <= travel <= max(ways[i], ways[j]) and ways[i] != ways[j]:
            ratio = (travel - ways[i]) / (ways[j] - ways[i])
            place = (1 - ratio) * nodes[i] + ratio * nodes[j]
            if _lies_on(solution, line, place, _axes(line, pose) @ along):
                return place, (1 - ratio) * shapes[i] + ratio * shapes[j]
    return None


def _lies_on(solution: Solution, line: Line, place: np.ndarray, along: np.ndarray) -> bool:
    """Whether a place of the undeformed body is on the line from the joint's point along a direction in the joint's axes."""
    system = solution.system
    rest = np.real(system.undeformed()[0][: system.n_q])
    pose = np.real(marker_states(system, rest).y[line.markers[1]])
    shape = np.zeros_like(_shapes(line)[0])
    way = _place(system.scene, line, _own(solution, line, rest), place, shape) - pose[: len(place)]
    size, own = np.ptp(line.chain.nodes, axis=0).max(), _axes(line, pose) @ way
    return bool(np.abs(own - (own @ along) * along).max() <= BESIDE * size)


def _shapes(line: Line) -> np.ndarray:
    """Displacements of all nodes per elastic coordinate, (n_nodes, d, n_f)."""
    nodes = line.chain.nodes
    found: np.ndarray = np.real(line.chain.shapes).reshape(len(nodes), line.chain.per_node, -1)[:, : nodes.shape[1]]
    return found


def _connectivity(line: Line) -> list[list[int]]:
    """Nodes of every element."""
    of: Any = line.chain
    found: list[list[int]] = of.connectivity.tolist()
    return found


def _own(solution: Solution, line: Line, q: np.ndarray) -> np.ndarray:
    return q[solution.coordinates(line.body)]


def _place(scene: ResolvedScene, line: Line, own: np.ndarray, place: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Where a point of the body is, (d,), by the body's coordinates, real or complex."""
    body: Any = scene.body(line.body)
    origin = own[: body.moves] if body.moves else np.array(body.position)
    axes = body.frame_axes(own) if body.turns else body.placement
    found: np.ndarray = origin + axes @ (place + shape @ own[body.frame_size :])
    return found


def _material(
    solution: Solution, line: Line, q: np.ndarray, under: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Where that point is (d,), and its derivative by all coordinates (d, n_q)."""
    where, own = solution.coordinates(line.body), _own(solution, line, q)
    found: np.ndarray = np.zeros((len(under[0]), len(q)))
    for k in range(len(own)):
        moved = own.astype(complex)
        moved[k] += 1e-30j
        found[:, where.start + k] = np.imag(_place(solution.system.scene, line, moved, *under)) / 1e-30
    return np.real(_place(solution.system.scene, line, own, *under)), found


def _step(solution: Solution, line: Line, instant: int, new: np.ndarray, gap: np.ndarray) -> np.ndarray:
    """The step at the head of this file, (n,)."""
    system = solution.system
    n, n_q, rows = system.n, system.n_q, line.row + np.arange(len(new))
    q, acc = np.zeros(n), np.zeros(n)
    q[:n_q], acc[n_q:] = np.real(solution.q[instant]), np.real(solution.multipliers[instant])
    terms = system.evaluate(system.inputs(solution.times[instant], LEVELS), q, np.zeros(n), acc)
    mass = system.matrix(terms.I_acc).tolil()
    mass[n_q:], mass[:, n_q:] = 0, 0
    left = np.zeros(n)
    old = system.matrix(terms.I_acc).tocsc()[:n_q, rows].toarray().T
    left[:n_q], left[rows] = (new - old).T @ acc[rows], gap
    duration = float(solution.times[-1] - solution.times[0])
    whole = (system.matrix(static_matrix(system, terms)) + (mass / duration**2 if solution.steps else 0 * mass)).tolil()
    whole[rows, :n_q], whole[:n_q, rows] = new, new.T
    found: np.ndarray = scipy.sparse.linalg.spsolve(whole.tocsc(), -left)
    return found
