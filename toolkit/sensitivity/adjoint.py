"""Gradients by the discrete adjoint: one backward run for all design variables, exact for the discrete equations as the direct method.

    f = f(q_n, v_n, lam_n, x),   df/dx = f_x + sum over steps of mu_n^T R_x + (start's part)

Worth it where variables are many and responses few; `sensitivity.analysis` and the command line offer it as a method.
"""

from __future__ import annotations

import time as clock
from dataclasses import replace

import numpy as np

from toolkit.errors import InputError, SingularSystemError
from toolkit.responses.response import Partials
from toolkit.scene import Scene
from toolkit.sensitivity.analysis import Kind, Progress, Result, moving, prepare, responses_of, result, timed
from toolkit.solution import Solution
from toolkit.solvers.adjoint_steps import adjoint_memory, integrate_backwards
from toolkit.solvers.direct_solve import solve_linear
from toolkit.solvers.equilibrium import inputs_at, static_matrix
from toolkit.solvers.initial_conditions import consistent_start
from toolkit.solvers.scheme import generalized_alpha
from toolkit.solvers.transient import constraint_levels
from toolkit.system import System


def adjoint(scene: Scene, design: list[str], kind: Kind, progress: Progress | None = None) -> Result:
    """Responses with gradients by the discrete adjoint; parameters and errors as `sensitivity.analysis.direct`."""
    primal, solution = timed(prepare(scene), kind, progress)
    system = prepare(scene, design)
    begun = clock.perf_counter()
    found, gradient = adjoint_gradients(system, solution)
    extra = clock.perf_counter() - begun
    values = {name: partials.value for name, partials in found.items()}
    return result(scene, solution, values, by_name(system, found, gradient), "adjoint", primal, extra)


def by_name(system: System, found: dict[str, Partials], gradient: np.ndarray) -> dict[str, dict[str, float]]:
    """What `adjoint_gradients` returns, as response -> variable -> derivative."""
    columns = zip(found, gradient.T, strict=True)
    return {name: dict(zip(system.design.names, map(float, column), strict=True)) for name, column in columns}


def adjoint_gradients(system: System, solution: Solution) -> tuple[dict[str, Partials], np.ndarray]:
    """Partials of all responses of the scene, and their gradients (n_x, n_r).

    Parameters
    ----------
    system : System
        The scene compiled with the design variables.
    solution : Solution
        Of the same scene; derivatives in it only tell whether a length that is zero would grow.

    Raises
    ------
    SingularSystemError
        A step's transposed equations have no unique solution.
    InputError
        A response needs the states' own derivatives (a length that is zero), or the run had a start of its own.
    """
    if solution.own_start:
        raise InputError("the run has a start of its own, whose derivatives are unknown to the adjoint. Use the direct method.")
    seen = replace(solution, system=system)
    found = {name: response.partials(seen) for name, response in responses_of(system.scene, moving(solution)).items()}
    gradient = np.zeros((system.n_x, len(found)))
    for r, partials in enumerate(found.values()):
        gradient[:, r] = 0 if partials.design is None else partials.design
    if not found:
        return found, gradient
    by_q, by_v, by_acc = (_stacked(system, solution, list(found.values()), name) for name in ("q", "v", "multipliers"))
    if moving(solution):
        _through_time(system, solution, by_q, by_v, by_acc, gradient)
    else:
        _through_equilibrium(system, solution, by_q[0] + by_acc[0], gradient)
    return found, gradient


def _stacked(system: System, solution: Solution, found: list[Partials], name: str) -> np.ndarray:
    """One kind of partial derivatives of all responses, at its place among the unknowns: (n_t, n, n_r)."""
    stacked = np.zeros((len(solution.times), system.n, len(found)))
    where = slice(system.n_q, system.n) if name == "multipliers" else slice(0, system.n_q)
    for r, partials in enumerate(found):
        if getattr(partials, name) is not None:
            stacked[:, where, r] = np.real(getattr(partials, name))
    return stacked


def _through_equilibrium(system: System, solution: Solution, load: np.ndarray, gradient: np.ndarray) -> None:
    """A^T mu = - f_[q; lam], gradient += (I_x + A_x)^T mu."""
    n_q, options = system.n_q, solution.options or system.scene.solver
    q, rest = np.append(solution.q[0], np.zeros(system.n - n_q)), np.zeros(system.n)
    acc = np.append(np.zeros(n_q), solution.multipliers[0])
    terms = system.evaluate(inputs_at(system, options, 1.0), q, rest, acc, design=True)
    transposed = static_matrix(system, terms)[transposition(system)]
    gradient += (terms.I_x + terms.A_x).T @ solve_linear(system, transposed, -load, "static adjoint")


def _through_time(
    system: System, solution: Solution, by_q: np.ndarray, by_v: np.ndarray, by_acc: np.ndarray, gradient: np.ndarray
) -> None:
    """Backwards through all steps, then through the consistent start."""
    options, n_t, n_q = solution.options or system.scene.solver, len(solution.times), system.n_q
    levels = constraint_levels(options)
    start = consistent_start(system, levels)
    scheme = generalized_alpha(options.scheme, options.rho_inf, solution.times[1] - solution.times[0])
    states = np.zeros((3, n_t, system.n))
    states[0, :, :n_q], states[1, :, :n_q], states[2, :, :n_q] = solution.q, solution.v, solution.a
    states[2, :, n_q:] = solution.multipliers
    memory = adjoint_memory(system.plan, system.lu_plan, system.weights, gradient.shape[1])
    curves, curves_x = system.curves(solution.times)
    failed = system.run(
        integrate_backwards, system.evaluator(), system.plan, system.functions, curves, curves_x, levels, scheme,
        transposition(system), True, True, *states, by_q, by_v, by_acc, memory, gradient,
    )  # fmt: skip
    if failed >= 0:
        raise SingularSystemError(
            f"the transposed equations of a step do not determine {system.numbering.names[failed]}. Use the direct method, whose "
            "solution the run has shown to exist, or remove redundant joints."
        )
    for bar, change in zip((memory.bars.q, memory.bars.v, memory.bars.acc), (start.dq, start.dv, start.dacc), strict=True):
        gradient += change.T @ bar


def transposition(system: System) -> np.ndarray:
    """Place of the transposed entry of every entry of the pattern, which is symmetric: (n_entries,)."""
    columns = system.plan.indices
    rows = np.repeat(np.arange(system.n), np.diff(system.plan.indptr))
    return np.lexsort((rows, columns))
