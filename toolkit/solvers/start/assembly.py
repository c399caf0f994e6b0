"""Closing the joints before a run starts: the positions next to the given ones that satisfy every joint, and how they follow the design.

    [M(q) + (1 s)^2 K] (q - q_given) + phi_q(q)^T mu = 0,    phi(q, t) = 0

Mass measures "next to", as it does for the velocities at the start, and strain energy keeps flexible bodies from being bent where
they can just as well be moved (both systems of units count time in seconds). Solved by Newton's method; the same matrix gives dq/dx.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from toolkit.bodies.kernels.constant_kernel import together
from toolkit.equations.equations import Terms
from toolkit.foundation.errors import ConvergenceError, SingularSystemError
from toolkit.foundation.near_ties import first_largest
from toolkit.solvers.closing.open_joints import repeat_each_other, search, told_gap
from toolkit.solvers.closing.rigid_bodies import RigidBodies
from toolkit.solvers.direct_solve import solve_linear
from toolkit.system.system import System

CLOSED = 1e-13
"""Last correction, as a part of the model size: Newton's method is quadratic, so that round-off is left."""
ROUND_OFF = 1e-13
"""Correction, per distance of the bodies from the origin, that is round-off if it does not shrink any more."""
REACH = 0.3
"""Furthest move that is an adjustment, as a part of the model size; more is another configuration, or a mistake. Of a rotation half the
angle counts, as it does in the quaternions of bodies in space: bodies turn by up to 0.6 rad."""
MOST = 30
LEVELS = np.array([0.0, 0.0, 1.0])
WHERE = "closing of the joints at the start"


def assemble(system: System, given: np.ndarray, dgiven: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n,) that satisfy every joint, and their design derivatives (n, n_x), from given ones.

    Raises
    ------
    ConvergenceError
        The joints do not close near the given positions; names the coordinate that would move furthest.
    SingularSystemError
        Joints are redundant.
    """
    stiff = stiffened(system)
    try:
        q, acc = _closed(stiff, given, time)
    except (ConvergenceError, SingularSystemError) as error:
        told = _told_by_search(system, given, time)
        if told:
            raise ConvergenceError(told) from error
        raise
    return q, _change(stiff, q, acc, dgiven, time) if system.n_x else dgiven


def _closed(system: System, given: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions, and [q - q_given; mu] there, (n,) each; of a system of `stiffened`."""
    is_q, q, acc, largest, before = np.arange(system.n) < system.n_q, given.copy(), np.zeros_like(given), np.inf, np.inf
    counted = _counted(system)
    far = (system.weights * np.abs(np.real(given)))[: system.n_q].max()
    for _ in range(MOST):
        stagnated = largest <= ROUND_OFF * far and largest > 0.5 * before
        closed = largest <= CLOSED or stagnated  # once more then: an imaginary part is as exact as the last solve
        terms = _evaluate(system, q, acc, time)
        step = solve_linear(system, _matrix(system, terms), -np.where(is_q, terms.inertial, terms.applied), WHERE)
        q, acc = q + np.where(is_q, step, 0), acc + step
        near = np.all(counted * np.abs(np.real(q - given))[: system.n_q] <= REACH)
        if closed and near:
            return q, acc
        if closed or not near:
            break
        before, largest = largest, (system.weights * np.abs(np.real(step)))[: system.n_q].max()
    raise ConvergenceError(_far(system, given, q))


def _change(system: System, q: np.ndarray, acc: np.ndarray, dgiven: np.ndarray, time: float) -> np.ndarray:
    """Design derivatives (n, n_x) of positions that `_closed` has found."""
    is_q, terms = np.arange(system.n)[:, None] < system.n_q, _evaluate(system, q, acc, time)
    change = np.where(is_q, terms.I_x - system.matrix(terms.I_acc + system.unit_of_states) @ dgiven, terms.A_x)
    return np.where(is_q, solve_linear(system, _matrix(system, terms), -change, WHERE), 0)


def _counted(system: System) -> np.ndarray:
    """Weights (n_q,) that make moves of coordinates comparable, as `REACH` counts them."""
    first, found = system.numbering.first, system.weights[: system.n_q].copy()
    found[[first[name] + body.moves for name, body in system.scene.all_bodies().items() if body.turns == 1]] /= 2  # in the plane
    return found


def _far(system: System, given: np.ndarray, q: np.ndarray) -> str:
    """A sentence on joints that close in other positions (n,) than next to the given ones."""
    i = first_largest(_counted(system) * np.abs(np.real(q - given))[: system.n_q])
    return (
        f"the joints do not close near the given positions: {system.numbering.names[i]} would move by "
        f"{system.weights[i] * abs(np.real(q - given)[i]):.2g} of the model size (or rad). Give positions, a length or a curve that fit "
        "together better."
    )


def _told_by_search(system: System, given: np.ndarray, time: float) -> str:
    """Sentence on why open joints do not close, by a search among all positions; empty if the search does not tell."""
    bodies, inputs = RigidBodies(system), system.inputs(time, LEVELS)
    found = search(bodies, inputs, given)
    if found is None:
        return ""
    if not found.closes:
        return told_gap(bodies, inputs, found)
    if repeat_each_other(bodies, inputs, found.q):
        return ""
    moved = _counted(system) * np.abs(np.real(found.q - given))[: system.n_q]
    if moved.max() > REACH:
        return _far(system, given, found.q)
    name = system.numbering.names[first_largest(moved)]
    return (
        "the joints close near the given positions, but Newton's method does not come there (it cannot from a dead point): with "
        f"{name} moved by {np.real(found.q - given)[first_largest(moved)]:+.3g} they do. Give positions nearer to those."
    )


def stiffened(system: System) -> System:
    """System with M + (1 s)^2 K in the place of M."""
    part = system.plan.constant
    everywhere = np.ones_like(part.segment_damped)  # there is a mass where there is stiffness alone otherwise
    mass = {
        "mass": part.mass + part.stiffness,
        "M": part.M + part.K,
        "design_mass": together(part.design_mass, part.design_stiffness),
        "segment_damped": everywhere,
    }
    return replace(system, plan=system.plan._replace(constant=part._replace(**mass)))


def _evaluate(system: System, q: np.ndarray, acc: np.ndarray, time: float) -> Terms:
    """Terms of the equations of assembly.

    Inertial: [M + K] (q - q_given) + phi_q^T mu with acc = [q - q_given; mu]. Applied, below: phi.
    """
    return system.evaluate(system.inputs(time, LEVELS), q, np.zeros_like(q), acc, design=True)


def _matrix(system: System, terms: Terms) -> np.ndarray:
    """Derivative by [q; mu] of the equations, values on the pattern."""
    below = np.repeat(np.arange(system.n), np.diff(system.plan.indptr)) >= system.n_q
    return terms.I_acc + system.unit_of_states + np.where(below, terms.A_q, terms.I_q)
