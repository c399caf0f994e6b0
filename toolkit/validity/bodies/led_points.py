"""Joints that lead a point along a line or in a plane on a flexible body, and the answers that its deformation falsifies.

Joints that lead a point along a line or in a plane on a flexible body, and what the deformed body in its place would change.

The line goes through the joint's point on the body, along its axis there. A block that is led along the body for real stays on the deformed
body and loads it where it is; the joint has it on the tangent, and loads the body at the joint's point over a rigid arm. The difference is
one Newton step to a joint at the material point X of the body beside the block, with the normals n and the offsets c of the joint's rows:

    [K  J_X^T; J_X  0] [dq; dlambda] = -[(J_X - J)^T lambda; n . (r_a - r_X) - c],   J_X = n . (d r_a / dq - d r_X / dq)

with K of an equilibrium; of a motion K + M / T^2, T its length, so that what is free to move has an answer, too.

Responses of an equilibrium are asked of the changed state, those of a motion by their derivatives or, of stress, in some changed states.
Frequencies are those with the joint's rows at the body beside the block.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import takewhile
from typing import Any

import numpy as np
import scipy

from toolkit.components.bodies.model_body import ModelBody
from toolkit.components.markers.planar import MarkerState
from toolkit.components.markers.spatial import SpatialMarkerState
from toolkit.foundation.near_ties import spread
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.responses.least_frequency import LeastFrequency, LoadMargin
from toolkit.responses.pencil import Pencil, free_pencil, pencil_of, real_pencil
from toolkit.responses.response import Instant, Response
from toolkit.responses.stress import StressResponse
from toolkit.responses.vibration import Frequency, OfVibration
from toolkit.scene.resolution import ResolvedScene
from toolkit.solvers.free_motions import undamped_rates
from toolkit.solvers.static.equilibrium import LEVELS, static_matrix
from toolkit.system.solution import Solution, marker_states
from toolkit.system.system import System
from toolkit.validity.bodies.chain import Chain
from toolkit.validity.bodies.known_chain import chain

AXES = {
    2: {"normal": 1, "contact": 1, "axis": 0},
    3: {"first normal": 0, "second normal": 1, "normal": 2, "axis": 2},
}
"""Dimension -> name of a row that holds a point of body a at an offset along an axis of body b -> which of the joint's axes: of sliders,
rolling discs and position drivers, and in space of prismatic and cylindrical joints, points on planes and position drivers. They are a
joint's first."""
JOINT_POINT_DISTANCE = 1e-9
"""Part of the model size by which a block that stands at the joint's point may be off it."""
RAIL_DISTANCE = 0.01
"""Of the body's length: a line that is further from the undeformed body than this is a rail beside it, and no line on it."""


@dataclass(frozen=True)
class GuideLine:
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


def lines(solution: Solution) -> Iterator[GuideLine]:
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
            yield GuideLine(joint, name, (first, second), int(system.plan.joints.row[number]), axes, body, found)


def beside(solution: Solution, line: GuideLine, instant: int) -> Beside | None:
    """What the body beside the block changes; None if the block is at the joint's point or beyond the body, or the line is not on it."""
    system, q = solution.system, np.real(solution.q[instant])
    d, (a, b) = system.scene.dimension, line.markers
    state = marker_states(system, q)
    poses, places = np.real(state.y), _jacobian(system, state, a, d)
    normals, away = _axes(line, poses[b])[list(line.axes)], poses[a, :d] - poses[b, :d]
    offset = normals @ away  # zero, a radius, or what a driver leads to
    way = away - offset @ normals
    travel = float(np.sqrt(way @ way))
    under = (
        _under(solution, line, q, poses[b], way / travel, travel) if travel > JOINT_POINT_DISTANCE * system.scene.size else None
    )
    if under is None:
        return None
    place, slope = _material(solution, line, q, under)
    gap, rows = normals @ (poses[a, :d] - place) - offset, normals @ (places - slope)
    return Beside(travel, float(np.sqrt(gap @ gap)), rows, _step(solution, line, instant, rows, gap))


def _axes(line: GuideLine, pose: np.ndarray) -> np.ndarray:
    """The joint's axes (d, d), one a row, by the pose of its point on the body."""
    if len(pose) > 3:
        return pose[3:12].reshape(3, 3)
    x, y = np.array(line.joint.axis, float) / np.hypot(*line.joint.axis)
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.array([[c * x - s * y, s * x + c * y], [-s * x - c * y, c * x - s * y]])


def _jacobian(system: System, state: MarkerState | SpatialMarkerState, marker: int, d: int) -> np.ndarray:
    """d r / dq of a marker, (d, n_q)."""
    columns = slice(system.plan.markers.start[marker], system.plan.markers.start[marker + 1])
    found: np.ndarray = np.zeros((d, system.n_q))
    found[:, system.plan.markers.coordinate[columns]] = np.real(state.B[columns, :d]).T
    return found


def _under(
    solution: Solution, line: GuideLine, q: np.ndarray, pose: np.ndarray, along: np.ndarray, travel: float
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


def _lies_on(solution: Solution, line: GuideLine, place: np.ndarray, along: np.ndarray) -> bool:
    """Whether a place of the undeformed body is on the line from the joint's point along a direction in the joint's axes."""
    system = solution.system
    rest = np.real(system.undeformed()[0][: system.n_q])
    pose = np.real(marker_states(system, rest).y[line.markers[1]])
    shape = np.zeros_like(_shapes(line)[0])
    way = _place(system.scene, line, _own(solution, line, rest), place, shape) - pose[: len(place)]
    size, own = np.ptp(line.chain.nodes, axis=0).max(), _axes(line, pose) @ way
    return bool(np.abs(own - (own @ along) * along).max() <= RAIL_DISTANCE * size)


def _shapes(line: GuideLine) -> np.ndarray:
    """Displacements of all nodes per elastic coordinate, (n_nodes, d, n_f)."""
    nodes = line.chain.nodes
    found: np.ndarray = np.real(line.chain.shapes).reshape(len(nodes), line.chain.per_node, -1)[:, : nodes.shape[1]]
    return found


def _connectivity(line: GuideLine) -> list[list[int]]:
    """Nodes of every element."""
    of: Any = line.chain
    found: list[list[int]] = of.connectivity.tolist()
    return found


def _own(solution: Solution, line: GuideLine, q: np.ndarray) -> np.ndarray:
    return q[solution.coordinates(line.body)]


def _place(scene: ResolvedScene, line: GuideLine, own: np.ndarray, place: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Where a point of the body is, (d,), by the body's coordinates, real or complex."""
    body: Any = scene.body(line.body)
    origin = own[: body.moves] if body.moves else np.array(body.position)
    axes = body.frame_axes(own) if body.turns else body.placement
    found: np.ndarray = origin + axes @ (place + shape @ own[body.frame_size :])
    return found


def _material(
    solution: Solution, line: GuideLine, q: np.ndarray, under: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Where that point is (d,), and its derivative by all coordinates (d, n_q)."""
    where, own = solution.coordinates(line.body), _own(solution, line, q)
    found: np.ndarray = np.zeros((len(under[0]), len(q)))
    for k in range(len(own)):
        moved = own.astype(complex)
        moved[k] += 1e-30j
        found[:, where.start + k] = np.imag(_place(solution.system.scene, line, moved, *under)) / 1e-30
    return np.real(_place(solution.system.scene, line, own, *under)), found


def _step(solution: Solution, line: GuideLine, instant: int, new: np.ndarray, gap: np.ndarray) -> np.ndarray:
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


LIMIT = 0.05
"""Relative change of a response above which there is a doubt: as much as bodies may be deformed beyond what is linear."""
EXAMINED_INSTANTS = 20
"""Number of instants at which the largest value of a response is sought, and of those at which its change is evaluated."""

Known = dict[int, Beside | None]
"""Instant -> the deformed body beside a line's block."""


def asked_vibrations(solution: Solution) -> dict[str, int]:
    """Responses that ask for a vibration -> its number from the slowest on."""
    found = {name: each for name, each in solution.system.scene.responses.items() if isinstance(each, Frequency | LeastFrequency)}
    return {name: getattr(each, "number", 1) for name, each in found.items() if not (solution.steps and each.needs_rest)}


@check("line-on-flexible-body", STATES)
def lines_on_bodies(solution: Solution, vibrations: Mapping[str, int] | None = None, values: bool = True) -> Iterator[Caution]:
    """A joint leads its point along the straight tangent of a flexible body, or in a plane there, and loads the body where the joint is;
    along the deformed body a response or a frequency would be another number, which is told.

    Limit: 5 % of the response, in a motion of its largest value.
    Fix: the joint's point where its partner stands, or a stiff body of its own as the rail.

    Parameters
    ----------
    vibrations
        Those about the last state, by what they are called, and their numbers from the slowest on; by default those of responses.
    values
        Whether the other responses are looked at, too.
    """
    vibrations = asked_vibrations(solution) if vibrations is None else vibrations
    for line in lines(solution):
        known: Known = {}
        told = _worst(_changes(solution, line, known)) if values else ""
        told = told or _worst(_of_vibrations(solution, line, vibrations, known))
        if told:
            yield lines_on_bodies.caution(_words(line, known, told))


def _worst(changes: Iterator[tuple[str, float, float, float]]) -> str:
    """A phrase on the answer that changes most, from name, value, change, and scale of the change; empty where none does."""
    worst, told = LIMIT, ""
    for name, value, change, size in changes:
        part = abs(change) / size if size > 0 else 0.0
        if part > worst:
            worst, told = part, f"{name} would be about {value + change:.3g} instead of {value:.3g}"
    return told


def _words(line: GuideLine, known: Known, told: str) -> str:
    far = max((each for each in known.values() if each is not None), key=lambda each: each.gap + abs(each.travel) * 1e-9)
    where = f", where the body itself is {far.gap:.2g} beside it," if far.gap > 1e-9 * far.travel else ""
    return (
        f"joints.{line.name} leads its point along the tangent of {line.body} at the joint's point, {far.travel:.3g} away from there"
        f"{where} and loads the body at the joint's point alone. Along the deformed body {told}. "
        "Its derivatives are off as much. Fix: put the joint's point where on the body its partner stands, or make the rail a stiff body; "
        "no joint follows a body that bends."
    )


def _changes(solution: Solution, line: GuideLine, known: Known) -> Iterator[tuple[str, float, float, float]]:
    """Name, value, change and scale of all responses but those of vibrations."""
    responses: Mapping[str, Any] = solution.system.scene.responses
    for name, response in responses.items():
        left_out = (response.needs_rest and solution.steps) or (response.needs_motion and not solution.steps)
        if left_out or isinstance(response, OfVibration | LeastFrequency | LoadMargin):
            continue
        if not solution.steps:
            value, change = _at_rest(solution, line, response, known)
        elif isinstance(response, StressResponse):
            value, change = _of_stress(solution, line, response, known)
        else:
            value, change = _changed(solution, line, response, known)
        yield name, value, change, max(abs(value), _largest(solution, response)) if change else 0.0


def _found(solution: Solution, line: GuideLine, known: Known, instant: int) -> Beside | None:
    if instant not in known:
        known[instant] = beside(solution, line, instant)
    return known[instant]


def _at_rest(solution: Solution, line: GuideLine, response: Response, known: Known) -> tuple[float, float]:
    """Value of a response of an equilibrium, and its change along the deformed body."""
    value, found = float(np.real(response.value(solution))), _found(solution, line, known, 0)
    if found is None:
        return value, 0.0
    return value, float(np.real(response.value(_moved(solution, [0], found.change[None])))) - value


def _moved(solution: Solution, instants: list[int], change: np.ndarray) -> Solution:
    """States at some instants with changes (n_t, n) of their coordinates and multipliers."""
    n_q = solution.system.n_q
    names = ("times", "v", "a", "dq", "dv", "da", "dmultipliers")
    kept = {name: getattr(solution, name)[instants] for name in names}
    q, multipliers = solution.q[instants] + change[:, :n_q], solution.multipliers[instants] + change[:, n_q:]
    return replace(solution, **kept, q=q, multipliers=multipliers)


def _of_stress(solution: Solution, line: GuideLine, response: StressResponse, known: Known) -> tuple[float, float]:
    """Value of a largest stress of a motion, and its change along the deformed body, by some instants."""
    last = len(solution.times) - 1
    instants = [last] if response.when == "end" else spread(last, EXAMINED_INSTANTS)
    none = np.zeros(solution.system.n)
    found = [_found(solution, line, known, k) for k in instants]
    changes = np.array([none if each is None else each.change for each in found])
    before, after = (float(np.real(response.value(_moved(solution, instants, each)))) for each in (0 * changes, changes))
    return float(np.real(response.value(solution))), after - before


def _changed(solution: Solution, line: GuideLine, response: Response, known: Known) -> tuple[float, float]:
    """Value of any response of a motion, and its change along the deformed body, by its derivatives."""
    partials, n_q = response.partials(solution), solution.system.n_q
    slopes = [each for each in (partials.q, partials.multipliers) if each is not None]
    felt = np.flatnonzero(np.any([np.nan_to_num(each).any(axis=1) for each in slopes], axis=0)) if slopes else np.zeros(0, int)
    chosen = felt[spread(len(felt) - 1, EXAMINED_INSTANTS)] if len(felt) else felt
    total = 0.0
    for k in chosen.tolist():
        found = _found(solution, line, known, k)
        if found is not None:
            total += 0.0 if partials.q is None else float(np.real(partials.q[k] @ found.change[:n_q]))
            total += 0.0 if partials.multipliers is None else float(np.real(partials.multipliers[k] @ found.change[n_q:]))
    return float(np.real(partials.value)), total * len(felt) / max(len(chosen), 1)


def _largest(solution: Solution, response: Response) -> float:
    """Largest magnitude of a response at one time over the motion; zero of other responses."""
    if not (solution.steps and isinstance(response, Instant)):
        return 0.0
    return max(abs(float(np.real(response.at(solution, k).value))) for k in spread(len(solution.times) - 1, EXAMINED_INSTANTS))


def _of_vibrations(
    solution: Solution, line: GuideLine, asked: Mapping[str, int], known: Known
) -> Iterator[tuple[str, float, float, float]]:
    """Name, value, change and scale of frequencies about the last state, in cycles per time."""
    found = _found(solution, line, known, len(solution.times) - 1) if asked else None
    if found is None or solution.spins:
        return
    pencil, n_q = real_pencil(pencil_of(solution)), solution.system.n_q
    rows, stiffness = line.row + np.arange(len(found.rows)), pencil.stiffness.copy()
    stiffness[rows, :n_q], stiffness[:n_q, rows] = found.rows, found.rows.T
    before, after = (_rates(solution, each) for each in (pencil, pencil._replace(stiffness=stiffness)))
    for name, number in asked.items():
        if number <= min(len(before), len(after)):
            value, true = float(before[number - 1]), float(after[number - 1])
            yield name, value, true - value, max(value, true)


def _rates(solution: Solution, pencil: Pencil) -> np.ndarray:
    reduced = free_pencil(solution.system.weights[: solution.system.n_q], pencil)[1]
    return undamped_rates(reduced.stiffness, reduced.mass) / (2 * np.pi)
