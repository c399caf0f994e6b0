"""Static equilibrium with load stepping along a path that is followed, never jumped."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from toolkit.equations import Inputs
from toolkit.errors import ConvergenceError, SingularSystemError
from toolkit.run_options import RunOptions
from toolkit.solution import Solution
from toolkit.solvers.direct_solve import solve_linear
from toolkit.solvers.elastic_force import elastic_force, without_stiffness
from toolkit.solvers.modes import solve_modes
from toolkit.system import System

LEVELS = np.array([0.0, 0.0, 1.0])
SMALLEST_STEP = 1e-4
"""Part of the load below which a step is not halved any more: the path ends there, at a limit point or bifurcation."""
ROUND_OFF = 1e-15
"""Correction below which nothing is left to gain. A static Newton iteration goes on, beyond its tolerance, until round-off stops it from
halving its correction: few solves, and gradients feel the last digits of the state."""
FREE_CORRECTION, TRUSTED_CORRECTION = 1e-3, 0.5
"""Newton may move a predicted state by this part of the scene's size, or by this part of the predictor; more would be a jump."""


class Equilibrium(NamedTuple):
    """State at one load factor: coordinates padded to n, [0; lam], and the direction in which the load moves both."""

    q: np.ndarray
    acc: np.ndarray
    tangent: np.ndarray


def solve_statics(
    system: System, options: RunOptions | None = None, progress: Callable[[int, int], None] | None = None
) -> Solution:
    """Equilibrium under the loads at the end time, reached from the undeformed state; with its design derivatives.

    Loads and gravity grow in proportion, drivers move from their first to their last value. The step is halved where Newton
    fails, or where it strays from the tangent of the path.

    Raises
    ------
    ConvergenceError
        The path ends before the full load: a limit point (snap-through) or an unstable equilibrium.
    SingularSystemError
        Something is free to move, or joints are redundant.
    """
    options = options or system.scene.solver
    begun = clock.perf_counter()
    q = system.start()[0]
    state, count = _equilibrium(system, options, 0.0, q, np.zeros_like(q))
    factor, step, accepted = 0.0, 1.0 / options.load_steps, 0
    while factor < 1 - 1e-12:
        target = min(1.0, factor + step)
        try:
            state, iterations = _advance(system, options, state, factor, target)
        except ConvergenceError as error:
            step /= 2
            if step < SMALLEST_STEP:
                raise ConvergenceError(
                    f"the static path ends at {100 * factor:.1f} % of the load ({error}). There is a limit point or an unstable "
                    "equilibrium: a transient run with a fine step can follow the snap-through; a smaller load stays below it."
                ) from error
            continue
        factor, count, accepted = target, count + iterations, accepted + 1
        if progress:
            progress(round(100 * factor), 100)
    solution = _with_sensitivities(system, options, state, count, begun)
    if system.compiled:
        refuse_unstable(solution)
    return solution


def refuse_unstable(solution: Solution) -> None:
    """An equilibrium that the smallest disturbance ends is none that anybody will see: some frequency's square is negative."""
    try:
        modes = solve_modes(solution, 1)
    except SingularSystemError:
        return  # nothing can move, or following forces make it flutter, which is no matter of statics
    if modes.frequencies[0] < 0:
        worst = int(np.argmax(np.abs(modes.shapes[:, 0]) * solution.system.weights[: len(modes.shapes)]))
        raise ConvergenceError(
            f"the equilibrium is unstable: {solution.system.numbering.names[worst]} would run away from it (buckling, or a point "
            "past a snap-through). Use less load, add stiffness there, or follow the motion with a transient run."
        )


def _inputs(system: System, options: RunOptions, factor: float) -> Inputs:
    """What acts at a load factor: loads scaled by it, drivers between their first and last value."""
    first, last = (system.inputs(time, LEVELS) for time in (0.0, options.end_time))
    curves, curves_x = last.curves.copy(), last.curves_x.copy()
    driven = [c for c in system.plan.joints.curve if c >= 0]
    curves[driven] = first.curves[driven] + factor * (last.curves[driven] - first.curves[driven])
    pairs = np.isin(system.plan.curve_index, driven)
    curves_x[pairs] = first.curves_x[pairs] + factor * (last.curves_x[pairs] - first.curves_x[pairs])
    return Inputs(curves, curves_x, factor, LEVELS)


def _matrix(system: System, terms) -> np.ndarray:
    """d residual / d [q; lam] on the pattern."""
    of_multiplier = system.plan.indices >= system.n_q
    return np.where(of_multiplier, terms.I_acc, terms.I_q + terms.A_q)


def _equilibrium(
    system: System, options: RunOptions, factor: float, q: np.ndarray, acc: np.ndarray, allowed: float = np.inf
) -> tuple[Equilibrium, int]:
    """Newton at one load factor, down to round-off; refuses to move any coordinate by more than `allowed`."""
    inputs, rest, n_q = _inputs(system, options, factor), np.zeros_like(q), system.n_q
    soft, stiffness = without_stiffness(system)
    moved, size = np.zeros_like(q), np.inf
    for iteration in range(options.max_iterations):
        terms = soft.evaluate(inputs, q + moved, rest, acc)
        residual = terms.inertial + terms.applied + elastic_force(system, q + moved)
        terms.A_q[:] += stiffness
        correction = solve_linear(system, _matrix(system, terms), residual, f"statics at load factor {factor:g}")
        moved[:n_q] -= correction[:n_q]
        acc = acc - np.where(np.arange(system.n) < n_q, 0, correction)
        weighted = system.weights[:n_q] * np.abs(np.real(correction[:n_q]))
        before, size = size, weighted.max(initial=0)
        strayed = (system.weights * np.abs(np.real(moved)))[:n_q].max(initial=0)
        if not np.isfinite(size) or strayed > allowed:
            raise ConvergenceError(f"Newton strays from the path at {system.numbering.names[int(np.argmax(weighted))]}")
        if (size <= max(options.tolerance, ROUND_OFF) and size > 0.5 * before) or size <= ROUND_OFF:
            return _with_tangent(system, options, factor, q + moved, acc), iteration + 1
    worst = system.numbering.names[int(np.argmax(weighted))]
    raise ConvergenceError(
        f"Newton did not converge in {options.max_iterations} iterations: correction {size:.1e} > {options.tolerance:.1e}, "
        f"largest in {worst}"
    )


def _with_tangent(system: System, options: RunOptions, factor: float, q: np.ndarray, acc: np.ndarray) -> Equilibrium:
    """Add the direction of the path, d [q; lam] / d factor; the residual is linear in the factor apart from a driver's turning axis."""
    rest, low, high = np.zeros_like(q), _inputs(system, options, factor), _inputs(system, options, factor + 1)
    terms, further = system.evaluate(low, q, rest, acc), system.evaluate(high, q, rest, acc)
    change = further.inertial + further.applied - terms.inertial - terms.applied
    tangent = solve_linear(system, _matrix(system, terms), -change, f"statics at load factor {factor:g}")
    return Equilibrium(q, acc, tangent)


def _advance(system: System, options: RunOptions, state: Equilibrium, factor: float, target: float) -> tuple[Equilibrium, int]:
    """Follow the tangent to the next load factor, then correct."""
    n_q, step = system.n_q, (target - factor) * state.tangent
    moved = np.where(np.arange(system.n) < n_q, step, 0)
    reach = (system.weights * np.abs(np.real(moved)))[:n_q].max(initial=0)
    allowed = FREE_CORRECTION + TRUSTED_CORRECTION * reach
    try:
        return _equilibrium(system, options, target, state.q + moved, state.acc + step - moved, allowed)
    except SingularSystemError as error:
        raise ConvergenceError(str(error)) from error


def _with_sensitivities(system: System, options: RunOptions, state: Equilibrium, count: int, begun: float) -> Solution:
    """One more factorization at the end state, one block solve for all design variables."""
    solved = clock.perf_counter()
    rest, n_q, n_x = np.zeros_like(state.q), system.n_q, system.n_x
    dq = np.zeros((system.n, n_x))
    dacc = np.zeros((system.n, n_x))
    if n_x:
        terms = system.evaluate(_inputs(system, options, 1.0), state.q, rest, state.acc, design=True)
        change = solve_linear(system, _matrix(system, terms), -(terms.I_x + terms.A_x), "static sensitivities")
        dq[:n_q], dacc[n_q:] = change[:n_q], change[n_q:]
    states = tuple(item[None] for item in (state.q, rest, state.acc, dq, np.zeros_like(dq), dacc))
    wall = {"run": clock.perf_counter() - begun, "sensitivity": clock.perf_counter() - solved}
    return Solution.from_padded(system, np.array([options.end_time]), states, newton_iterations=count, wall=wall)
