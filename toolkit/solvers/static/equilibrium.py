"""Static equilibrium at one load factor, by Newton's iteration down to round-off.

Change of an equilibrium by a small change of forces, to all digits of the strains.

Solved with the entries of the static matrix alone it would have the round-off of their products, which a skin of n elements makes n^4 times
larger than their sum. So what is left of the solution is found with the stiffness in its factors B^T D B, and mended.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
import scipy

from toolkit.components.bodies.rigid import SpatialRigidBody
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConvergenceError, ToolkitError, quoted
from toolkit.foundation.near_ties import first_largest
from toolkit.linear.linear_solver import strain_rows
from toolkit.solvers.direct_solve import solve_linear
from toolkit.solvers.free_motions import free_motions
from toolkit.solvers.start.rigid_bodies import told
from toolkit.system.equations import Inputs
from toolkit.system.redundant_joints import whole
from toolkit.system.system import System

LEVELS = np.array([0.0, 0.0, 1.0])
ROUND_OFF = 1e-15
"""Correction below which nothing is left to gain. A static Newton iteration goes on, beyond its tolerance, until round-off stops it from
halving its correction: few solves, and gradients feel the last digits of the state."""
COORDINATE_ROUNDINGS = 1e3
"""Corrections of this many roundings of the coordinates are still round-off: far from the origin they are larger than any tolerance."""
SETTLED_COMPLEX_STEP = 1e-12
"""Correction of a complex step, in parts of it, after which the next one is round-off: factors are rounded as the products of a stiffness'
entries, so that one solve leaves 2e-10 of a skin of 30 elements and 3e-9 of one of 300."""

DIRECTION_LOAD_PART = 2.0**-10
"""Part of the load over which its direction is taken in space, where an angle counts only up to half a turn."""


class Equilibrium(NamedTuple):
    """State at one load factor: coordinates padded to n, [0; lam], and the direction in which the load moves both."""

    q: np.ndarray
    acc: np.ndarray
    tangent: np.ndarray


def leading_curves(system: System) -> np.ndarray:
    """Time curves of loads that lead, as those of drivers do: set values of controllers."""
    loads = system.plan.loads
    found: np.ndarray = loads.curve[(loads.scaled == 0) & (loads.curve >= 0)]
    return found


def inputs_at(system: System, options: RunOptions, factor: float) -> Inputs:
    """Inputs at a load factor: loads scaled by it, drivers and set values between their first and last value."""
    first, last = (system.inputs(time, LEVELS) for time in (0.0, options.end_time))
    curves, curves_x = last.curves.copy(), last.curves_x.copy()
    driven = np.concatenate([leading_curves(system), system.plan.joints.curve[system.plan.joints.curve >= 0]])
    curves[driven] = first.curves[driven] + factor * (last.curves[driven] - first.curves[driven])
    pairs = np.isin(system.plan.curve_index, driven)
    curves_x[pairs] = first.curves_x[pairs] + factor * (last.curves_x[pairs] - first.curves_x[pairs])
    return Inputs(curves, curves_x, factor, LEVELS, True, False)


def static_matrix(system: System, terms) -> np.ndarray:
    """Static matrix d residual / d [q; lam] on the pattern, (n_entries,)."""
    of_multiplier = system.plan.indices >= system.n_q
    return np.where(of_multiplier, terms.I_acc, terms.I_q + terms.A_q)


def find_equilibrium(
    system: System, options: RunOptions, factor: float, q: np.ndarray, acc: np.ndarray, allowed: float = np.inf
) -> tuple[Equilibrium, int]:
    """Equilibrium at one load factor by Newton's iteration, down to round-off, from coordinates q (n,) and [0; lam] (n,).

    Refuses to move any coordinate by more than `allowed`, a part of the model size (or rad). Returns the state and the number of
    iterations.

    Raises
    ------
    ConvergenceError
        Newton strays, or does not converge; names the coordinate that moves most.
    SingularSystemError
        The equations have no unique solution.
    """
    inputs, rest, n_q = inputs_at(system, options, factor), np.zeros_like(q), system.n_q
    n_b, moved, size, step = system.n_b, np.zeros_like(q), np.inf, np.inf
    far = (system.weights * np.abs(np.real(q)))[:n_b].max(initial=0)
    reachable = max(options.tolerance, ROUND_OFF, COORDINATE_ROUNDINGS * ROUND_OFF * far)
    for iteration in range(options.max_iterations):
        terms = system.evaluate(inputs, q + moved, rest, acc)
        residual = terms.inertial + terms.applied
        correction = solve_linear(system, static_matrix(system, terms), residual, f"statics at load factor {factor:g}")
        moved[:n_q] -= correction[:n_q]
        acc = acc - np.where(np.arange(system.n) < n_q, 0, correction)
        weighted = system.weights[:n_b] * np.abs(np.real(correction[:n_b]))
        before, size = size, weighted.max(initial=0)
        step_before, step = step, _complex_step(system, correction, moved)
        strayed = (system.weights * np.abs(np.real(moved)))[:n_b].max(initial=0)
        if not np.isfinite(size) or strayed > allowed:
            raise ConvergenceError(f"Newton strays from the path at {system.most_moved(correction)}")
        settled = step <= SETTLED_COMPLEX_STEP or step > 0.5 * step_before
        if settled and ((size <= reachable and size > 0.5 * before) or size <= ROUND_OFF):
            return _with_tangent(system, options, factor, q + moved, acc), iteration + 1
    worst = system.most_moved(correction)
    raise ConvergenceError(
        f"Newton did not converge in {options.max_iterations} iterations: correction {size:.1e} > {options.tolerance:.1e}, "
        f"largest in {worst}"
    )


def _complex_step(system: System, correction: np.ndarray, moved: np.ndarray) -> float:
    """Imaginary part of a correction in parts of all that coordinates have moved by; 0 in real numbers."""
    sizes = [(system.weights * np.abs(np.imag(each)))[: system.n_b].max(initial=0) for each in (correction, moved)]
    return float(sizes[0] / sizes[1]) if sizes[1] > 0 else 0.0


def _with_tangent(system: System, options: RunOptions, factor: float, q: np.ndarray, acc: np.ndarray) -> Equilibrium:
    """Equilibrium with the direction of the path, d [q; lam] / d factor, added.

    The residual is linear in the factor apart from a driver's turning axis.
    """
    step = 1.0 if system.scene.space.rotations_add else DIRECTION_LOAD_PART
    rest, low, high = np.zeros_like(q), inputs_at(system, options, factor), inputs_at(system, options, factor + step)
    terms, further = system.evaluate(low, q, rest, acc), system.evaluate(high, q, rest, acc)
    change = (further.inertial + further.applied - terms.inertial - terms.applied) / step
    tangent = solve_linear(system, static_matrix(system, terms), -change, f"statics at load factor {factor:g}")
    return Equilibrium(q, acc, tangent)


MOST_REFINEMENTS = 4
"""Refinements at most: of 2000 elements the entries leave 1e-5 of a solution, and so each refinement of what was left before."""
SETTLED_SOLUTION = 1e-13
"""Change of a solution, in parts of it, after which the next one is round-off."""


def static_change(
    system: System,
    inputs: Inputs,
    q: np.ndarray,
    acc: np.ndarray,
    whole: np.ndarray,
    forces: np.ndarray,
    where: str,
    transposition: np.ndarray | None = None,
) -> np.ndarray:
    """Solution A^-1 forces with the static matrix A = [K, G; J, 0] of an equilibrium, or with its transpose.

    Parameters
    ----------
    system : System
    inputs : Inputs
        What acts.
    q, acc : (n,)
        Coordinates, and [0; lam].
    whole : (n_entries,)
        That matrix, or its transpose, on the system's pattern.
    forces : (n, columns)
    where : str
        What is solved, for messages.
    transposition : (n_entries,), optional
        Place of the transposed entry of every entry; of the transpose alone.

    Returns
    -------
    (n, columns)

    Raises
    ------
    SingularSystemError
        The equations have no unique solution.
    """
    found = solve_linear(system, whole, forces, where)
    constant = system.plan.constant
    if not len(constant.strained):
        return found
    apart = static_matrix(system, system.evaluate(inputs, q, np.zeros_like(q), acc, apart=True))
    rest = system.matrix(apart if transposition is None else apart[transposition])
    strains, weight = strain_rows(constant.strains, system.n), constant.strains.weight[:, None]
    for _ in range(MOST_REFINEMENTS):
        left = forces - rest @ found - strains.T @ (weight * (strains @ found))
        change = solve_linear(system, whole, left, where)
        found = found + change
        if _largest(system, change) <= SETTLED_SOLUTION * _largest(system, found):
            break
    return found


def _largest(system: System, change: np.ndarray) -> float:
    """Largest change of any coordinate, in parts of the model size or rad."""
    sizes = system.weights[: system.n_q, None] * np.abs(np.real(change[: system.n_q]))
    return float(sizes.max(initial=0.0))


def refuse_open_joints_left_out(system: System, options: RunOptions, q: np.ndarray) -> None:
    """Refuse an equilibrium q (n,) under the full load, in which a joint that was left out is open.

    Raises
    ------
    ConvergenceError
        Names the joint, with its gap.
    """
    rows = system.plan.dropped
    if not len(rows) or not system.compiled:
        return
    inputs, rest = inputs_at(system, options, 1.0)._replace(joints_only=True), np.zeros_like(q)
    gaps = np.real(whole(system).evaluate(inputs, q, rest, rest, linearize=False).applied)[rows]
    sizes = np.abs(gaps) * system.weights[rows]
    if sizes.max() > options.drift_tolerance:
        worst = first_largest(sizes)
        raise ConvergenceError(
            f"{system.numbering.names[rows[worst]]} was left out because other joints imply it at the start; it is open by "
            f"{told(system, int(rows[worst]), gaps[worst])} in the equilibrium: they do so in the start position alone (a folded or "
            "stretched one), or points, lengths and axes do not fit. Start elsewhere, fix them, or remove the joint that is too much."
        )


NO_STIFFNESS = 1e-10
"""Stiffness, in parts of the largest, that is none: those of a thin body and of its bearing are some eight orders apart."""
LARGE_MOVEMENT = 0.1
"""Part of the largest movement from which a coordinate takes part."""
CENTRE_OFF_AXIS = 1e-9
"""Of the line between two joints: how far the centre of mass may be off it so that weight does not turn the body about it."""
MOST_COORDINATES = 1000
"""Coordinates up to which one looks: the matrices are dense."""


def told_loose(system: System, options: RunOptions) -> str:
    """A sentence on the bodies that can move freely, and in how many ways; empty if all are held, or nothing can be said."""
    if system.n > MOST_COORDINATES:
        return ""
    try:
        motions = loose_motions(system, options)
    except (ToolkitError, np.linalg.LinAlgError):  # there is an error already that this would only explain
        return ""
    if not motions.shape[1]:
        return ""
    moved = np.linalg.norm(system.weights[: system.n_b, None] * motions, axis=1)
    bodies = system.numbering.bodies_of(np.flatnonzero(moved > LARGE_MOVEMENT * moved.max()))
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
    if not line @ line > 0 or np.sqrt(aside @ aside) > CENTRE_OFF_AXIS * (line @ line):
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
    return free @ vectors[:, np.abs(values) <= NO_STIFFNESS * np.abs(matrix[:n_b, :n_b]).max(initial=0)]
