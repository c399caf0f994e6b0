"""Distance of a flexible body to its target shape (paper, eqs. 49-53), in one state, by default the last, and in the frame of the body.

Where the nodes of a cut body are in the axes of the whole, and what their places depend on.

With the frame r, theta of the part that a node is in, and the axes X_0, psi that the whole is looked at from,

    Y = A(psi)^T (r + A(theta) Z [1; q_f] - X_0) + x_0

A grounded body is looked at from where it is placed (x_0 = 0), any other one from the node that its model clamps: X_0 and psi are its place
and how far it has turned, x_0 its undeformed place.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from toolkit.components.bodies.cut_body import CutBody, PlanarCutBody
from toolkit.components.bodies.framed_part import elements_at, whole_design
from toolkit.foundation.errors import InputError
from toolkit.foundation.itself import Itself
from toolkit.foundation.kinematics.orientation import rotation
from toolkit.foundation.near_ties import RESULT_TIE_BAND, first_largest
from toolkit.reduced_model.cut_chain import ChainPlace, chain_nodes
from toolkit.reduced_model.dependence import scattered
from toolkit.reduced_model.model import Shape
from toolkit.responses.response import Instant, MeanSquare, Partials
from toolkit.responses.stress import design_rates
from toolkit.scene.resolution import ResolvedScene, clamped_nodes
from toolkit.system.quantities import STEP
from toolkit.system.solution import Solution, design_point, elastic_coordinates, flexible_body

TILDE = np.array([[0.0, -1.0], [1.0, 0.0]])
"""A quarter turn: A' = A TILDE."""


class ShapeRows(NamedTuple):
    """Coordinates and shape functions of all nodes, in the order of their numbers, each in the frame of its part.

    Parts with fewer coordinates are filled up with one behind the last, which is zero.
    """

    frame: np.ndarray  # (n_nodes,) number of r_x
    elastic: np.ndarray  # (n_nodes, n_f)
    position: np.ndarray  # (n_nodes, 2, 1 + n_f) Z_P
    angle: np.ndarray  # (n_nodes, 1 + n_f) T_P


class ShapeDependence(NamedTuple):
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


def _rows(scene: ResolvedScene, name: str) -> ShapeRows:
    return _rows_of(Itself(scene), name)


@lru_cache(maxsize=8)
def _rows_of(same: Itself[ResolvedScene], name: str) -> ShapeRows:
    """Coordinates and shape functions of a cut body's nodes; a node between two parts belongs to the second."""
    scene, found = same.item, []
    body = scene.bodies[name]
    assert isinstance(body, PlanarCutBody)
    parts: dict[str, Any] = body.parts(name)
    for start, part in zip(body.starts, parts.values(), strict=False):
        assembled = part.part(scene)
        for element in range(part.first, part.last):
            found.append((start, *assembled.at(ChainPlace(element, 0.0))))
    found.append((start, *assembled.at(ChainPlace(element, 1.0))))
    order = chain_nodes(elements_at(whole_design(scene, name)).connectivity)
    assert order is not None
    return _side_by_side([found[k] for k in np.argsort(order)], body.starts[-1])


def _side_by_side(found: list[tuple[int, np.ndarray, np.ndarray]], behind: int) -> ShapeRows:
    """Arrays of all nodes from the first coordinate, Z_P and T_P of each; `behind` numbers the coordinate that does not exist."""
    counts = [len(angle) - 1 for _, _, angle in found]
    dtype = np.result_type(*(array for _, *arrays in found for array in arrays))
    elastic = np.full((len(found), max(counts)), behind)
    position, angle = np.zeros((len(found), 2, 1 + max(counts)), dtype), np.zeros((len(found), 1 + max(counts)), dtype)
    for k, (count, (start, place, turn)) in enumerate(zip(counts, found, strict=True)):
        elastic[k, :count] = start + 3 + np.arange(count)
        position[k, :, : 1 + count], angle[k, : 1 + count] = place, turn
    return ShapeRows(np.array([start for start, _, _ in found]), elastic, position, angle)


def _seen(rows: ShapeRows, q: np.ndarray) -> ShapeDependence:
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
    return ShapeDependence(r + inside, angle, place_q[:, :, :-1], angle_q[:, :-1])


def _axes(
    scene: ResolvedScene, name: str, body: PlanarCutBody, rows: ShapeRows, q: np.ndarray
) -> tuple[ShapeDependence, np.ndarray]:
    """Axes of the undeformed whole (X_0 and psi) in one state, and the reference point x_0."""
    if body.frame == "grounded":
        still = np.zeros((1, 2, len(q)))
        return ShapeDependence(np.array([body.position]), np.array([body.angle]), still, still[:, 0]), np.zeros(2)
    held = clamped_nodes(scene.model(body.model, "elements", "mesh"))
    if len(held) != 1:
        raise InputError(
            f"the shape of body {name!r} is looked at from the node that its model clamps, but that is not one node "
            f"({scene.model(body.model).reference_condition}). Clamp the model at a node, or leave `frames` out."
        )
    return _seen(ShapeRows(*(array[held] for array in rows)), q), rows.position[held[0], :, 0]


REMEMBERED_STEPS = 64
"""Steps whose gaps are remembered: more than `magnitude` looks at."""


def target_shape(scene: ResolvedScene, body: str) -> Shape:
    """Points of a body whose distance to a target counts, with their targets.

    Raises
    ------
    InputError
        The body is not flexible, or its reduced model has no target shape.
    """
    design = design_point(scene, body, "shape")
    if design.model.shape is None:
        raise InputError(
            f"the reduced model of body {body!r} has no target shape. State a target airfoil in its skin file and rebuild."
        )
    return design.shape()


def gap_rates(solution: Solution, body: str, coordinates: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
    """Partial derivatives of the gap vectors by the design variables that move nodes or targets.

    Parameters
    ----------
    coordinates : (n_t, n_f) elastic coordinates at some times

    Yields
    ------
    number of the variable, derivatives (n_t, n_k, 2)
    """
    if isinstance(solution.system.scene.bodies.get(body), CutBody):
        yield from _rates_of_cut(solution, body, coordinates)
        return
    for item, sign in (("shape.position", 1), ("shape.target", -1)):
        rates = design_rates(solution, body, item, "shape")
        if not len(rates.parameter):
            continue
        state = np.real(np.column_stack([np.ones(len(coordinates)), coordinates]))
        size = design_point(solution.system.scene, body, "shape").model.item(item).shape
        for x in map(int, np.unique(rates.parameter)):
            entry, value = rates.by(x)
            change = scattered(entry, sign * value, int(np.prod(size))).reshape(size)
            yield x, np.einsum("kiz,tz->tki", change, state) if sign > 0 else np.broadcast_to(change, (len(state), *size))


def gaps(solution: Solution, body: str, steps: slice = slice(-1, None)) -> tuple[np.ndarray, np.ndarray]:
    """Vectors from target to body at every node, at some steps (n_t, n_k, 2), and their derivatives by the coordinates `moving` it.

    These are (n_k, 2, n_f), the same at all steps; of a cut body, whose parts turn, (n_t, n_k, 2, n).
    """
    if isinstance(solution.system.scene.bodies.get(body), CutBody):
        return _gaps_of_cut(solution, body, solution.q[steps, moving(solution, body)])
    shape = target_shape(solution.system.scene, body)
    place, place_q = shape.position[:, :, 0], shape.position[:, :, 1:]
    elastic = solution.q[steps, elastic_coordinates(solution, body)]
    return place + np.einsum("kif,tf->tki", place_q, elastic) - shape.target, place_q


def _gaps_at(solution: Solution, body: str, step: int) -> tuple[np.ndarray, np.ndarray]:
    """Gap vectors at one step, as `gaps`; the last ones are stored, as several responses use the same shape."""
    kept: dict[int, tuple[np.ndarray, np.ndarray]] = solution.known.setdefault((gaps, body), {})
    if step not in kept:
        if len(kept) >= REMEMBERED_STEPS:
            kept.clear()
        kept[step] = gaps(solution, body, slice(step, step + 1))
    return kept[step]


def moving(solution: Solution, body: str) -> slice:
    """Slice of q's second axis with the coordinates that move a body against its target."""
    if isinstance(solution.system.scene.bodies.get(body), CutBody):
        return solution.coordinates(body)
    found = elastic_coordinates(solution, body)
    assert isinstance(found, slice)
    return found


def _gaps_of_cut(solution: Solution, body: str, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    scene = solution.system.scene
    target = target_shape(solution.system.scene, body).target
    places, slopes = zip(*(cut_positions(scene, body, state) for state in q), strict=True)
    return np.stack(places) - target, np.stack(slopes)


def _rates_of_cut(solution: Solution, body: str, q: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
    """Derivatives of a cut body's gap vectors by design variables that move its shapes or target, by complex steps."""
    moved_scenes = solution.system.scene.once(
        ("moved shapes", body, *solution.system.design.names), lambda: [*_moved_shapes(solution, body)]
    )
    for x, moved, target in moved_scenes:
        yield x, np.imag([cut_positions(moved, body, state)[0] - target for state in np.real(q)]) / STEP


def _moved_shapes(solution: Solution, body: str) -> Iterator[tuple[int, ResolvedScene, np.ndarray]]:
    """Number of every variable that moves shapes of a cut body or its target, the scene with a complex step in it, and the target there."""
    scene = solution.system.scene
    for x, variable in enumerate(solution.system.design):
        if any(path.startswith(f"bodies.{body}.") for path in variable.paths):
            moved = scene.moved(variable, 1j * STEP)
            target = target_shape(moved, body).target
            if (
                set(variable.paths) <= set(scene.model_parameters())
                and not moves_shapes(moved, body)
                and not np.any(np.imag(target))
            ):
                continue  # a section: its effect is that of the state
            yield x, moved, target


def shape_error(solution: Solution, body: str) -> tuple[np.ndarray, np.ndarray]:
    """Distances to the target in the last state, (n_k,), and their design derivatives (n_k, n_x), as `distances`."""
    error, change = distances(solution, body, slice(-1, None))
    return error[0], change[0]


def shape_error_history(solution: Solution, body: str) -> tuple[np.ndarray, np.ndarray]:
    """Distances to the target at every time, (n_t, n_k), and their design derivatives (n_t, n_k, n_x), as `distances`.

    Without a target there are no nodes.
    """
    scene = solution.system.scene
    if scene.model(flexible_body(scene, body).model, "shape").shape is None:
        return np.zeros((len(solution.times), 0)), np.zeros((len(solution.times), 0, solution.system.n_x))
    return distances(solution, body, slice(None))


def distances(solution: Solution, body: str, steps: slice) -> tuple[np.ndarray, np.ndarray]:
    """Distance to the target at every node and some steps (n_t, n_k), and its design derivatives (n_t, n_k, n_x).

        e_k = sqrt(d_k . d_k),   de_k/dx = d_k . dd_k/dx / e_k

    Where the distance is exactly zero the derivative does not exist and is nan.
    """
    gap = gaps(solution, body, steps)[0]
    error = np.sqrt(np.einsum("tki,tki->tk", gap, gap))
    change = np.einsum("tki,tkix->tkx", gap, gap_changes(solution, body, steps))
    zero = error.real[:, :, None] == 0
    return error, np.where(zero, np.nan, change / np.where(zero, 1, error[:, :, None]))


def gap_changes(solution: Solution, body: str, steps: slice) -> np.ndarray:
    """Design derivatives of the gap vectors at some steps, (n_t, n_k, 2, n_x)."""
    gap_q, where = gaps(solution, body, steps)[1], moving(solution, body)
    axes = "kif" if gap_q.ndim == 3 else "tkif"
    change: np.ndarray = np.einsum(f"{axes},tfx->tkix", gap_q, solution.dq[steps, where], optimize=True)
    for x, rate in gap_rates(solution, body, solution.q[steps, where]):
        change[..., x] += rate
    return change


class ShapeResponse(Instant):
    """Base of responses that weight the squared distances of the nodes.

    Attributes
    ----------
    body
        Name of a flexible body whose reduced model has a target shape.
    """

    body: str

    def check(self, scene: ResolvedScene) -> None:
        """Refuse a body without a target shape."""
        super().check(scene)
        target_shape(scene, self.body)

    def weighted(self, gap: np.ndarray) -> tuple[complex, np.ndarray]:
        """Value of the response from gap vectors (n_k, 2), and its derivatives by them."""
        raise NotImplementedError

    def at(self, solution: Solution, step: int) -> Partials:
        """Value and partial derivatives from the gap vectors at a step."""
        gap, gap_q = _gaps_at(solution, self.body, step)
        value, weights = self.weighted(gap[0])
        value_q, design, weights = np.zeros(solution.system.n_q), np.zeros(solution.system.n_x), np.real(weights)
        where = moving(solution, self.body)
        value_q[where] = np.einsum("ki,kif->f", weights, np.real(gap_q if gap_q.ndim == 3 else gap_q[0]))
        for x, rate in gap_rates(solution, self.body, solution.q[step : step + 1, where]):
            design[x] += np.sum(weights * rate[0])
        return Partials(value, q=value_q, design=design)


class ShapeMSE(ShapeResponse, MeanSquare):
    """Mean squared distance to the target; smooth also at zero error."""

    kind = "shape-mse"
    quantity = "area"

    def weighted(self, gap: np.ndarray) -> tuple[complex, np.ndarray]:
        """Mean square mse = sum_k d_k . d_k / n of the gap vectors, and its derivatives by them."""
        return np.sum(gap * gap) / len(gap), 2 * gap / len(gap)

    def curvature(self, solution: Solution) -> np.ndarray:
        """Gauss-Newton Hessian (n_x, n_x): 2/n times the sum over k of dd_k dd_k^T, for each component of the gap."""
        step = self.step(solution)
        change = gap_changes(solution, self.body, slice(step, step + 1))[0]
        found: np.ndarray = 2 / len(change) * np.einsum("kix,kiy->xy", change, change)
        return found


class ShapeRMS(ShapeResponse):
    """Root mean square distance to the target (paper, eq. 50), differentiated through the squared distances."""

    kind = "shape-rms"
    quantity = "length"

    def weighted(self, gap: np.ndarray) -> tuple[complex, np.ndarray]:
        """Root mean square rms = sqrt(mse) with drms = dmse / (2 rms); undefined only if every node meets its target exactly."""
        rms = np.sqrt(np.sum(gap * gap) / len(gap))
        return rms, gap / (len(gap) * rms) if rms.real != 0 else np.full(gap.shape, np.nan)


class ShapeMax(ShapeResponse):
    """Largest distance to the target; its derivative is that of the node where it occurs."""

    kind = "shape-max"
    quantity = "length"

    def weighted(self, gap: np.ndarray) -> tuple[complex, np.ndarray]:
        """Largest distance of a node to its target, and its derivatives by the gap vectors."""
        k = first_largest(np.sum(gap * gap, axis=1).real, RESULT_TIE_BAND)
        distance = np.sqrt(gap[k] @ gap[k])
        weights = np.zeros(gap.shape, gap.dtype)
        weights[k] = gap[k] / distance if distance.real != 0 else np.nan
        return distance, weights
