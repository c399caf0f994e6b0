"""Motions of the given positions that neither joints nor stiffness resist while there are no loads."""

from __future__ import annotations

from functools import partial

import numpy as np
import scipy

from toolkit.bodies.rigid import SpatialRigidBody
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.listed_names import quoted
from toolkit.foundation.near_ties import first_largest
from toolkit.solvers.free_motions import free_motions
from toolkit.solvers.static.equilibrium import inputs_at, static_matrix
from toolkit.system.system import System

SLACK = 1e-10
"""Stiffness, in parts of the largest, that is none: those of a thin body and of its bearing are some eight orders apart."""
TAKES_PART = 0.1
"""Part of the largest movement from which a coordinate takes part."""
ASIDE = 1e-9
"""Of the line between two joints: how far the centre of mass may be off it so that weight does not turn the body about it."""
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
        f"support or a spring missing? `ffrf render SCENE --free-motions` draws them.{''.join(map(partial(_told_idle, system), bodies))}"
    )


def _told_idle(system: System, body: str) -> str:
    """A sentence on a rigid body between two spherical joints, which turns about the line through both and moves nothing else."""
    scene = system.scene
    written, joints = scene.bodies.get(body), {name: each for name, each in scene.joints.items() if body in each.bodies}
    if not isinstance(written, SpatialRigidBody) or [each.kind for each in joints.values()] != ["spherical"] * 2:
        return ""
    points = [point for each in joints.values() for gripped, point in each.grips if gripped == body]
    start, end = (np.real(scene.position(point)) for point in points)
    line, centre = end - start, np.real(written.mass_properties(system.scene)[1])
    aside = np.cross(line, centre - start)
    if not line @ line > 0 or np.sqrt(aside @ aside) > ASIDE * (line @ line):
        return ""
    first = np.cross(line, np.eye(3)[first_largest(-np.abs(line))])
    axes = [(each / np.sqrt(each @ each)).round(9).tolist() for each in (first, np.cross(line, first))]
    return (
        f" {body!r} turns idly about the line through {points[0]!r} and {points[1]!r}, which moves nothing else. Fix: write "
        f'joints.{[*joints][1]} with type = "universal" and axes_of_cross = {axes}, which holds this turn and bears nothing.'
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
