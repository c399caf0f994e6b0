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
from toolkit.scene.cut_scene import clamped_nodes
from toolkit.scene.scene import Scene

TILDE = np.array([[0.0, -1.0], [1.0, 0.0]])
"""A quarter turn: A' = A TILDE."""


class Rows(NamedTuple):
    """One node: number of the first coordinate of its part among those of the body, and Z_P, T_P."""

    frame: int
    position: np.ndarray  # (2, 1 + n_f)
    angle: np.ndarray  # (1 + n_f,)


class Seen(NamedTuple):
    """A node or the axes of the whole in one state: place and angle, and their derivatives by the coordinates of the body."""

    place: np.ndarray  # (2,)
    angle: Any
    place_q: np.ndarray  # (2, n)
    angle_q: np.ndarray  # (n,)


def cut_positions(scene: Scene, name: str, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Y of all nodes (n_nodes, 2) in one state q (n,) of the body's coordinates, and its derivatives by them (n_nodes, 2, n).

    Raises
    ------
    InputError
        The frame of the whole is not tied to one of its nodes.
    """
    body = scene.bodies[name]
    assert isinstance(body, PlanarCutBody)
    rows = _rows(scene, name)
    order = chain_nodes(elements_at(whole_design(scene, name)).connectivity)
    assert order is not None
    found = [_seen(each, q) for each in rows]
    axes, origin = _axes(scene, name, body, rows, q)
    back = rotation(-axes.angle)
    places: np.ndarray = np.zeros((len(rows), 2), np.result_type(q, *(each.position for each in rows), axes.place, origin, back))
    slopes = np.zeros((len(rows), 2, len(q)), places.dtype)
    for node, seen in zip(order, found, strict=True):
        away = back @ (seen.place - axes.place)
        places[node] = away + origin
        slopes[node] = back @ (seen.place_q - axes.place_q) - np.outer(TILDE @ away, axes.angle_q)
    return places, slopes


def moves_shapes(scene: Scene, name: str) -> bool:
    """Whether the imaginary step that a scene holds moves the undeformed nodes of a cut body, or what its parts are reduced to."""
    body: Any = scene.bodies[name]
    if body.modes_per_frame is None:
        return bool(np.any(np.imag(whole_design(scene, name).value("elements.nodes"))))
    return any(np.any(np.imag(part.part(scene).recovery)) for part in body.parts(name).values())


def whole_axes(scene: Scene, name: str, q: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """X_0, psi and x_0 in one state q (n,) of the body's coordinates: what belongs to the undeformed whole is drawn from there."""
    body = scene.bodies[name]
    assert isinstance(body, PlanarCutBody)
    held = clamped_nodes(scene.model(body.model, "elements", "mesh"))
    if body.frame == "moving" and len(held) != 1:
        return q[:2], float(q[2]), np.zeros(2)
    axes, origin = _axes(scene, name, body, _rows(scene, name), q)
    return axes.place, float(axes.angle), origin


def _rows(scene: Scene, name: str) -> list[Rows]:
    """All nodes in the order of the chain, one between two parts as the first of the second."""
    return _rows_of(Itself(scene), name)


@lru_cache(maxsize=8)
def _rows_of(same: Itself[Scene], name: str) -> list[Rows]:
    scene, found = same.item, []
    body = scene.bodies[name]
    assert isinstance(body, PlanarCutBody)
    for k, part in enumerate(body.parts(name).values()):
        assembled, count = part.part(scene), part.last - part.first  # type: ignore[attr-defined]
        last = k == len(body.cuts) - 2
        for node in range(count + last):
            place = Place(part.first + min(node, count - 1), float(node == count))  # type: ignore[attr-defined]
            found.append(Rows(body.starts[k], *assembled.at(place)))
    return found


def _seen(rows: Rows, q: np.ndarray) -> Seen:
    elastic = slice(rows.frame + 3, rows.frame + 2 + len(rows.angle))
    r, theta, state = q[rows.frame : rows.frame + 2], q[rows.frame + 2], np.concatenate([[1.0], q[elastic]])
    turned = rotation(theta)
    inside = turned @ (rows.position @ state)
    place_q = np.zeros((2, len(q)), np.result_type(inside, rows.position))
    place_q[:, rows.frame : rows.frame + 2] = np.eye(2)
    place_q[:, rows.frame + 2] = TILDE @ inside
    place_q[:, elastic] = turned @ rows.position[:, 1:]
    angle_q = np.zeros(len(q), rows.angle.dtype)
    angle_q[rows.frame + 2] = 1
    angle_q[elastic] = rows.angle[1:]
    return Seen(r + inside, theta + rows.angle @ state, place_q, angle_q)


def _axes(scene: Scene, name: str, body: PlanarCutBody, rows: list[Rows], q: np.ndarray) -> tuple[Seen, np.ndarray]:
    """X_0, psi and x_0."""
    if body.frame == "grounded":
        return Seen(np.array(body.position), body.angle, np.zeros((2, len(q))), np.zeros(len(q))), np.zeros(2)
    held = clamped_nodes(scene.model(body.model, "elements", "mesh"))
    if len(held) != 1:
        raise InputError(
            f"the shape of body {name!r} is looked at from the node that its model clamps, but that is not one node "
            f"({scene.model(body.model).reference_condition}). Clamp the model at a node, or leave `frames` out."
        )
    return _seen(rows[held[0]], q), rows[held[0]].position[:, 0]
