"""How much lower the objective is at best, by its curvature and the slopes of constraints at one design.

    gain = max over p of  -(df . p + p . H p / 2),    c + dc p >= 0,   0 <= z + p <= top

With x = L^T p + L^-1 df and H = L L^T this is the shortest x within half-spaces, which non-negative least squares find (Lawson and Hanson,
Solving Least Squares Problems, 1974, chapter 23). A residual of slopes says nothing of it as long as nobody knows how flat the valley is.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from toolkit.studies.optimization.program import Values

FLATTEST = 1e-12
"""Curvature, in parts of the largest, or of the largest slope if that is more, below which none is told from zero: bounds of variables say
how far to go there."""


def promised(down: np.ndarray, up: np.ndarray, values: Values) -> float:
    """The gain, in units of the scaled objective; zero where the objective tells no curvature.

    Parameters
    ----------
    down, up
        How far every variable may go down and up, (n,); infinite where it has no bound.
    values
        The functions.
    """
    steep = float(np.max(np.abs(values.df)))
    if values.curvature is None or steep == 0:
        return 0.0
    curved, directions = np.linalg.eigh(values.curvature)
    axes = directions / np.sqrt(np.maximum(curved, FLATTEST * max(curved[-1], steep)))
    slope = values.df @ axes
    length = float(np.sqrt(slope @ slope))
    n = len(down)
    slack = np.maximum(np.concatenate([values.c, down, up]), 0.0)  # what is violated a little may stay so
    limits = np.isfinite(slack)
    rows = np.vstack([values.dc.reshape(-1, n), np.eye(n), -np.eye(n)])[limits] @ axes
    x = _shortest(rows, (rows @ slope - slack[limits]) / length)
    return 0.5 * length**2 * max(0.0, 1.0 - float(x @ x))


def _shortest(rows: np.ndarray, least: np.ndarray) -> np.ndarray:
    """The shortest x of rows x >= least, which at least one x no longer than one keeps."""
    matrix = np.vstack([rows.T, least])
    wanted = np.zeros(len(matrix))
    wanted[-1] = 1.0
    multipliers, _ = nnls(matrix, wanted)
    left = matrix @ multipliers - wanted
    found: np.ndarray = -left[:-1] / left[-1]
    return found
