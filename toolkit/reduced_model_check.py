"""Refusal of reduced models that cannot be physical."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from toolkit.errors import ModelFileError
from toolkit.reduced_model import ReducedModel, generalized_mass

RIGID = 1e-12
"""Smallest eigenvalue of the mass matrix, scaled to a unit diagonal, that is more than round-off; the wing's skin has 1e-7."""


def check(model: ReducedModel, path: Path) -> None:
    """Refuse a model whose shapes disagree or whose matrices are not physical, naming the file and the group."""
    inv, n = model.invariants, len(model.invariants.stiffness)
    shapes = {
        "mass": (),
        "first_moment": (2, 1 + n),
        "inertia": (1 + n, 1 + n),
        "gyroscopic": (1 + n, 1 + n),
        "stiffness": (n, n),
        "damping": (n, n),
        "stress_operator": (len(inv.stress_operator), n),
    }
    for name, shape in shapes.items():
        if getattr(inv, name).shape != shape:
            _refuse(path, name, f"has shape {getattr(inv, name).shape} instead of {shape}")
    for name, sign in (("inertia", 1), ("gyroscopic", -1), ("stiffness", 1), ("damping", 1)):
        matrix = getattr(inv, name)
        if np.abs(matrix - sign * matrix.T).max(initial=0) > 1e-9 * np.abs(matrix).max(initial=0):
            _refuse(path, name, "is not " + ("symmetric" if sign > 0 else "antisymmetric"))
    if n and np.linalg.eigvalsh(generalized_mass(inv)).min() <= RIGID:
        _refuse(path, "inertia", "gives an indefinite mass matrix: the basis duplicates a rigid motion of the frame")


def _refuse(path: Path, name: str, problem: str) -> None:
    raise ModelFileError(f"{str(path)!r}: invariants/{name} {problem}. Build it again with ffrf-preprocess.")
