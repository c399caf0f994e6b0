"""Motions of the given positions that neither joints nor stiffness resist while there are no loads."""

from __future__ import annotations

import numpy as np
import scipy

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.listed_names import quoted
from toolkit.solvers.free_motions import free_motions
from toolkit.solvers.static.equilibrium import inputs_at, static_matrix
from toolkit.system.system import System

SLACK = 1e-10
"""Stiffness, in parts of the largest, that is none: those of a thin body and of its bearing are some eight orders apart."""
TAKES_PART = 0.1
"""Part of the largest movement from which a coordinate takes part."""
MOST = 1000
"""Coordinates up to which one looks: the matrices are dense."""


def told_loose(system: System, options: RunOptions) -> str:
    """A sentence on the bodies that can move freely, and in how many ways; empty if all are held, or nothing can be said."""
    if system.n > MOST:
        return ""
    try:
        motions = loose_motions(system, options)
    except (ToolkitError, np.linalg.LinAlgError):  # there is an error already that this would only explain
        return ""
    if not motions.shape[1]:
        return ""
    moved = np.linalg.norm(system.weights[: system.n_b, None] * motions, axis=1)
    bodies = system.numbering.bodies_of(np.flatnonzero(moved > TAKES_PART * moved.max()))
    ways = motions.shape[1]
    return (
        f" Without loads {quoted(bodies)} can move freely in {ways} way{'s' * (ways > 1)}, which no joint and no stiffness prevents: is a "
        "support or a spring missing? `ffrf render SCENE --free-motions` draws them."
    )


def loose_motions(system: System, options: RunOptions) -> np.ndarray:
    """Orthonormal motions (n_b, k) of the given positions, in the units of the weights, that joints allow and nothing stiff resists."""
    n_b = system.n_b
    q, rest = system.undeformed()[0], np.zeros(system.n)
    terms = system.evaluate(inputs_at(system, options, 0.0), q, rest, rest)
    matrix = np.real(system.dense(static_matrix(system, terms)))
    free = free_motions(matrix[:n_b, n_b:].T, system.weights[:n_b])
    stiffness = free.T @ matrix[:n_b, :n_b] @ free
    if not free.shape[1] or not np.all(np.isfinite(stiffness)):
        return free[:, :0]
    values, vectors = scipy.linalg.eigh((stiffness + stiffness.T) / 2)
    return free @ vectors[:, np.abs(values) <= SLACK * np.abs(matrix[:n_b, :n_b]).max(initial=0)]
