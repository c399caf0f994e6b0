"""Frozen reduced bases: which parameters turn the shapes that a body needs, and the same body in more shapes, as its file holds it.

A change of scale, K -> a K or M -> b M, leaves the span of modes and constraint modes what it is, also where it is another one of
coordinates that nothing couples to the rest, as those along a straight bar and across it. All else turns it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.model import ReducedModel

RICHER_PARTS = (
    "richer_invariants",
    "richer_derivatives",
    "richer_affine",
    "richer_interfaces",
    "richer_shape",
    "richer_spin",
    "richer_surface_loads",
)
"""Parts of a reduced model that hold the body in more shapes."""
PROPORTIONAL_TOLERANCE = 1e-6
"""Part of the derivative of a matrix that is not along the matrix itself, up to which the parameter scales it."""
UNCOUPLED_ENTRY = 1e-9
"""Entry of such a matrix, measured by those on its diagonal, up to which it is the round-off of none."""
STEP = 1e-30
"""Imaginary step of a parameter, in parts of it."""


class RicherModel(str):
    """Path of a reduced model's file, where its richer basis is meant."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, RicherModel) and str(self) == str(other)

    def __hash__(self) -> int:
        return hash((RicherModel, str(self)))


def is_frozen(model: ReducedModel) -> bool:
    """Whether a model's basis has fewer shapes than the nodes allow, and stays the same when the design changes."""
    return model.basis.startswith("frozen") and not model.keeps_all


def richer_model(model: ReducedModel) -> ReducedModel:
    """Reduced model with the richer basis, of a model that was loaded with `RICHER_PARTS`; it has no pictures."""
    key = ("in more shapes",)
    if key not in model.told:
        assert model.richer_invariants is not None
        changed: dict[str, Any] = dict.fromkeys(("mesh", "outline", "interior", "surface", "left_out_shapes", *RICHER_PARTS))
        changed |= {name.removeprefix("richer_"): getattr(model, name) for name in RICHER_PARTS}
        model.told[key] = replace(model, **changed, left_out={})
    found: ReducedModel = model.told[key]
    return found


def turns(model: ReducedModel, parameter: str) -> bool:
    """Whether a parameter turns the shapes that the body needs.

    To be asked of a model with the richer basis, as few shapes show less of it.
    """
    key = ("turned by", parameter)
    if key not in model.told:
        model.told[key] = _turns(model, parameter)
    return bool(model.told[key])


def _turns(model: ReducedModel, parameter: str) -> bool:
    value = model.nominal[parameter]
    point = DesignPoint(model, {parameter: value + 1j * STEP * (abs(value) or 1.0)})
    matrices = [point.value("stiffness"), _elastic_mass(point)]
    alone = _apart([np.real(matrix) for matrix in matrices])
    return any(not _scaled(np.real(each), np.imag(each) / STEP, alone) for each in matrices)


def _apart(matrices: list[np.ndarray]) -> np.ndarray:
    """Number of the group of each coordinate (n_f,); groups, such as stretching and bending, are not coupled."""
    from scipy.sparse.csgraph import connected_components  # which a run without frozen bases need not import

    coupled = np.any([np.abs(_measured(matrix, matrix)) > UNCOUPLED_ENTRY for matrix in matrices], axis=0)
    found: np.ndarray = connected_components(coupled)[1]
    return found


def _elastic_mass(point: DesignPoint) -> np.ndarray:
    """Mass of the elastic coordinates (n_f, n_f)."""
    inv = point.invariants()
    return np.asarray(inv.inertia_about_origin[1:, 1:])


def _scaled(matrix: np.ndarray, change: np.ndarray, group: np.ndarray) -> bool:
    """Whether a change is proportional to the matrix in each group of coordinates, and couples no groups."""
    size, moved = _measured(matrix, matrix), _measured(change, matrix)
    for each in np.unique(group):
        own = np.ix_(group == each, group == each)
        moved[own] -= np.sum(moved[own] * size[own]) / np.sum(size[own] ** 2) * size[own]
    return bool(np.linalg.norm(moved) <= PROPORTIONAL_TOLERANCE * np.linalg.norm(size))


def _measured(matrix: np.ndarray, by: np.ndarray) -> np.ndarray:
    """Matrix scaled so that each coordinate is measured by its diagonal entry in another matrix."""
    root = np.sqrt(np.diag(by))
    return np.asarray(matrix / np.outer(root, root))
