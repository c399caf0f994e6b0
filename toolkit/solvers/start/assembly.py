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
from toolkit.foundation.errors import ConvergenceError
from toolkit.foundation.near_ties import first_largest
from toolkit.solvers.direct_solve import solve_linear
from toolkit.system.system import System

CLOSED = 1e-13
"""Last correction, as a part of the scene's size: Newton's method is quadratic, so that round-off is left."""
ROUND_OFF = 1e-13
"""Correction, per distance of the bodies from the origin, that is round-off if it does not shrink any more."""
REACH = 0.3
"""Furthest move, as a part of the scene's size or in rad, that is an adjustment; more is another configuration, or a mistake."""
MOST = 30
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
    system, is_q = stiffened(system), np.arange(system.n) < system.n_q
    q, acc, largest, before = given.copy(), np.zeros_like(given), np.inf, np.inf
    far = (system.weights * np.abs(np.real(given)))[: system.n_q].max()
    for _ in range(MOST):
        stagnated = largest <= ROUND_OFF * far and largest > 0.5 * before
        closed = largest <= CLOSED or stagnated  # once more then: an imaginary part is as exact as the last solve
        terms = _evaluate(system, q, acc, time)
        step = solve_linear(system, _matrix(system, terms), -np.where(is_q, terms.inertial, terms.applied), WHERE)
        q, acc = q + np.where(is_q, step, 0), acc + step
        moved = (system.weights * np.abs(np.real(q - given)))[: system.n_q]
        if closed or not np.all(moved <= REACH):
            break
        before, largest = largest, (system.weights * np.abs(np.real(step)))[: system.n_q].max()
    if not closed or not np.all(moved <= REACH):
        raise ConvergenceError(
            f"the joints do not close near the given positions: {system.numbering.names[first_largest(moved)]} would move by "
            f"{moved.max():.2g} of the scene's size (or rad). Give positions, a length or a curve that fit together better."
        )
    if not system.n_x:
        return q, dgiven
    terms = _evaluate(system, q, acc, time)
    change = np.where(is_q[:, None], terms.I_x - system.matrix(terms.I_acc + system.unit_of_states) @ dgiven, terms.A_x)
    return q, np.where(is_q[:, None], solve_linear(system, _matrix(system, terms), -change, WHERE), 0)


def stiffened(system: System) -> System:
    """The same system with M + (1 s)^2 K in the place of M."""
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
    """Inertial: [M + K] (q - q_given) + phi_q^T mu with acc = [q - q_given; mu]. Applied, below: phi."""
    return system.evaluate(system.inputs(time, np.array([0.0, 0.0, 1.0])), q, np.zeros_like(q), acc, design=True)


def _matrix(system: System, terms: Terms) -> np.ndarray:
    """Derivative by [q; mu] of the equations, values on the pattern."""
    below = np.repeat(np.arange(system.n), np.diff(system.plan.indptr)) >= system.n_q
    return terms.I_acc + system.unit_of_states + np.where(below, terms.A_q, terms.I_q)
