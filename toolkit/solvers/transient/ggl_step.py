"""Stabilised index 2 (Gear, Gupta and Leimkuhler 1985): a step that satisfies joints by positions and by velocities.

Places of the numbers of a stabilised index-2 step: the sparsity pattern of its matrix, made once per run.

Unknowns are [a; lam; eta], rows those of coordinates, velocity constraints and position constraints (see `ggl_step`):

            a          lam        eta
    [ base matrix of [a; lam]    c_q B S     ]        B = I_q + A_q, all n rows
    [ phi_q            0         phi_q S     ]        S has the pattern of phi_q^T

Memory of the steps of stabilised index 2.

In other formulations it is a record of the same type, so that the step loop is compiled once.

As Arnold, Bruels and Cardona (2015) put it into the generalized-alpha step, with more multipliers eta, the predictions of
`transient.scheme` and c_q = d q_+ / d a_+, c_v = d v_+ / d a_+:

    q_+ = q_predicted + c_q (a_+ + S eta),   v_+ = v_predicted + c_v a_+,   S = W^-2 phi_q(q_n)^T
    0 = coordinates' rows at (q_+, v_+, a_+, lam),   0 = (phi_q v + phi_t) / c_v,   0 = phi(q_+) / c_q

eta is of the size of the local error, so that every positive W is as accurate. W compares coordinates as `numbering.weights` do, with
W^-2 rounded to a power of ten: a change of the design then leaves it alone, and a change of units changes it exactly as coordinates.
"""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from toolkit.foundation.compiled.calls import in_memory
from toolkit.foundation.compiled.rows import filled_up
from toolkit.foundation.kernel import inner
from toolkit.linear.linear_solver import LinearSolver, apply_inverse, factorize, linear_solver, solve_checked, solve_refined_block
from toolkit.linear.sparse_analysis import analyse
from toolkit.solvers.transient.scheme import advance_auxiliary, by_acceleration, predict
from toolkit.solvers.transient.step_gradients import add_design_change, add_state_change
from toolkit.solvers.transient.step_memory import AT_FAULT, LAST
from toolkit.system.equations import Inputs, Plan, Terms, allocate_terms


class Products(NamedTuple):
    """A sparse product in triples: value[place] += left value * right value."""

    place: np.ndarray
    left: np.ndarray
    right: np.ndarray


class GglPattern(NamedTuple):
    """Pattern in compressed rows, symmetric and with a full diagonal, and where parts are found and put.

    The entries of phi_q are counted k = 0 ... n_phi - 1; S keeps its values in the same order.
    """

    indptr: np.ndarray
    indices: np.ndarray
    base: np.ndarray  # (n_entries,) place of the entries of the base pattern
    row: np.ndarray  # (n_phi,) number of its constraint
    coordinate: np.ndarray  # (n_phi,)
    lower: np.ndarray  # (n_phi,) the entry of the base pattern that holds it
    upper: np.ndarray  # (n_phi,) and its transpose
    position: np.ndarray  # (n_phi,) place in the rows of position constraints
    bent: Products  # B S: base entries, entries of S
    closing: Products  # phi_q S: entries of phi_q, entries of S


def ggl_pattern(indptr: np.ndarray, indices: np.ndarray, n_q: int) -> GglPattern:
    """Pattern of n_q coordinates and their multipliers, (n + 1,) and (n_entries,), extended by the multipliers eta."""
    n = len(indptr) - 1
    rows, columns = np.repeat(np.arange(n), np.diff(indptr)), np.asarray(indices, np.int64)
    lower = np.flatnonzero((rows >= n_q) & (columns < n_q))
    upper = np.searchsorted(rows * n + columns, columns[lower] * n + rows[lower])
    row, coordinate = rows[lower] - n_q, columns[lower]
    bent_left, bent_right = _pairs(columns, coordinate, n)
    closing_left, closing_right = _pairs(coordinate, coordinate, n)
    total = 2 * n - n_q
    keys = {
        "base": rows * total + columns,
        "position": (n + row) * total + coordinate,
        "bent": rows[bent_left] * total + n + row[bent_right],
        "closing": (n + row[closing_left]) * total + n + row[closing_right],
    }
    found = np.concatenate([*keys.values(), np.arange(total) * (total + 1)])
    pattern = np.unique(np.concatenate([found, found % total * total + found // total]))
    place = {name: np.searchsorted(pattern, key) for name, key in keys.items()}
    return GglPattern(
        np.searchsorted(pattern, np.arange(total + 1) * total),
        pattern % total,
        place["base"],
        row,
        coordinate,
        lower,
        upper,
        place["position"],
        Products(place["bent"], bent_left, bent_right),
        Products(place["closing"], closing_left, closing_right),
    )


def _pairs(columns: np.ndarray, coordinates: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """All pairs of a left entry in some column and a right entry at the coordinate of the same number."""
    by_column = np.argsort(columns, kind="stable")
    start = np.searchsorted(columns[by_column], np.arange(n + 1))
    counts = start[coordinates + 1] - start[coordinates]
    right = np.repeat(np.arange(len(coordinates)), counts)
    within = np.arange(len(right)) - np.repeat(np.cumsum(counts) - counts, counts)
    return by_column[start[coordinates[right]] + within], right


class Ggl(NamedTuple):
    """Constant arrays and scratch memory of stabilised index 2, with n_all = n + n_lam unknowns [a; lam; eta].

    No step leaves anything to the next.
    """

    active: bool  # whether it is the formulation of the run; nothing else counts otherwise
    pattern: GglPattern
    metric: np.ndarray  # (n_q,) W^-2
    levels: np.ndarray  # (3,) those of positions
    S: np.ndarray  # (n_phi,)
    eta: np.ndarray  # (n_lam,)
    lever: np.ndarray  # (n,) [0; eta] as accelerations and multipliers
    jacobian: np.ndarray  # values on the pattern
    residual: np.ndarray  # (n_all,)
    correction: np.ndarray  # (n_all,)
    moved: np.ndarray  # (n_q,) S times a correction of eta
    pseudo_load: np.ndarray  # (n_all, n_x filled up)
    change: np.ndarray  # (n_all, n_x) total derivative of [a; lam; eta]
    terms: Terms  # of the joints alone
    solver: LinearSolver


def allocate_ggl(plan: Plan, weights: np.ndarray, dtype: type) -> Ggl:
    """Analysed pattern and memory of stabilised index 2."""

    def zeros(*shape: int) -> np.ndarray:
        return np.zeros(shape, dtype)

    pattern, weights = ggl_pattern(plan.indptr, plan.indices, plan.n_q), weights[: plan.n_q]
    n_all = 2 * plan.n - plan.n_q
    return Ggl(
        active=True,
        pattern=pattern,
        metric=10.0 ** -np.round(2 * np.log10(weights)),
        levels=np.array([0.0, 0.0, 1.0]),
        S=zeros(len(pattern.row)),
        eta=zeros(plan.n - plan.n_q),
        lever=zeros(plan.n),
        jacobian=zeros(len(pattern.indices)),
        residual=zeros(n_all),
        correction=zeros(n_all),
        moved=zeros(plan.n_q),
        pseudo_load=zeros(n_all, filled_up(plan.n_x)),
        change=zeros(n_all, plan.n_x),
        terms=allocate_terms(plan, dtype),
        solver=linear_solver(analyse(pattern.indptr, pattern.indices, plan.n_q), weights, plan.n_x, dtype),
    )


@cache
def idle_ggl(dtype: type) -> object:
    """Memory of stabilised index 2 for runs in other formulations, of one coordinate and one multiplier.

    It is as compiled code takes it, where the run is compiled.
    """
    plan: Any = SimpleNamespace(n_q=1, n=2, n_x=2, indptr=np.arange(3), indices=np.arange(2))
    found = allocate_ggl(plan, np.ones(2), dtype)._replace(active=False)
    return in_memory(found) if dtype is float else found


@inner
def positions(inputs, ggl):
    """Inputs of the equations for the joints' own positions and forces."""
    return Inputs(inputs.curves, inputs.curves_x, inputs.scale, ggl.levels, inputs.inertia, True)


@inner
def begin_ggl(evaluator, plan, functions, inputs, q, v, acc, memory, ggl):
    """Compute S at the known state, and set eta = 0."""
    evaluator(plan, functions, positions(inputs, ggl), q, v, acc, True, False, ggl.terms, memory.work)
    pattern = ggl.pattern
    for k in range(len(pattern.row)):
        ggl.S[k] = ggl.metric[pattern.coordinate[k]] * ggl.terms.I_acc[pattern.upper[k]]
    ggl.eta[:] = 0


@inner
def ggl_matrix(scheme, memory, ggl):
    """Compute the matrix of the step from the base matrix in `memory.jacobian` and its terms (see `ggl_pattern`)."""
    c_q, c_v = by_acceleration(scheme)
    pattern, values, terms, S = ggl.pattern, ggl.jacobian, memory.terms, ggl.S
    bent, closing = pattern.bent, pattern.closing
    values[:] = 0
    for e in range(len(pattern.base)):
        values[pattern.base[e]] = memory.jacobian[e]
    for t in range(len(bent.place)):
        values[bent.place[t]] += c_q * (terms.I_q[bent.left[t]] + terms.A_q[bent.left[t]]) * S[bent.right[t]]
    for k in range(len(pattern.lower)):
        values[pattern.position[k]] = c_v * terms.A_v[pattern.lower[k]]
    for t in range(len(closing.place)):
        values[closing.place[t]] += c_v * terms.A_v[pattern.lower[closing.left[t]]] * S[closing.right[t]]


@inner
def factorize_ggl(scheme, memory, ggl):
    """Factor the step's matrix; results as those of `factorize`."""
    ggl_matrix(scheme, memory, ggl)
    return factorize(ggl.solver, ggl.pattern.indptr, ggl.pattern.indices, ggl.jacobian)


@inner
def solve_ggl(evaluator, plan, functions, inputs, scheme, kept, q, v, acc, memory, ggl):
    """Solve for Newton's correction of [a; lam; eta], whose first part goes to `memory.correction`.

    The factors are kept ones, or those of `memory.jacobian`.

    Returns -1, or the unknown that the equations do not determine (for eta the multiplier of the same joint).
    """
    evaluator(plan, functions, positions(inputs, ggl), q, v, acc, False, False, ggl.terms, memory.work)
    c_q, _ = by_acceleration(scheme)
    for i in range(plan.n):
        ggl.residual[i] = memory.residual[i]
        if i >= plan.n_q:
            ggl.residual[plan.n - plan.n_q + i] = ggl.terms.applied[i] / c_q
    failed = -1
    if kept:
        for i in range(len(ggl.residual)):
            ggl.correction[i] = ggl.residual[i]
        apply_inverse(ggl.solver, ggl.correction)
    else:
        pattern = ggl.pattern
        failed = factorize_ggl(scheme, memory, ggl)
        if failed < 0:
            failed = solve_checked(ggl.solver, pattern.indptr, pattern.indices, ggl.jacobian, ggl.residual, ggl.correction)
    for i in range(plan.n):
        memory.correction[i] = ggl.correction[i]
    return failed - (plan.n - plan.n_q) if failed >= plan.n else failed


@inner
def correct_ggl(plan, scheme, weights, ggl, q, outcome):
    """Subtract eta's correction, after that of [a; lam]; the size of the whole correction goes to `outcome`."""
    (c_q, _), pattern = by_acceleration(scheme), ggl.pattern
    ggl.moved[:] = 0
    for k in range(len(pattern.row)):
        ggl.moved[pattern.coordinate[k]] += ggl.S[k] * ggl.correction[plan.n + pattern.row[k]]
    for j in range(len(ggl.eta)):
        ggl.eta[j] -= ggl.correction[plan.n + j]
    for i in range(plan.n_q):
        q[i] -= c_q * ggl.moved[i]
        size = weights[i] * abs(c_q * ggl.moved[i].real)
        if not size <= outcome.correction[LAST]:
            outcome.counts[AT_FAULT], outcome.correction[LAST] = i, size


@inner
def ggl_sensitivity_step(evaluator, plan, functions, inputs, scheme, history, step, fresh, memory, ggl):
    """Compute total design derivatives at n + 1 from those at n, with the converged Jacobian, as `step_gradients.sensitivity_step`.

    At fixed unknowns q_+ moves with the prediction and with c_q d(S eta); the rows of positions are differentiated like the others.
    """
    pattern, terms, load, n_x = ggl.pattern, memory.terms, ggl.pseudo_load, plan.n_x
    dq, dv, dacc = history.dq[step + 1], history.dv[step + 1], history.dacc[step + 1]
    c_q, c_v = by_acceleration(scheme)
    count, after, n_lam = plan.n_q * n_x, step + 1, plan.n - plan.n_q
    predict(
        scheme, history.flat_dq[step], history.flat_dv[step], history.flat_dacc[step], memory.flat_daux, count,
        history.flat_dq[after], history.flat_dv[after],
    )  # fmt: skip
    known = positions(inputs, ggl)
    for j in range(n_lam):
        ggl.lever[plan.n_q + j] = ggl.eta[j]
    evaluator(plan, functions, known, history.q[step], history.v[step], ggl.lever, True, True, ggl.terms, memory.work)
    add_turned(plan, c_q, history.dq[step], ggl, dq)
    load[:] = 0
    add_design_change(plan, terms, 1.0, 1.0, load)
    add_state_change(plan, terms, 1.0, 1.0, dq, dv, dacc, False, memory, load)
    evaluator(plan, functions, known, history.q[after], history.v[after], history.acc[after], False, True, ggl.terms, memory.work)
    for e in range(len(plan.touched_row)):
        i, x = plan.touched_row[e], plan.touched_variable[e]
        if i >= plan.n_q:
            load[n_lam + i, x] += ggl.terms.A_x[i, x] / c_q
    for k in range(len(pattern.row)):
        entry = c_v / c_q * terms.A_v[pattern.lower[k]]
        for x in range(n_x):
            load[plan.n + pattern.row[k], x] += entry * dq[pattern.coordinate[k], x]
    solve_refined_block(ggl.solver, pattern.indptr, pattern.indices, ggl.jacobian, None, 0.0, fresh, load, ggl.change)
    for i in range(plan.n):
        for x in range(n_x):
            dacc[i, x] = -ggl.change[i, x]
            if i < plan.n_q:
                dq[i, x] += c_q * dacc[i, x]
                dv[i, x] += c_v * dacc[i, x]
    for k in range(len(pattern.row)):
        for x in range(n_x):
            dq[pattern.coordinate[k], x] -= c_q * ggl.S[k] * ggl.change[plan.n + pattern.row[k], x]
    advance_auxiliary(scheme, history.flat_dacc[step], history.flat_dacc[after], count, memory.flat_daux)


@inner
def add_turned(plan, c_q, dq_known, ggl, dq):
    """dq += c_q d(S eta) at constant eta, c_q W^-2 [(phi_q^T eta)_q dq_n + (phi_q^T eta)_x]; `ggl.terms` hold phi_q^T eta at n."""
    for i in range(plan.n_q):
        for e in range(plan.indptr[i], plan.indptr[i + 1]):
            entry, column = c_q * ggl.metric[i] * ggl.terms.I_q[e], plan.indices[e]
            if entry != 0:
                for x in range(dq.shape[1]):
                    dq[i, x] += entry * dq_known[column, x]
    for e in range(len(plan.touched_row)):
        i, x = plan.touched_row[e], plan.touched_variable[e]
        if i < plan.n_q:
            dq[i, x] += c_q * ggl.metric[i] * ggl.terms.I_x[i, x]
