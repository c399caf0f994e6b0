"""Where the nodes of a body of beams are at all times of a run, whatever number of floating frames it has."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.cut.framed_part import FramedPart
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution

ALL = slice(None)
"""Instants of a run."""
STRAIGHT = 1e-9
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
    if displacement <= STRAIGHT * np.ptp(one, axis=(0, 1)).max():
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
