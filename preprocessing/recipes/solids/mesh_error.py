"""How exact the stress of a meshed body is, for a few load cases of its own: unit motions of its interface points, modes, its weight."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse.linalg import splu

from preprocessing.basis.solids.basis import SolidShapes
from preprocessing.basis.solids.ties import Freedom
from preprocessing.elements.solids.stress_error import Elastic, stress_errors
from preprocessing.mesh.solid_mesh import translations

MODES, MOST = 2, 12
"""Modes that are looked at, the lowest ones, and shapes of interface points."""
AXES = "xyz"


def mesh_error(body: Elastic | None, mass: Any, stiffness: Any, free: Freedom, shapes: SolidShapes) -> dict[str, Any]:
    """Fields of the reduced model with stress errors by load case, and the place of the largest; empty without elements.

    Parameters
    ----------
    mass, stiffness : on the independent coordinates
    """
    if body is None:
        return {}
    names, columns = _cases(body.nodes, mass, stiffness, free, shapes)
    if not names:
        return {}
    found = stress_errors(body, np.asarray(free.map @ columns))
    known = {name: float(value) for name, value in zip(names, found.relative, strict=True) if np.isfinite(value)}
    if not known:
        return {}
    place = found.place[names.index(max(known, key=lambda name: known[name]))]
    return {"stress_errors": known, "stress_error_at": dict(zip(AXES, map(float, place), strict=False))}


def _cases(nodes: np.ndarray, mass: Any, stiffness: Any, free: Freedom, shapes: SolidShapes) -> tuple[list[str], np.ndarray]:
    """Names of load cases, and their shapes on the independent coordinates."""
    if shapes.system is None:
        return _weights(nodes, mass, stiffness, free)
    n_modes = shapes.modes.count if shapes.modes else 0
    n_static = shapes.columns.shape[1] - n_modes
    static, modes = min(n_static, MOST), min(n_modes, MODES)
    names = [f"interface shape {k + 1}" for k in range(static)] + [f"mode {k + 1}" for k in range(modes)]
    return names, shapes.columns[:, [*range(static), *range(n_static, n_static + modes)]]


def _weights(nodes: np.ndarray, mass: Any, stiffness: Any, free: Freedom) -> tuple[list[str], np.ndarray]:
    """Bending under its own weight along the axes, of a body that keeps all coordinates; nothing if it is not held."""
    factors = splu(stiffness.tocsc())
    pivots = np.abs(factors.U.diagonal())
    if pivots.min() <= np.finfo(float).eps * len(pivots) * pivots.max():
        return [], np.zeros((mass.shape[0], 0))
    along = free.map.T @ translations(*nodes.shape)
    return [f"weight along {axis}" for axis in AXES[: nodes.shape[1]]], factors.solve(np.asarray(mass @ along))
