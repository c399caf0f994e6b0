"""The shape that a flexible body starts in: the written displacements of some of its points, and the least strain energy that allows them.

    minimise q^T K q / 2   with   Z_P q = u_P of every written point P:     q = K^-1 Z^T (Z K^-1 Z^T)^-1 u

It is the shape in which forces at these points hold the body at rest, so that a beam that is let go was plucked there.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.foundation.errors import InputError

AXES = "xyz"
STILL = 1e-12
"""Flexibility, a part of the largest of the written displacements, below which no deformation moves a point that way."""
INDEPENDENT = 1e-9
"""Least eigenvalue of the flexibility, scaled to a unit diagonal, of displacements that can be chosen each on its own."""
TAKES_PART = 1e-6
"""Square of a displacement's part in those that cannot, from which it is named."""


def start_shape(stiffness: np.ndarray, points: dict[str, tuple[np.ndarray, np.ndarray]], where: str) -> np.ndarray:
    """Elastic coordinates (n_f,) at the start, or their velocities, real or complex.

    Parameters
    ----------
    stiffness : (n_f, n_f)
    points : point -> Z_P (d, n_f) of the elastic coordinates, and the written displacement u_P (d,) or its velocity
    where : path of the body's key, for messages

    Raises
    ------
    InputError
        No deformation moves a point as it is written, or not beside the others; names it.
    """
    Z = np.concatenate([rows for rows, _ in points.values()])
    u = np.concatenate([np.asarray(wish) for _, wish in points.values()])
    names = [(point, AXES[k]) for point, (rows, _) in points.items() for k in range(len(rows))]
    scale = 1 / np.sqrt(np.diag(np.real(stiffness)))
    flexible = scale[:, None] * _solved(scale[:, None] * stiffness * scale, scale[:, None] * Z.T, where)
    compliance = Z @ flexible
    size = np.real(np.diag(compliance))
    moves = size > STILL * size.max(initial=0)
    for (point, axis), wish, free in zip(names, u, moves, strict=True):
        if not free and wish != 0:
            raise InputError(
                f"{where}.{point} asks for a displacement along {axis} of the body's own axes, but no deformation of the body moves the "
                "point that way: its reduced model holds it there, or has no shape for it. Write zero there, or another point."
            )
    chosen = compliance[np.ix_(moves, moves)]
    _refuse_dependent(
        np.real(chosen), [f"{point}.{axis}" for (point, axis), free in zip(names, moves, strict=True) if free], where
    )
    found: np.ndarray = flexible[:, moves] @ np.linalg.solve(chosen, u[moves])
    return found


def _solved(matrix: np.ndarray, sides: np.ndarray, where: str) -> Any:
    try:
        return np.linalg.solve(matrix, sides)
    except np.linalg.LinAlgError as error:
        raise InputError(
            f"{where} has no shape of least strain energy: the body's stiffness is singular, so that a part of it moves without any. "
            "Leave it out, or fix the reduced model."
        ) from error


def _refuse_dependent(compliance: np.ndarray, names: list[str], where: str) -> None:
    """Refuse displacements of which some follow from others."""
    size = np.sqrt(np.diag(compliance))
    squares, vectors = np.linalg.eigh(compliance / np.outer(size, size))
    if len(squares) and squares[0] < INDEPENDENT:
        shares = (vectors[:, squares < INDEPENDENT] ** 2).sum(axis=1)  # whatever vectors of equal ones the processor finds
        tied = [name for name, share in zip(names, shares, strict=True) if share > TAKES_PART]
        raise InputError(
            f"{where} writes displacements that the body's shapes do not allow each on its own: {', '.join(tied)}. Leave one of the points "
            "out, or give the reduced model more shapes."
        )
