"""Elastic forces in extended precision, for equilibria down to round-off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from toolkit.system import System


def without_stiffness(system: System) -> tuple[System, np.ndarray]:
    """The same system without its constant stiffness, and that stiffness on the common pattern (n_entries,)."""
    part = system.plan.constant
    stiffness: np.ndarray = np.zeros(len(system.plan.indices), system.dtype)
    np.add.at(stiffness, part.position, part.stiffness)
    plan = system.plan._replace(constant=part._replace(stiffness=np.zeros_like(part.stiffness)))
    return replace(system, plan=plan), stiffness


def elastic_force(system: System, q: np.ndarray) -> np.ndarray:
    """K q, (n,), with its sums in extended precision.

    A thin body is a million times stiffer in stretching than in bending, so that its elastic forces are small differences of large
    products. Their round-off in double precision would move the equilibrium by 1e-11 of the scene's size, and gradients feel that.
    """
    part = system.plan.constant
    force = np.zeros(len(q), np.result_type(q, np.longdouble))
    np.add.at(force, part.row, part.stiffness * q[part.column].astype(force.dtype))
    return force.astype(q.dtype)
