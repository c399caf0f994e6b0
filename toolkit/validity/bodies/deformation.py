"""The small-deformation meter: how far a flexible body has left the range in which linear deformation in its frame is true.

Small errors of the parts of a body, joined to one of the body; those of the plane as errors in space that stay in it.

Each part has been bent in its own frame by some w_k, with a rotation at every node. Neighbours stay tied, so that part k follows the rigid
motion which brings its node n to where the part before has it:

    E(x) = w_k(x) + E(n) - w_k(n) + (phi(n) - phi_k(n)) x (x - x_n)

Of this the body's own rigid motion is none of its errors: that of a node that is held, or, of a moving body, that which fits best.

A body is linear in its frame: an element that turns by an angle theta there grows by theta^2 / 2, and its forces keep their directions and
lever arms. The meter estimates by how much the nodes would be elsewhere if the same forces acted on the same elements, turning with them
(corotational): the displacement of second order of `second_order`.

It knows beam elements, in the plane and in space; `bent_surfaces` estimates it of solids.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from toolkit.components.bodies.cut_body import CutBody
from toolkit.components.bodies.framed_part import FramedPart
from toolkit.components.bodies.model_body import FRAME, ModelBody
from toolkit.description.design import BodyPoint
from toolkit.foundation.errors import listed
from toolkit.foundation.near_ties import first_largest
from toolkit.reduced_model.parts import stiffness_of_spin
from toolkit.scene.resolution import ResolvedScene, cuttable, fewest_cut, most_frames
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution, deforming, elastic_coordinates, elements_of, flexible_body, spins_of
from toolkit.validity.bodies.carried_force import static_deflection
from toolkit.validity.bodies.chain import Chain
from toolkit.validity.bodies.known_chain import chain

ZERO_MOMENT_PART = 1e-9
"""Part of the largest moment of inertia of a body's nodes below which a turn moves none of them."""


@dataclass(frozen=True, eq=False)
class BentPart:
    """A part of a body: its nodes by their numbers in the body, their positions, and their errors in the same axes."""

    nodes: np.ndarray  # (n,)
    places: np.ndarray  # (n_t, n, 3)
    errors: np.ndarray  # (n_t, n, 6) displacements and rotations


def in_space(moves: np.ndarray, turns: np.ndarray | None = None) -> np.ndarray:
    """Vectors in space (.., 3) from those in the plane or in space, (.., d); with rotations (.., 1 or 3) behind them (.., 6)."""
    found = np.zeros((*moves.shape[:-1], 3 if turns is None else 6))
    found[..., : moves.shape[-1]] = moves
    if turns is not None:
        found[..., 6 - turns.shape[-1] :] = turns
    return found


def joined_errors(parts: Sequence[BentPart], held: int | None) -> np.ndarray:
    """Errors (n_t, n_nodes, 3) of the nodes of a body, of which one or none is held, joined from those of its parts."""
    count, times = 1 + max(part.nodes.max() for part in parts), len(parts[0].errors)
    places, found = np.zeros((times, count, 3)), np.zeros((times, count, 6))
    joined, waiting = set(parts[0].nodes[:1].tolist()), list(parts)
    while waiting:
        part = next((each for each in waiting if joined.intersection(each.nodes.tolist())), waiting[0])
        waiting.remove(part)
        n = next((k for k, node in enumerate(part.nodes) if int(node) in joined), 0)
        start = found[:, part.nodes[n]] - part.errors[:, n]
        new = [k for k, node in enumerate(part.nodes) if k == n or int(node) not in joined]
        places[:, part.nodes] = part.places
        found[:, part.nodes[new]] = part.errors[:, new] + _rigid(start, part.places[:, new] - part.places[:, n : n + 1])
        joined |= set(part.nodes.tolist())
    if held is not None:
        return (found - _rigid(found[:, held], places - places[:, held : held + 1]))[:, :, :3]
    return _without_best(found[:, :, :3], places)


def _rigid(motion: np.ndarray, arms: np.ndarray) -> np.ndarray:
    """Displacements and rotations (n_t, n, 6) of points at arms (n_t, n, 3) by those of their origin (n_t, 6)."""
    moved = motion[:, None, :3] + np.cross(motion[:, None, 3:], arms)
    return np.concatenate([moved, np.broadcast_to(motion[:, None, 3:], arms.shape)], axis=2)


def _without_best(errors: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Errors (n_t, n, 3) without the rigid motion that leaves the least squares."""
    arms = places - places.mean(axis=1, keepdims=True)
    inertia = np.einsum("tni,tni,jk->tjk", arms, arms, np.eye(3)) - np.einsum("tnj,tnk->tjk", arms, arms)
    moment = np.cross(arms, errors).sum(axis=1)
    turn = np.einsum("tjk,tk->tj", np.linalg.pinv(inertia, rcond=ZERO_MOMENT_PART, hermitian=True), moment)
    found: np.ndarray = errors - errors.mean(axis=1, keepdims=True) - np.cross(turn[:, None], arms)
    return found


ALL = slice(None)
"""Instants of a run."""
UNDEFORMED_PART = 1e-9
"""Displacement in parts of the size below which a body does not deform, so that one frame is exact."""


def node_places(solution: Solution, body: str, instants: slice | np.ndarray = ALL) -> np.ndarray:
    """Places of the nodes in the order of the reduced model at some instants of a run, (n_t, n_nodes, d)."""
    scene = solution.system.scene
    written, still = scene.bodies[body], undeformed_places(scene, body)
    if not isinstance(written, CutBody):
        return _carried(solution, body, instants, still, _shapes(scene, body))
    places = np.zeros((len(solution.times[instants]), *still.shape))
    for name, part in written.parts(body).items():
        assert isinstance(part, FramedPart)
        found, own = part.part(scene), part.node_numbers(scene)
        places[:, own] = _carried(solution, name, instants, np.real(found.nodes), np.real(found.recovery[:, 1:]))
    return places


def has_places(scene: Scene, body: str) -> bool:
    """Whether they are known: with one frame where that is tied to nodes, or the model has a mesh."""
    return isinstance(scene.bodies[body], CutBody) or _shapes_kept(scene, body) is not None


def largest_displacement(solution: Solution, body: str) -> float:
    """The largest distance of a node from where it would be undeformed: at the place of a grounded body, or at that which fits best."""
    return float(displacements(solution, body).max())


def displacements(solution: Solution, body: str, instants: slice | np.ndarray = ALL) -> np.ndarray:
    """The same of every node at some instants of a run, (n_t, n_nodes)."""
    written: Any = solution.system.scene.bodies[body]
    places, still = node_places(solution, body, instants), undeformed_places(solution.system.scene, body)
    if written.frame == "grounded":
        return _distances(places - np.array(written.position) - still @ written.placement.T)
    return _distances(_brought(np.broadcast_to(still, places.shape), places) - places)


def is_moving(scene: Scene, body: str) -> bool:
    """Whether the body has no frame that is held, so that its places are compared when they have been put together best."""
    written: Any = scene.bodies[body]
    return bool(written.frame == "moving")


def relative_distance(one: np.ndarray, other: np.ndarray, displacement: float, moving: bool) -> float:
    """The largest distance between two runs in parts of the largest displacement; none of a body that does not deform."""
    if displacement <= UNDEFORMED_PART * np.ptp(one, axis=(0, 1)).max():
        return 0.0
    return largest_distance(one, other, moving) / displacement


def largest_distance(one: np.ndarray, other: np.ndarray, moving: bool = False) -> float:
    """Between the same node at the same time of two runs (n_t, n_nodes, d); of moving bodies, when they have been put together best."""
    return float(_distances((_brought(one, other) if moving else one) - other).max())


def _brought(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Places, moved and turned as a rigid body so that their squared distances to the others are least."""
    centre, aim = one.mean(axis=1, keepdims=True), other.mean(axis=1, keepdims=True)
    left, _, right = np.linalg.svd(np.einsum("tnd,tne->tde", other - aim, one - centre))
    left[:, :, -1] *= np.sign(np.linalg.det(left) * np.linalg.det(right))[:, None]  # a rotation, and no reflection
    found: np.ndarray = aim + np.einsum("tdi,tie,tne->tnd", left, right, one - centre)
    return found


def _carried(solution: Solution, body: str, instants: slice | np.ndarray, still: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """Nodes (n_nodes, d) of a body, or part of one, that has one frame, where `shapes` q_f and its frame bring them."""
    written: Any = solution.system.scene.body(body)
    q = np.real(solution.q[instants][:, solution.coordinates(body)])
    moved = (q[:, written.frame_size :] @ shapes.T).reshape(len(q), len(still), -1)[:, :, : still.shape[1]]
    origins, axes = written.poses(q)
    found: np.ndarray = origins[:, None] + np.einsum("tij,tnj->tni", axes, still + moved)
    return found


def undeformed_places(scene: Scene, body: str) -> np.ndarray:
    """Undeformed places of the nodes at the scene's parameter values, in the axes of the model, (n_nodes, d)."""
    written: Any = scene.bodies[body]
    design = written.design_point(scene, "elements", "element_derivatives", "element_affine")
    found: np.ndarray = np.real(design.value("elements.nodes"))
    return found


def _shapes(scene: Scene, body: str) -> np.ndarray:
    found = _shapes_kept(scene, body)
    assert found is not None
    return found


def _shapes_kept(scene: Scene, body: str) -> np.ndarray | None:
    written: Any = scene.bodies[body]
    return scene.model(written.model, "elements", "mesh").nodal_shapes


def _distances(away: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("...d,...d->...", away, away))


def kept_back(solution: Solution, body: str, instants: np.ndarray) -> np.ndarray | None:
    """K^-1 S(omega) q (n_t, n_f) at some instants of a run; None of a body that does not ask for its stiffening.

    Forces on the body are (K + S) q. Elements that turn find the part S q by themselves.
    """
    scene = solution.system.scene
    found = flexible_body(scene, body)
    stiffening = found.stiffening(scene)
    if stiffening is None:
        return None
    spins = spins_of(solution, body, instants)
    elastic = np.real(solution.q[instants][:, elastic_coordinates(solution, body)])
    forces = [stiffness_of_spin(np.real(stiffening), spin) @ q for spin, q in zip(spins, elastic, strict=True)]
    stiffness = np.real(found.invariants(scene).stiffness)
    return static_deflection(stiffness, np.array(forces).T).T


ROUND_OFF = 1e-12
"""Displacement, relative to a body's extent, below which it is round-off."""
LIMIT = 0.05
"""Part of the largest displacement that the geometric error may be: an element that turns by 0.1 rad, 6 degrees, is about there.
Up to here the estimate is good to some ten percent, and the errors of stresses and positions are of the same order as the number itself."""

INSTANTS = 50
"""Number of instants of a run that the meter examines, those of the largest elastic coordinates."""


@dataclass(frozen=True)
class Deformation:
    """Deformation of a body at the instant of the largest geometric error; lengths in the units of the scene."""

    rotation: float  # largest rotation of a node in the body's frame, rad
    displacement: float  # largest displacement of a node in the body's frame
    error: float  # estimated distance of a node to where the same forces would bring it if the elements turned
    size: float  # extent of the undeformed body
    time: float

    @property
    def relative(self) -> float:
        """Geometric error relative to the largest displacement; zero where this is round-off."""
        return self.error / self.displacement if self.displacement > ROUND_OFF * self.size else 0.0

    @property
    def exceeded(self) -> bool:
        """Whether the geometric error exceeds its limit, so that the linear body is out of its range."""
        return not self.relative <= LIMIT


def flexible_bodies(scene: ResolvedScene) -> list[str]:
    """Names of the bodies that deform; for a cut body the names of its parts."""
    return list(deforming(scene))


def deformations(solution: Solution) -> dict[str, Deformation | None]:
    """Measured deformation of every flexible body; None where the reduced model does not hold its finite elements."""
    if Deformation not in solution.known:
        solution.known[Deformation] = {name: deformation(solution, name) for name in whole_bodies(solution.system.scene)}
    found: dict[str, Deformation | None] = solution.known[Deformation]
    return found


def whole_bodies(scene: ResolvedScene) -> list[str]:
    """Names of the flexible bodies, cut or not."""
    return [name for name, body in scene.bodies.items() if isinstance(body, ModelBody)]


def deformation(solution: Solution, body: str) -> Deformation | None:
    """Measured deformation of one body; None where its finite elements are not known."""
    written = solution.system.scene.bodies.get(body)
    if isinstance(written, CutBody):
        return _of_parts(solution, body, written)
    behind = chain(solution.system.scene, body)
    return None if behind is None else deformation_of(behind, solution, body)


def _of_parts(solution: Solution, body: str, written: CutBody) -> Deformation | None:
    """The meter's numbers for a cut body.

    The errors of its parts, each in its own frame, add up to one of the whole, relative to the whole's displacement.
    """
    scene = solution.system.scene
    instants = instants_of(solution, body)
    found = [_bent_part(solution, name, instants) for name in written.parts(body)]
    parts = [each[0] for each in found if each is not None]
    if len(parts) < len(found):
        return None
    lost = joined_errors(parts, _held_node(scene, written))
    error, moved = np.linalg.norm(lost, axis=2).max(axis=1), displacements(solution, body, instants).max(axis=1)
    worst = first_largest(error)
    rotation = max(each[1][worst] for each in found if each is not None)
    extent = np.ptp(undeformed_places(scene, body), axis=0).max()
    time = solution.times[instants[worst]]
    return Deformation(float(rotation), float(moved[worst]), float(error[worst]), float(extent), float(time))


def _bent_part(solution: Solution, name: str, instants: np.ndarray) -> tuple[BentPart, np.ndarray] | None:
    """A part with its errors, and the largest rotation of its nodes in its frame, (n_t,); None without known elements."""
    scene = solution.system.scene
    part: Any = scene.body(name)
    behind = chain(scene, name)
    if behind is None:
        return None
    u = behind.displacements(np.real(solution.q[instants][:, elastic_coordinates(solution, name)]))
    origins, axes = part.poses(np.real(solution.q[instants][:, solution.coordinates(name)]))
    moved, (lost, lost_turn) = behind.by_node(u)[0], behind.by_node(behind.second_order(u))
    places = origins[:, None] + np.einsum("tij,tnj->tni", axes, behind.nodes + moved)
    turn = np.einsum("tij,tnj->tni", axes, lost_turn) if lost_turn.shape[2] == 3 else lost_turn
    errors = in_space(np.einsum("tij,tnj->tni", axes, lost), turn)
    return BentPart(part.node_numbers(scene), in_space(places), errors), behind.rotations(u).max(axis=1)


def _held_node(scene: ResolvedScene, written: Any) -> int | None:
    """Number of a node that holds a grounded body; None of other bodies."""
    model = scene.model(written.model, "elements", "mesh")
    if written.frame != "grounded" or model.elements is None:
        return None
    return int(model.elements.held_nodes(model.mesh)[0])


def deformation_of(behind: Chain, solution: Solution, body: str) -> Deformation:
    """Measured deformation of one body whose finite elements are known."""
    elastic, instants = np.real(solution.q[:, elastic_coordinates(solution, body)]), instants_of(solution, body)
    u, held_back = behind.displacements(elastic[instants]), kept_back(solution, body, instants)
    lacks = behind.second_order(u)
    if held_back is not None:
        lacks = lacks + behind.displacements(held_back)
    moved, error = behind.distances(u), behind.distances(lacks)
    worst = first_largest(error.max(axis=1))
    extent = np.ptp(behind.nodes, axis=0).max()
    rotation, time = behind.rotations(u)[worst].max(), solution.times[instants[worst]]
    return Deformation(float(rotation), float(moved[worst].max()), float(error[worst].max()), float(extent), float(time))


def instants_of(solution: Solution, body: str) -> np.ndarray:
    """Instants of the largest deformation of a body, or of a part of one, by `largest_instants`, found once."""
    key = largest_instants, body
    if key not in solution.known:
        solution.known[key] = largest_instants(np.real(solution.q[:, elastic_coordinates(solution, body)]))
    found: np.ndarray = solution.known[key]
    return found


def largest_instants(elastic: np.ndarray, count: int = INSTANTS) -> np.ndarray:
    """Numbers of the instants at which elastic coordinates (n_t, n_f) are largest in their own scale, in order of time."""
    scale = np.abs(elastic).max(axis=0)
    size = np.linalg.norm(elastic / np.where(scale > 0, scale, 1.0), axis=1)
    return np.sort(np.argsort(-size, kind="stable")[:count])


def divided(scene: ResolvedScene, body: str, excess: float) -> str:
    """What divides a body whose error is so many times what it may be: frames in a number where its model allows them.

    The error falls with the square of the number.
    """
    written = scene.bodies[body]
    if body not in cuttable(scene):
        return "model the body as several bodies in a row"
    now = len(written.cuts) - 1 if isinstance(written, CutBody) else 1
    most = most_frames(scene, body)
    wanted = int(np.ceil(now * np.sqrt(excess))) if np.isfinite(excess) else most + 1
    enough = max(now + 1, fewest_cut(scene, body), wanted)
    if enough > most:
        return (
            f"build the model with more {elements_of(scene, body)}, and as many frames"
            if now == most
            else f"set frames = {most} in its table (one floating frame for each {elements_of(scene, body)[:-1]})"
        )
    return (
        f"set frames = {enough} in its table (splits the body into {enough} floating frames){_without_frame_point(scene, body)}"
    )


def _without_frame_point(scene: ResolvedScene, body: str) -> str:
    """What to do about points at the origin of the body's frame, which a body with several frames has not."""
    points = scene.points.items()
    at_frame = [name for name, point in points if isinstance(point, BodyPoint) and (point.body, point.interface) == (body, FRAME)]
    return f" and put {listed(at_frame)}, now at {FRAME!r}, at an interface point of the body" if at_frame else ""
