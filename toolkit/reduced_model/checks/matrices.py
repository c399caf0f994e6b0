"""Refusal of matrices that are not symmetric, or of a mass that is not positive."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from toolkit.reduced_model.checks.refusal import refuse
from toolkit.reduced_model.definiteness import positive_definite
from toolkit.reduced_model.entry_scales import EntryScale, entry_factors
from toolkit.reduced_model.model import Invariants, ReducedModel, generalized_mass
from toolkit.reduced_model.parts.left_out_shapes import count_of_loads
from toolkit.reduced_model.parts.spin import SPIN_STIFFENING
from toolkit.reduced_model.spatial_model import SpatialInvariants, spatial_generalized_mass
from toolkit.reduced_model.thin_arrays import listed, sparing

RIGID = 1e-13
"""Smallest eigenvalue of the mass matrix, scaled to a unit diagonal, that is more than round-off; the wing's skin has 1e-7, and with 2000
elements 4e-13."""

ROUND_OFF = 1e-9
"""Largest relative difference of two numbers that should be equal; sums over some hundred nodes leave 1e-13."""

OF_STIFFNESS = ("stiffness", "damping", "stress_operator")
"""Invariants that are not made of mass."""


def check_matrices(inv: Invariants | SpatialInvariants, path: Path) -> None:
    """Refuse invariants that are not symmetric but for round-off, or whose mass is not positive definite."""
    own: dict[str, tuple[np.ndarray, int]]
    scales = entry_sizes(inv)
    if isinstance(inv, SpatialInvariants):
        own = {f"second_moment[{k}]": (inv.second_moment[k], 1) for k in range(3)}
        root = scales["second_moment"].column
        scales |= {f"second_moment[{k}]": EntryScale(root, root) for k in range(3)}
        place, mass = "second_moment", spatial_generalized_mass(inv)
    else:
        own = {"inertia": (inv.inertia, 1), "gyroscopic": (inv.gyroscopic, -1)}
        place, mass = "inertia", generalized_mass(inv)
    for name, (matrix, sign) in {**own, "stiffness": (inv.stiffness, 1), "damping": (inv.damping, 1)}.items():
        entry, difference = listed(abs(sparing(matrix) - sign * sparing(matrix).T))
        if np.any(difference > ROUND_OFF * scales[name].at(entry)):
            refuse(path, f"invariants/{name}", "is not " + ("symmetric" if sign > 0 else "antisymmetric"))
    if not positive_definite(mass - RIGID * np.eye(len(mass))):
        refuse(
            path,
            f"invariants/{place}",
            "gives an indefinite mass matrix: the basis duplicates a rigid motion of the frame",
        )


def check_spin(stiffening: np.ndarray, count: int, path: Path) -> None:
    """Refuse spin stiffening that is not one symmetric matrix in the plane, or six in space."""
    if len(stiffening) != count:
        refuse(path, SPIN_STIFFENING.replace(".", "/"), f"has {len(stiffening)} matrices instead of {count}")
    if np.abs(stiffening - stiffening.swapaxes(1, 2)).max(initial=0) > ROUND_OFF * np.abs(stiffening).max(initial=0):
        refuse(path, SPIN_STIFFENING.replace(".", "/"), "is not symmetric")


def check_left_out(model: ReducedModel, path: Path) -> None:
    """Refuse a compliance that is not symmetric, or has another number of loads than the body can have."""
    found, points = model.left_out_shapes, model.interfaces
    if found is None:
        return
    wanted = None if points is None else count_of_loads(len(points), model.dimension, model.n_f)
    if wanted is not None and len(found) != wanted:
        refuse(path, "left_out_shapes/compliance", f"has {len(found)} loads instead of {wanted}")
    if len(found.stress_operator) != model.invariants.stress_operator[..., 0].size:
        refuse(path, "left_out_shapes/stress_operator", "has another number of rows than invariants/stress_operator")
    scale = np.sqrt(np.diag(found.compliance).clip(0.0))
    if np.any(np.abs(found.compliance - found.compliance.T) > ROUND_OFF * np.outer(scale, scale)):
        refuse(path, "left_out_shapes/compliance", "is not symmetric")


def check_sections(model: ReducedModel, path: Path) -> None:
    """Refuse sections whose stiffness or mass is not positive, or that bend in another number of planes than the beams."""
    found = model.sections
    assert found is not None
    for name in ("stress_per_strain", "axial_stiffness", "bending_stiffness", "mass_per_length"):
        if not (getattr(found, name) > 0).all():
            refuse(path, f"sections/{name}", "holds numbers that are not positive")
    for name in ("torsional_stiffness", "shear_stiffness"):
        if not (getattr(found, name) >= 0).all():
            refuse(path, f"sections/{name}", "holds negative numbers")
    if found.bending_stiffness.shape[1] != model.dimension - 1:
        refuse(
            path, "sections/bending_stiffness", f"has {found.bending_stiffness.shape[1]} columns instead of {model.dimension - 1}"
        )


def entry_sizes(inv: Invariants | SpatialInvariants) -> dict[str, EntryScale]:
    """Sizes that differences in the entries of the invariants are compared with.

    Whatever is a matter of mass can vanish as a whole, but for round-off, and is compared with what it could be. Stiff bodies
    leave more round-off in their soft motions than these are stiff: stiffness, damping and stress, which do not vanish, are
    compared with their largest entry.
    """
    return entry_factors(inv) | {name: largest(getattr(inv, name)) for name in OF_STIFFNESS}


def largest(array: np.ndarray) -> EntryScale:
    """Entry scale that is the array's largest entry everywhere."""
    rows = sparing(array)
    return EntryScale(
        np.full(len(array.reshape(-1, array.shape[-1])), abs(rows).max() if array.size else 0.0), np.ones(array.shape[-1])
    )
