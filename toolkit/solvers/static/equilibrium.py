"""Static equilibrium at one load factor, by Newton's iteration down to round-off."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.equations.equations import Inputs
from toolkit.foundation.errors import ConvergenceError
from toolkit.solvers.direct_solve import solve_linear
from toolkit.system.system import System

LEVELS = np.array([0.0, 0.0, 1.0])
ROUND_OFF = 1e-15
"""Correction below which nothing is left to gain. A static Newton iteration goes on, beyond its tolerance, until round-off stops it from
halving its correction: few solves, and gradients feel the last digits of the state."""
FAR = 1e3
"""Corrections of this many roundings of the coordinates are still round-off: far from the origin they are larger than any tolerance."""
SETTLED = 1e-12
"""Correction of a complex step, in parts of it, after which the next one is round-off: factors are rounded as the products of a stiffness'
entries, so that one solve leaves 2e-10 of a skin of 30 elements and 3e-9 of one of 300."""

PART = 2.0**-10
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
    reachable = max(options.tolerance, ROUND_OFF, FAR * ROUND_OFF * far)
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
        settled = step <= SETTLED or step > 0.5 * step_before
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
    step = 1.0 if system.scene.space.rotations_add else PART
    rest, low, high = np.zeros_like(q), inputs_at(system, options, factor), inputs_at(system, options, factor + step)
    terms, further = system.evaluate(low, q, rest, acc), system.evaluate(high, q, rest, acc)
    change = (further.inertial + further.applied - terms.inertial - terms.applied) / step
    tangent = solve_linear(system, static_matrix(system, terms), -change, f"statics at load factor {factor:g}")
    return Equilibrium(q, acc, tangent)
