"""Variables in which what is minimised is about as curved in all directions.

    z = z_0 + T y,   T = V |W|^(-1/2),   H = V W V^T

with H the second derivative of the objective at z_0, where the responses tell it. Else it is that of the Lagrangian by the gradients of all
designs that were solved, by the updates of Broyden, Fletcher, Goldfarb and Shanno, damped as Powell has it: first with the designs farthest
from z_0, last with the nearest. A method that begins with the identity then knows the valley in which it stands, and does not have to learn
it anew along its own path.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from toolkit.studies.optimization.methods.functions import Functions
from toolkit.studies.optimization.program import Values

FLAT = 1e-4
"""Curvature, in parts of the largest, below which no direction is taken to be flatter."""
LONGEST = 0.5
"""Longest first step along any direction, in parts of the variables' ranges: where nothing bends, curvature does not say how far to go."""
LEAST, DAMPED = 1e-6, 0.2
"""First curvature at least; and the part of the known curvature along a step that an update leaves at least (Powell, 1978)."""


class Known(NamedTuple):
    """A design that was solved: z (n,), and its functions."""

    z: np.ndarray
    values: Values


class Turned:
    """Variables y about a design z_0.

    Parameters
    ----------
    centre
        z_0, (n,).
    axes
        T, (n, n).
    top
        Largest z; the least is zero.
    """

    def __init__(self, centre: np.ndarray, axes: np.ndarray, top: np.ndarray) -> None:
        self.centre, self.axes, self.top = centre, axes, top

    def z(self, y: np.ndarray) -> np.ndarray:
        """The design of a y."""
        found: np.ndarray = self.centre + self.axes @ y
        return found

    def functions(self, functions: Functions) -> Functions:
        """The functions of y, with the bounds of all z as constraints after the others."""

        def of(y: np.ndarray) -> Values:
            z = self.z(y)
            found = functions(z)
            c = np.concatenate([found.c, z, self.top - z])
            dc = np.vstack([found.dc.reshape(-1, len(z)) @ self.axes, self.axes, -self.axes])
            curvature = None if found.curvature is None else self.axes.T @ found.curvature @ self.axes
            return Values(found.f, found.df @ self.axes, c, dc, curvature)

        return of


def turned(
    centre: Known, others: Sequence[Known], multipliers: np.ndarray, top: np.ndarray, reach: float = LONGEST
) -> Turned | None:
    """Variables by the curvature about a design; None where neither its responses nor enough other designs tell it.

    Parameters
    ----------
    centre
        The design.
    others
        All that were solved.
    multipliers
        Of the constraints at the centre, (m,).
    top
        Largest z.
    reach
        Longest first step.
    """
    found = centre.values.curvature
    if found is None:
        found = _learned(centre, others, multipliers)
    if found is None:
        return None
    curved, directions = np.linalg.eigh(found)
    steep = np.abs(_slope(centre.values, multipliers) @ directions)
    return Turned(centre.z, directions / np.sqrt(np.maximum(curved, np.maximum(FLAT * curved[-1], steep / reach))), top)


def _learned(centre: Known, others: Sequence[Known], multipliers: np.ndarray) -> np.ndarray | None:
    """Second derivative of the Lagrangian at the centre by the gradients of other designs, None where these are too few."""
    n = len(centre.z)
    ways = [(each.z - centre.z, _slope(each.values, multipliers) - _slope(centre.values, multipliers)) for each in others]
    ways = sorted((each for each in ways if each[0] @ each[0] > 0), key=lambda each: -float(each[0] @ each[0]))
    if len(ways) < n:
        return None
    step, change = ways[0]
    found = np.eye(n) * max(abs(step @ change) / (step @ step), LEAST)
    for step, change in ways:
        found = _updated(found, step, change)
    return found


def _slope(values: Values, multipliers: np.ndarray) -> np.ndarray:
    """Gradient of the Lagrangian, (n,)."""
    found: np.ndarray = values.df - multipliers @ values.dc
    return found


def _updated(matrix: np.ndarray, step: np.ndarray, change: np.ndarray) -> np.ndarray:
    """The matrix, positive definite as before, after the change of the gradient along a step."""
    image, along = matrix @ step, float(step @ matrix @ step)
    met = float(step @ change)
    part = 1.0 if met >= DAMPED * along else (1 - DAMPED) * along / (along - met)
    change = part * change + (1 - part) * image
    found: np.ndarray = matrix - np.outer(image, image) / along + np.outer(change, change) / float(step @ change)
    return found
