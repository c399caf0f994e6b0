"""Where the nodes of a chain of beams are at all times of a run, whatever number of floating frames it has."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.kinematics.planar import rotation
from toolkit.reduced_model.cut.chain import chain_nodes
from toolkit.reduced_model.model import Mesh
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import design_point
from toolkit.system.solution import Solution


def node_places(solution: Solution, body: str) -> np.ndarray:
    """Places of the nodes in the order of the chain, (n_t, n_nodes, 2)."""
    scene = solution.system.scene
    written = scene.bodies[body]
    if not isinstance(written, CutBody):
        return _of_one_frame(solution, body)
    parts = [_of_one_frame(solution, part) for part in written.parts(body)]
    return np.concatenate([*(part[:, :-1] for part in parts[:-1]), parts[-1]], axis=1)


def largest_displacement(solution: Solution, body: str) -> float:
    """The largest distance of a node from where it would be undeformed: at the place of a grounded body, or at that which fits best."""
    scene = solution.system.scene
    written, places, mesh = scene.bodies[body], node_places(solution, body), _mesh(scene, body)
    still = mesh.nodes[_order(mesh)]
    if written.frame == "grounded":  # type: ignore[attr-defined]
        rigid = np.array(written.position) + still @ rotation(written.angle).T  # type: ignore[attr-defined]
        return float(_distances(places - rigid).max())
    middle, centre = still.mean(axis=0), places.mean(axis=1, keepdims=True)
    arms, moved = still - middle, places - centre
    cosine = np.einsum("nd,tnd->t", arms, moved)
    sine = np.einsum("n,tn->t", arms[:, 0], moved[:, :, 1]) - np.einsum("n,tn->t", arms[:, 1], moved[:, :, 0])
    turned = np.stack([rotation(angle) for angle in np.arctan2(sine, cosine)])
    return float(_distances(moved - np.einsum("tij,nj->tni", turned, arms)).max())


def largest_distance(one: np.ndarray, other: np.ndarray) -> float:
    """Between the same node at the same time of two runs."""
    return float(_distances(one - other).max())


def _of_one_frame(solution: Solution, body: str) -> np.ndarray:
    """The same of a body, or part of one, that has one frame."""
    scene = solution.system.scene
    written, mesh, q = scene.body(body), _mesh(scene, body), np.real(solution.q[:, solution.coordinates(body)])
    elastic = q[:, written.frame_size :]
    shape = mesh.nodes + (elastic @ mesh.recovery[:, 1:].T).reshape(len(q), -1, 3)[:, :, :2]
    shape = shape[:, _order(mesh)]
    if not written.has_frame:  # type: ignore[attr-defined]
        return np.array(written.position) + shape @ rotation(written.angle).T  # type: ignore[attr-defined]
    turned = np.stack([rotation(angle) for angle in q[:, 2]])
    return q[:, None, :2] + np.einsum("tij,tnj->tni", turned, shape)


def _mesh(scene: Scene, body: str) -> Mesh:
    mesh = design_point(scene, body, "mesh").model.mesh
    assert mesh is not None
    return mesh


def _order(mesh: Mesh) -> np.ndarray:
    order = chain_nodes(mesh.connectivity)
    assert order is not None
    return order


def _distances(away: np.ndarray) -> np.ndarray:
    return np.hypot(away[..., 0], away[..., 1])
