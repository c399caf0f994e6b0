"""Distance of a flexible body to its target shape (paper, eqs. 49-53), in the last state and in the frame of the body."""

from __future__ import annotations

import numpy as np

from toolkit.errors import InputError
from toolkit.reduced_model import Shape
from toolkit.responses.response import Partials, Response
from toolkit.responses.stress import elastic_coordinates, flexible_body
from toolkit.scene import Scene
from toolkit.solution import Solution


def target_shape(scene: Scene, body: str) -> Shape:
    """The body's points and their targets.

    Raises
    ------
    InputError
        The body is not flexible, or its reduced model has no target shape.
    """
    model = scene.model(flexible_body(scene, body).model, "shape")
    if model.shape is None:
        raise InputError(
            f"the reduced model of body {body!r} has no target shape. State a target airfoil in its skin file and rebuild."
        )
    return model.shape


def gaps(solution: Solution, body: str) -> tuple[np.ndarray, np.ndarray]:
    """Vectors from target to body at every node (n_k, 2), and their derivatives by the elastic coordinates (n_k, 2, n_f)."""
    shape = target_shape(solution.system.scene, body)
    position = shape.position
    elastic = solution.q[-1, elastic_coordinates(solution, body)]
    return position[:, :, 0] + position[:, :, 1:] @ elastic - shape.target, position[:, :, 1:]


def shape_error(solution: Solution, body: str) -> tuple[np.ndarray, np.ndarray]:
    """Distance to the target at every node (n_k,), and its design derivatives (n_k, n_x).

        e_k = sqrt(d_k . d_k),   de_k/dx = d_k . dd_k/dx / e_k

    Where the distance is exactly zero the derivative does not exist and is nan.
    """
    gap, gap_q = gaps(solution, body)
    error = np.sqrt(np.einsum("ki,ki->k", gap, gap))
    change = np.einsum("ki,kif,fx->kx", gap, gap_q, solution.dq[-1, elastic_coordinates(solution, body)])
    safe = np.where(error.real == 0, 1, error)[:, None]
    return error, np.where(error.real[:, None] == 0, np.nan, change / safe)


def shape_error_history(solution: Solution, body: str) -> tuple[np.ndarray, np.ndarray]:
    """`shape_error` at every time: (n_t, n_k) and (n_t, n_k, n_x); without a target there are no nodes."""
    scene, where = solution.system.scene, elastic_coordinates(solution, body)
    shape = scene.model(flexible_body(scene, body).model, "shape").shape
    if shape is None:
        return np.zeros((len(solution.times), 0)), np.zeros((len(solution.times), 0, solution.system.n_x))
    place, place_q = shape.position[:, :, 0], shape.position[:, :, 1:]
    gap = place - shape.target + np.einsum("kif,tf->tki", place_q, solution.q[:, where])
    error = np.sqrt(np.einsum("tki,tki->tk", gap, gap))
    change = np.einsum("tki,kif,tfx->tkx", gap, place_q, solution.dq[:, where], optimize=True)
    zero = error.real[:, :, None] == 0
    return error, np.where(zero, np.nan, change / np.where(zero, 1, error[:, :, None]))


class ShapeResponse(Response):
    """Base of responses that weight the squared distances of the nodes.

    Attributes
    ----------
    body
        Name of a flexible body whose reduced model has a target shape.
    """

    body: str

    def check(self, scene: Scene) -> None:
        """The body has a target shape."""
        target_shape(scene, self.body)

    def chain(self, solution: Solution, value: complex, weights: np.ndarray) -> Partials:
        """Partials of a response from its derivatives by the gap vectors, shape (n_k, 2)."""
        value_q = np.zeros(solution.q.shape)
        where = elastic_coordinates(solution, self.body)
        value_q[-1, where] = np.einsum("ki,kif->f", np.real(weights), gaps(solution, self.body)[1])
        return Partials(value, q=value_q)


class ShapeMSE(ShapeResponse):
    """Mean squared distance to the target; smooth also at zero error."""

    kind = "shape-mse"
    quantity = "area"

    def partials(self, solution: Solution) -> Partials:
        """mse = sum_k d_k . d_k / n."""
        gap, _ = gaps(solution, self.body)
        return self.chain(solution, np.sum(gap * gap) / len(gap), 2 * gap / len(gap))


class ShapeRMS(ShapeResponse):
    """Root mean square distance to the target (paper, eq. 50), differentiated through the squared distances."""

    kind = "shape-rms"
    quantity = "length"

    def partials(self, solution: Solution) -> Partials:
        """rms = sqrt(mse), drms = dmse / (2 rms); undefined only if every node meets its target exactly."""
        gap, _ = gaps(solution, self.body)
        rms = np.sqrt(np.sum(gap * gap) / len(gap))
        weights = gap / (len(gap) * rms) if rms.real != 0 else np.full(gap.shape, np.nan)
        return self.chain(solution, rms, weights)


class ShapeMax(ShapeResponse):
    """Largest distance to the target; its derivative is that of the node where it occurs."""

    kind = "shape-max"
    quantity = "length"

    def partials(self, solution: Solution) -> Partials:
        """The node with the largest distance."""
        gap, _ = gaps(solution, self.body)
        k = int(np.argmax(np.sum(gap * gap, axis=1).real))
        distance = np.sqrt(gap[k] @ gap[k])
        weights = np.zeros(gap.shape, gap.dtype)
        weights[k] = gap[k] / distance if distance.real != 0 else np.nan
        return self.chain(solution, distance, weights)
