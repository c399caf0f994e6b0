"""Memory of analyses whose matrices are dense, counted before they begin."""

from __future__ import annotations

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError
from toolkit.foundation.memory_sizes import GIGABYTE, in_gigabytes
from toolkit.system.system import System

COPIES = 4
"""Copies of the matrix of an equilibrium: itself, scaled, its factors, and what LAPACK works in."""


def check_dense(system: System, options: RunOptions) -> None:
    """Refuse an equilibrium whose matrices do not fit into memory.

    Raises
    ------
    InputError
        They need more than `solver.memory`.
    """
    needed = 8 * COPIES * system.n**2
    if needed > GIGABYTE * options.memory:
        raise InputError(
            f"the equilibrium of {system.n} unknowns takes dense matrices of {in_gigabytes(needed)}, more than solver.memory = "
            f"{options.memory:g} GB. Describe it by fewer bodies, let a damped transient run find it, whose matrices are sparse, or raise "
            "solver.memory on a larger machine."
        )
