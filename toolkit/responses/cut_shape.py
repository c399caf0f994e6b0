"""Where the nodes of a cut body are in the axes of the whole, and what their places depend on.

With the frame r, theta of the part that a node is in, and the axes X_0, psi that the whole is looked at from,

    Y = A(psi)^T (r + A(theta) Z [1; q_f] - X_0) + x_0

A grounded body is looked at from where it is placed (x_0 = 0), any other one from the node that its model clamps: X_0 and psi are its place
and how far it has turned, x_0 its undeformed place.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from toolkit.bodies.cut.framed_part import elements_at, whole_design
from toolkit.bodies.planar.cut.cut_body import PlanarCutBody
from toolkit.foundation.errors import InputError
from toolkit.foundation.itself import Itself
from toolkit.kinematics.planar import rotation
from toolkit.reduced_model.cut.chain import Place, chain_nodes
from toolkit.scene.resolution import ResolvedScene, clamped_nodes

TILDE = np.array([[0.0, -1.0], [1.0, 0.0]])
"""A quarter turn: A' = A TILDE."""


class Rows(NamedTuple):
    """Coordinates and shape functions of all nodes, in the order of their numbers, each in the frame of its part.

    Parts with fewer coordinates are filled up with one behind the last, which is zero.
    """

    frame: np.ndarray  # (n_nodes,) number of r_x
    elastic: np.ndarray  # (n_nodes, n_f)
    position: np.ndarray  # (n_nodes, 2, 1 + n_f) Z_P
    angle: np.ndarray  # (n_nodes, 1 + n_f) T_P


class Seen(NamedTuple):
    """Places and angles of nodes (k), or of the axes of the whole, in one state, with derivatives by the body's coordinates."""

    place: np.ndarray  # (k, 2)
    angle: np.ndarray  # (k,)
    place_q: np.ndarray  # (k, 2, n)
    angle_q: np.ndarray  # (k, n)


def cut_positions(scene: ResolvedScene, name: str, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n_nodes, 2) of all nodes in one state q (n,) of the body, and derivatives by q, (n_nodes, 2, n).

    Raises
    ------
    InputError
        The frame of the whole is not tied to one of its nodes.
    """
    body = scene.bodies[name]
    assert isinstance(body, PlanarCutBody)
    rows = _rows(scene, name)
    seen = _seen(rows, q)
    axes, origin = _axes(scene, name, body, rows, q)
    back = rotation(-axes.angle[0])
    away = (seen.place - axes.place) @ back.T
    return away + origin, back @ (seen.place_q - axes.place_q) - (away @ TILDE.T)[:, :, None] * axes.angle_q[:, None, :]


def moves_shapes(scene: ResolvedScene, name: str) -> bool:
    """Whether the imaginary step that a scene holds moves the undeformed nodes of a cut body, or what its parts are reduced to."""
    body: Any = scene.bodies[name]
    if body.modes_per_frame is None:
        return bool(np.any(np.imag(whole_design(scene, name).value("elements.nodes"))))
    return any(np.any(np.imag(part.part(scene).recovery)) for part in body.parts(name).values())


def whole_axes(scene: ResolvedScene, name: str, q: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Origin X_0, angle psi and reference point x_0 of the axes in which the undeformed whole is drawn, in one state q (n,)."""
    body = scene.bodies[name]
    assert isinstance(body, PlanarCutBody)
    held = clamped_nodes(scene.model(body.model, "elements", "mesh"))
    if body.frame == "moving" and len(held) != 1:
        return q[:2], float(q[2]), np.zeros(2)
    axes, origin = _axes(scene, name, body, _rows(scene, name), q)
    return axes.place[0], float(axes.angle[0]), origin


def _rows(scene: ResolvedScene, name: str) -> Rows:
    return _rows_of(Itself(scene), name)


@lru_cache(maxsize=8)
def _rows_of(same: Itself[ResolvedScene], name: str) -> Rows:
    """Coordinates and shape functions of a cut body's nodes; a node between two parts belongs to the second."""
    scene, found = same.item, []
    body = scene.bodies[name]
    assert isinstance(body, PlanarCutBody)
    parts: dict[str, Any] = body.parts(name)
    for start, part in zip(body.starts, parts.values(), strict=False):
        assembled = part.part(scene)
        for element in range(part.first, part.last):
            found.append((start, *assembled.at(Place(element, 0.0))))
    found.append((start, *assembled.at(Place(element, 1.0))))
    order = chain_nodes(elements_at(whole_design(scene, name)).connectivity)
    assert order is not None
    return _side_by_side([found[k] for k in np.argsort(order)], body.starts[-1])


def _side_by_side(found: list[tuple[int, np.ndarray, np.ndarray]], behind: int) -> Rows:
    """Arrays of all nodes from the first coordinate, Z_P and T_P of each; `behind` numbers the coordinate that does not exist."""
    counts = [len(angle) - 1 for _, _, angle in found]
    dtype = np.result_type(*(array for _, *arrays in found for array in arrays))
    elastic = np.full((len(found), max(counts)), behind)
    position, angle = np.zeros((len(found), 2, 1 + max(counts)), dtype), np.zeros((len(found), 1 + max(counts)), dtype)
    for k, (count, (start, place, turn)) in enumerate(zip(counts, found, strict=True)):
        elastic[k, :count] = start + 3 + np.arange(count)
        position[k, :, : 1 + count], angle[k, : 1 + count] = place, turn
    return Rows(np.array([start for start, _, _ in found]), elastic, position, angle)


def _seen(rows: Rows, q: np.ndarray) -> Seen:
    state = np.append(q, 0)[rows.elastic]
    node, r, theta = np.arange(len(rows.frame)), q[rows.frame[:, None] + [0, 1]], q[rows.frame + 2]
    turned = np.moveaxis(rotation(theta), -1, 0)
    inside = np.einsum("kij,kj->ki", turned, rows.position[:, :, 0] + np.einsum("kif,kf->ki", rows.position[:, :, 1:], state))
    place_q = np.zeros((len(node), 2, len(q) + 1), np.result_type(inside, rows.position))
    angle_q = np.zeros((len(node), len(q) + 1), rows.angle.dtype)
    place_q[node, 0, rows.frame] = place_q[node, 1, rows.frame + 1] = angle_q[node, rows.frame + 2] = 1
    place_q[node, :, rows.frame + 2] = inside @ TILDE.T
    place_q[node[:, None], :, rows.elastic] = np.swapaxes(turned @ rows.position[:, :, 1:], 1, 2)
    angle_q[node[:, None], rows.elastic] = rows.angle[:, 1:]
    angle = theta + rows.angle[:, 0] + np.einsum("kf,kf->k", rows.angle[:, 1:], state)
    return Seen(r + inside, angle, place_q[:, :, :-1], angle_q[:, :-1])


def _axes(scene: ResolvedScene, name: str, body: PlanarCutBody, rows: Rows, q: np.ndarray) -> tuple[Seen, np.ndarray]:
    """Axes of the undeformed whole (X_0 and psi) in one state, and the reference point x_0."""
    if body.frame == "grounded":
        still = np.zeros((1, 2, len(q)))
        return Seen(np.array([body.position]), np.array([body.angle]), still, still[:, 0]), np.zeros(2)
    held = clamped_nodes(scene.model(body.model, "elements", "mesh"))
    if len(held) != 1:
        raise InputError(
            f"the shape of body {name!r} is looked at from the node that its model clamps, but that is not one node "
            f"({scene.model(body.model).reference_condition}). Clamp the model at a node, or leave `frames` out."
        )
    return _seen(Rows(*(array[held] for array in rows)), q), rows.position[held[0], :, 0]
