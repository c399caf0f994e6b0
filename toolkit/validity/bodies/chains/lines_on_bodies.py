"""Joints along a straight line that lies on a flexible body: what they would do along the deformed body.

The line goes through the joint's point on the body, along its axis there. A block that is led along the body for real stays on the deformed
body and loads it where it is; the joint has it on the tangent, and loads the body at the joint's point over a rigid arm. The difference is
one Newton step to a joint at the material point X of the body beside the block, with the normals n of the line:

    [K  J_X^T; J_X  0] [dq; dlambda] = -[(J_X - J)^T lambda; n . (r_a - r_X)],   J_X = n . (d r_a / dq - d r_X / dq)

with K of an equilibrium; of a motion K + M / T^2, T its length, so that what is free to move has an answer, too.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.spread import spread
from toolkit.foundation.verdict import Caution
from toolkit.responses.instant import Instant
from toolkit.responses.response import Response
from toolkit.scene.scene import Scene
from toolkit.solvers.static.equilibrium import LEVELS, static_matrix
from toolkit.system.marker_states import marker_states
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.known_chain import chain

NORMALS = {2: ("normal",), 3: ("first normal", "second normal")}
"""Names of the rows, by the dimension, that keep a point on a line of body b; they are a joint's first."""
BESIDE = 0.01
"""Of the body's length: a line that is further from the undeformed body than this is a rail beside it, and no line on it."""
LIMIT = 0.05
"""Of a response, from which on its change is told: as much as bodies may be deformed beyond what is linear."""
STEPS = 20
"""So many instants of a motion are looked at for the largest value of a response, and so many that one is made of."""


@dataclass(frozen=True)
class Line:
    """A line on a flexible body that a joint leads a point along."""

    joint: Any
    name: str
    markers: tuple[int, int]
    row: int
    body: str
    chain: Chain


@dataclass(frozen=True)
class Beside:
    """What the deformed body in the place of its tangent changes in one state."""

    travel: float  # from the joint's point on the body
    gap: float  # of the body from its tangent there
    change: np.ndarray  # (n,) of coordinates and multipliers


def lines_on_bodies(solution: Solution) -> Iterator[Caution]:
    """A doubt for every response that the deformed body would change by more than a part of it."""
    responses: Mapping[str, Any] = solution.system.scene.responses
    for line in _lines(solution):
        known: dict[int, Beside | None] = {}
        worst, told = 0.0, ""
        for name, response in responses.items():
            if response.needs_rest or (response.needs_motion and not solution.steps):
                continue
            value, change = _changed(solution, line, response, known)
            size = max(abs(value), _largest(solution, response)) if change else 0.0
            part = abs(change) / size if size > 0 else 0.0
            if part > max(LIMIT, worst):
                worst, told = part, f"{name} would be about {value + change:.3g} instead of {value:.3g}"
        if told:
            yield Caution("line-on-flexible-body", _words(line, known, told))


def _words(line: Line, known: dict[int, Beside | None], told: str) -> str:
    far = max((each for each in known.values() if each is not None), key=lambda each: each.gap + abs(each.travel) * 1e-9)
    return (
        f"joints.{line.name} leads its point along the tangent of {line.body} at the joint's point, {abs(far.travel):.3g} away from there, "
        f"where the body itself is {far.gap:.2g} beside it, and loads the body at the joint's point alone: along the deformed body {told}. "
        "Its derivatives are off as much. Fix: put the joint's point where on the body its partner stands, or make the rail a body that is "
        "stiff; no joint follows a body that bends."
    )


def _lines(solution: Solution) -> Iterator[Line]:
    """All of a scene, on bodies whose finite elements are known."""
    system, scene = solution.system, solution.system.placed
    names = NORMALS[scene.dimension]
    for number, (name, joint) in enumerate(scene.joints.items()):
        written = scene.bodies.get(joint.bodies[1])
        if not isinstance(written, ModelBody) or tuple(joint.row_names[: len(names)]) != names:
            continue
        first, second = system.plan.joints.marker[number].tolist()
        body = scene.piece(*system.numbering.markers[second][:2])
        found = chain(scene, body)
        if found is not None:
            yield Line(joint, name, (first, second), int(system.plan.joints.row[number]), body, found)


def _changed(solution: Solution, line: Line, response: Response, known: dict[int, Beside | None]) -> tuple[float, float]:
    """A response's value, and what is to be added to it along the deformed body."""
    partials, n_q = response.partials(solution), solution.system.n_q
    slopes = [each for each in (partials.q, partials.multipliers) if each is not None]
    felt = np.flatnonzero(np.any([np.nan_to_num(each).any(axis=1) for each in slopes], axis=0)) if slopes else np.zeros(0, int)
    chosen = felt[spread(len(felt) - 1, STEPS)] if len(felt) else felt
    total = 0.0
    for k in chosen.tolist():
        if k not in known:
            known[k] = beside(solution, line, k)
        found = known[k]
        if found is not None:
            total += 0.0 if partials.q is None else float(np.real(partials.q[k] @ found.change[:n_q]))
            total += 0.0 if partials.multipliers is None else float(np.real(partials.multipliers[k] @ found.change[n_q:]))
    return float(np.real(partials.value)), total * len(felt) / max(len(chosen), 1)


def _largest(solution: Solution, response: Response) -> float:
    """Of a response at one time, at any time of the motion."""
    if not (solution.steps and isinstance(response, Instant)):
        return 0.0
    return max(abs(float(np.real(response.at(solution, k).value))) for k in spread(len(solution.times) - 1, STEPS))


def beside(solution: Solution, line: Line, instant: int) -> Beside | None:
    """What the body beside the block changes; None if the block is beyond the body, or the line is not on it."""
    system, q = solution.system, np.real(solution.q[instant])
    d, (a, b) = system.scene.dimension, line.markers
    state = marker_states(system, q)
    poses, places = np.real(state.y), _jacobian(system, state, a, d)
    normals = _normals(line, poses[b])
    travel = float(_along(normals) @ (poses[a, :d] - poses[b, :d]))
    under = _under(solution, line, q, poses[b], travel)
    if under is None:
        return None
    place, slope = _material(solution, line, q, under)
    gap = normals @ (poses[a, :d] - place)
    return Beside(travel, float(np.sqrt(gap @ gap)), _step(solution, line, instant, normals @ (places - slope), gap))


def _normals(line: Line, pose: np.ndarray) -> np.ndarray:
    """Normals of the line (d - 1, d), as the joint's rows have them, by the pose of its point on the body."""
    if len(pose) > 3:
        return pose[3:9].reshape(2, 3)
    x, y = np.array(line.joint.axis, float) / np.hypot(*line.joint.axis)
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.array([[-s * x - c * y, c * x - s * y]])


def _along(normals: np.ndarray) -> np.ndarray:
    """Unit vector along the line, (d,)."""
    if len(normals) == 1:
        return np.array([normals[0, 1], -normals[0, 0]])
    found: np.ndarray = np.cross(normals[0], normals[1])
    return found


def _jacobian(system: Any, state: Any, marker: int, d: int) -> np.ndarray:
    """d r / dq of a marker, (d, n_q)."""
    columns = slice(system.plan.markers.start[marker], system.plan.markers.start[marker + 1])
    found: np.ndarray = np.zeros((d, system.n_q))
    found[:, system.plan.markers.coordinate[columns]] = np.real(state.B[columns, :d]).T
    return found


def _under(
    solution: Solution, line: Line, q: np.ndarray, pose: np.ndarray, travel: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """Undeformed place in the body, and displacement per elastic coordinate, of what is beside the block; None if nothing is."""
    nodes, shapes = line.chain.nodes, _shapes(line)
    along, d = _along(_normals(line, pose)), len(nodes[0])
    here = np.array(
        [
            _place(solution.system.placed, line, _own(solution, line, q), node, shape)
            for node, shape in zip(nodes, shapes, strict=True)
        ]
    )
    ways = (here - pose[:d]) @ along
    for i, j in _connectivity(line):
        if min(ways[i], ways[j]) <= travel <= max(ways[i], ways[j]) and ways[i] != ways[j]:
            ratio = (travel - ways[i]) / (ways[j] - ways[i])
            place = (1 - ratio) * nodes[i] + ratio * nodes[j]
            if _lies_on(solution, line, place):
                return place, (1 - ratio) * shapes[i] + ratio * shapes[j]
    return None


def _lies_on(solution: Solution, line: Line, place: np.ndarray) -> bool:
    """Whether a place of the undeformed body is on the line there."""
    system = solution.system
    rest = np.real(system.undeformed()[0][: system.n_q])
    pose = np.real(marker_states(system, rest).y[line.markers[1]])
    shape = np.zeros_like(_shapes(line)[0])
    way = _place(system.scene, line, _own(solution, line, rest), place, shape) - pose[: len(place)]
    size = np.ptp(line.chain.nodes, axis=0).max()
    return bool(np.abs(_normals(line, pose) @ way).max() <= BESIDE * size)


def _shapes(line: Line) -> np.ndarray:
    """Displacements of all nodes per elastic coordinate, (n_nodes, d, n_f)."""
    nodes = line.chain.nodes
    found: np.ndarray = np.real(line.chain.shapes).reshape(len(nodes), line.chain.per_node, -1)[:, : nodes.shape[1]]
    return found


def _connectivity(line: Line) -> list[list[int]]:
    """Nodes of every element."""
    of: Any = line.chain
    found: list[list[int]] = (of.connectivity if len(of.nodes[0]) == 3 else of.elements.connectivity).tolist()
    return found


def _own(solution: Solution, line: Line, q: np.ndarray) -> np.ndarray:
    return q[solution.coordinates(line.body)]


def _place(scene: Scene, line: Line, own: np.ndarray, place: np.ndarray, shape: np.ndarray) -> np.ndarray:
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
        found[:, where.start + k] = np.imag(_place(solution.system.placed, line, moved, *under)) / 1e-30
    return np.real(_place(solution.system.placed, line, own, *under)), found


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
