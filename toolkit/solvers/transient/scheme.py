"""The generalized-alpha schemes and the formulations of the constraints, as coefficients and as the matrix of one step.

Formulation of the constraints in a time step: as weights of their acceleration, velocity and position.

    "index-1"       phi'' + 2 damping phi' + stiffness^2 phi = 0, Baumgarte's stabilization (1972), by default 1/tau and sqrt(2)/tau
                    with tau the step, or after a longer one what time has left of it: see `relaxed`
    "index-3"       phi / c_q = 0 with c_q = d q_+ / d a_+ of the step: positions closed to round-off, Newton's matrix as in index 1
                    (Arnold and Bruels 2007; the scaling is that of Bottasso, Dopico and Trainelli 2008)
    "ggl"           phi' / c_v = 0 with c_v = d v_+ / d a_+, and phi / c_q = 0 with more multipliers, see `ggl_step`: velocities and
                    positions closed to round-off
    quasi-static    positions, as index 3

Multipliers of index 3 carry round-off of 1e-16 of the model size over h^2, and velocities leave the constraint by O(h^2); those of
"ggl" carry that of velocities over h.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.compiled.calls import by_value
from toolkit.foundation.errors import InputError
from toolkit.foundation.kernel import inlined, inner


@by_value
class Scheme(NamedTuple):
    """One step of length h, from n to n + 1 =: +, with the auxiliary acceleration w:

        w_+ = new a_+ + old a_n - carry w_n
        v_+ = keep v_n + h [gamma_old w_n + gamma w_+]
        q_+ = q_n + h keep v_n + h^2 [beta_old w_n + beta w_+]
        0   = weight_inertial I_+ + weight_applied A_+ + carried_inertial I_n + carried_applied A_n

    with the two groups I, A of the residual (`toolkit.system.equations`). The local error of q is error h^2 (w_+ - w_n) up to terms of
    higher order. Without `inertia` what mass does is left out of both groups.
    """

    h: float
    beta: float
    gamma: float
    beta_old: float
    gamma_old: float
    keep: float
    new: float
    old: float
    carry: float
    weight_inertial: float
    weight_applied: float
    carried_inertial: float
    carried_applied: float
    error: float
    inertia: bool


@inner
def with_step(scheme, h):
    """Coefficients of the scheme for another step length."""
    return Scheme(
        h, scheme.beta, scheme.gamma, scheme.beta_old, scheme.gamma_old, scheme.keep, scheme.new, scheme.old, scheme.carry,
        scheme.weight_inertial, scheme.weight_applied, scheme.carried_inertial, scheme.carried_applied, scheme.error, scheme.inertia,
    )  # fmt: skip


@inlined
def by_acceleration(scheme):
    """Derivatives c_q = d q_+ / d a_+ = h^2 beta new, and c_v = d v_+ / d a_+ = h gamma new."""
    return scheme.h * scheme.h * scheme.beta * scheme.new, scheme.h * scheme.gamma * scheme.new


QUASI_STATIC = Scheme(1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.5, False)
"""v_+ = (q_+ - q_n) / h, implicit Euler, without inertia: of first order in the forces of dampers, exact without them."""


START = Scheme(0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, True)
"""A step of no length, which moves nothing and finds the accelerations and multipliers of a start."""


def generalized_alpha(name: str, rho_inf: float, h: float = 1.0) -> Scheme:
    """Coefficients by name, for steps of length h.

    alpha_m, alpha_f, beta, gamma are as Chung and Hulbert (1993) choose them for a given rho_inf.

        "paper"           w = a, residual weighted between n and n + 1 (paper, eqs. 16-23)
        "arnold-bruels"   (1 - alpha_m) w_+ + alpha_m w_n = (1 - alpha_f) a_+ + alpha_f a_n, residual at n + 1
                          (Arnold and Bruels 2007)

    The order is 2 for "arnold-bruels". It is 1 for "paper" with rho_inf < 1, because m(q) and J(q) are taken at another point
    of the step than the acceleration, and 2 only for rho_inf = 1.

    The w of "arnold-bruels" belongs to the time t_n + D h, D = alpha_m - alpha_f, so that with a' = (w_+ - w_n) / h

        q(t_+) = q + h v + h^2/2 a + h^3/6 a',   q_+ = q + h v + h^2/2 (a + D h a') + beta h^3 a'

    and the local error is (beta + D/2 - 1/6) h^2 (w_+ - w_n).

    Raises
    ------
    InputError
        The scheme is unknown.
    """
    alpha_m, alpha_f = (2 * rho_inf - 1) / (rho_inf + 1), rho_inf / (rho_inf + 1)
    gamma = 0.5 - alpha_m + alpha_f
    beta = (1 - alpha_m + alpha_f) ** 2 / 4
    error = beta + (alpha_m - alpha_f) / 2 - 1 / 6
    newmark = (h, beta, gamma, 0.5 - beta, 1 - gamma, 1.0)
    if name == "paper":
        return Scheme(*newmark, 1.0, 0.0, 0.0, 1 - alpha_m, 1 - alpha_f, alpha_m, alpha_f, error, True)
    if name == "arnold-bruels":
        new, old, carry = (1 - alpha_f) / (1 - alpha_m), alpha_f / (1 - alpha_m), alpha_m / (1 - alpha_m)
        return Scheme(*newmark, new, old, carry, 1.0, 1.0, 0.0, 0.0, error, True)
    raise InputError(f"unknown scheme {name!r}; available: arnold-bruels, paper.")


def scheme_of(options: RunOptions) -> Scheme:
    """Coefficients of the run's scheme, for steps of length 1."""
    return QUASI_STATIC if options.quasi_static else generalized_alpha(options.scheme, options.rho_inf)


def relaxed(lengths: np.ndarray, before: float = 0.0) -> np.ndarray:
    """Times tau (n,) in which Baumgarte's defaults close a gap: tau_n = max(h_n, tau_(n-1) exp(-h_n / tau_(n-1))).

    A step leaves joints open by what its own length makes of the motion. A much shorter one must not close them in its own time, which
    would be a blow. `before` is tau of the step before the first, if there is one.
    """
    if np.all(lengths == lengths[0]) and before <= lengths[0]:
        return lengths
    found = lengths.copy()
    for n, h in enumerate(lengths):
        found[n] = max(h, before * np.exp(-h / before)) if before > 0 else h
        before = found[n]
    return found


def constraint_levels(options: RunOptions, lengths: np.ndarray, times: np.ndarray | None = None) -> np.ndarray:
    """Weights (k_2, k_1, k_0) of acceleration, velocity and position in the constraint rows of steps of lengths (n,): (n, 3).

    `times` (n,) are tau of the steps, by default their lengths.
    """
    if options.formulation == "index-3" or options.quasi_static:
        scheme = scheme_of(options)
        return np.outer(1 / (lengths**2 * scheme.beta * scheme.new), [0.0, 0.0, 1.0])
    if options.formulation == "ggl":
        scheme = scheme_of(options)
        return np.outer(1 / (lengths * scheme.gamma * scheme.new), [0.0, 1.0, 0.0])
    given, tau = options.baumgarte, lengths if times is None else times
    damping = 1 / tau if given.damping is None else np.full_like(lengths, given.damping)
    stiffness = np.sqrt(2) / tau if given.stiffness is None else np.full_like(lengths, given.stiffness)
    return np.stack([np.ones_like(lengths), 2 * damping, stiffness**2], axis=1)


def start_levels(options: RunOptions, lengths: np.ndarray) -> np.ndarray:
    """Levels (3,) of the constraints at which the accelerations of the start are found."""
    return constraint_levels(options.model_copy(update={"formulation": "index-1", "quasi_static": False}), lengths[:1])[0]


EQUAL_STEPS = 1e-9
"""Relative difference of two step lengths that is round-off."""
STEEPEST_GROWTH = 4.0
"""Growth of a step beyond which w says nothing about the new one: what it has of round-off and of the joints would grow with it."""


@inlined
def predict(scheme, q, v, acc, aux, count, q_new, v_new):
    """Predict coordinates and velocities at n + 1 for a_+ = 0; also of their sensitivities, flattened."""
    h = scheme.h
    for i in range(count):
        w_new = scheme.old * acc[i] - scheme.carry * aux[i]
        q_new[i] = q[i] + h * scheme.keep * v[i] + h * h * (scheme.beta_old * aux[i] + scheme.beta * w_new)
        v_new[i] = scheme.keep * v[i] + h * (scheme.gamma_old * aux[i] + scheme.gamma * w_new)


@inlined
def advance_auxiliary(scheme, acc, acc_new, count, aux):
    """Put w_+ in place of the auxiliary acceleration w_n; also of its sensitivities, flattened."""
    for i in range(count):
        aux[i] = scheme.new * acc_new[i] + scheme.old * acc[i] - scheme.carry * aux[i]


@inlined
def step_ratio(h, before):
    """Ratio of a step length to the one before, which is 0 at the start; 1 if they differ by round-off, 0 beyond STEEPEST_GROWTH."""
    ratio = h / before if before > 0 else 1.0
    if ratio > STEEPEST_GROWTH:
        return 0.0
    return ratio if abs(ratio - 1) > EQUAL_STEPS else 1.0


@inlined
def rescale_auxiliary(ratio, acc, count, aux):
    """Rescale w for another step length, a_n + ratio (w_n - a_n); also its sensitivities, flattened.

    w_n - a_n = D h a' belongs to a point of the step (see `scheme`); left as it is, it would cost an order of accuracy. With the ratio 0
    the step begins anew, as the first one.
    """
    for i in range(count):
        aux[i] = acc[i] + ratio * (aux[i] - acc[i])


@inlined
def newton_matrix(plan, scheme, terms, apart, jacobian, rest):
    """Compute d residual / d [a; lam] at n + 1: w_I (I_acc + c_q I_q) + w_A (c_q A_q + c_v A_v).

    Without inertia I_acc counts for lam alone.

    With the terms `apart` from the factored stiffness, `rest` is the same without that; otherwise it is not touched.
    """
    c_q, c_v = by_acceleration(scheme)
    w_i, w_a = scheme.weight_inertial, scheme.weight_applied
    I_acc, I_q, A_q, A_v = terms.I_acc, terms.I_q, terms.A_q, terms.A_v  # looked up once, or nothing is done several at a time
    for e in range(len(jacobian)):
        jacobian[e] = w_i * (I_acc[e] + c_q * I_q[e]) + w_a * (c_q * A_q[e] + c_v * A_v[e])
    if not scheme.inertia:
        for e in range(len(jacobian)):
            if plan.indices[e] < plan.n_q:
                jacobian[e] -= w_i * terms.I_acc[e]
    if apart == 1:
        by_strain, strained = w_a * c_q, plan.constant.strained
        for e in range(len(jacobian)):
            rest[e] = jacobian[e]
            jacobian[e] += by_strain * strained[e]


@inlined
def mix(frames, plan, scheme, ggl, memory):
    """Target of the derivatives: in space the step's matrix itself, unless gradients or other formulations need their parts.

    One matrix in the place of four, which are added up otherwise, is a third of what a step of many bodies reads and writes.
    """
    if frames is not None:
        (c_q, c_v), mixed = by_acceleration(scheme), memory.work.floating.mixed
        w_i, w_a = scheme.weight_inertial, scheme.weight_applied
        if plan.n_x == 0 and not ggl.active and scheme.inertia:
            mixed[0], mixed[1], mixed[2], mixed[3], mixed[4] = 1, w_i, w_i * c_q, w_a * c_q, w_a * c_v
            return memory.whole
        mixed[0], mixed[1], mixed[2], mixed[3], mixed[4] = 0, 1, 1, 1, 1
    return memory.terms
