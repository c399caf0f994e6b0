"""The generalized-alpha schemes, as the coefficients of one step."""

from __future__ import annotations

from typing import NamedTuple

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

    with the two groups I, A of the residual (`toolkit.equations.equations`). The local error of q is error h^2 (w_+ - w_n) up to terms of
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
