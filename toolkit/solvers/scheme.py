"""The generalized-alpha schemes, as the coefficients of one step."""

from __future__ import annotations

from typing import NamedTuple

from toolkit.errors import InputError


class Scheme(NamedTuple):
    """One step of length h, from n to n + 1 =: +, with the auxiliary acceleration w:

        w_+ = new a_+ + old a_n - carry w_n
        v_+ = v_n + h [(1 - gamma) w_n + gamma w_+]
        q_+ = q_n + h v_n + h^2 [(1/2 - beta) w_n + beta w_+]
        0   = weight_inertial I_+ + weight_applied A_+ + carried_inertial I_n + carried_applied A_n

    with the two groups I, A of the residual (`toolkit.equations`).
    """

    h: float
    beta: float
    gamma: float
    new: float
    old: float
    carry: float
    weight_inertial: float
    weight_applied: float
    carried_inertial: float
    carried_applied: float


def generalized_alpha(name: str, rho_inf: float, h: float) -> Scheme:
    """Coefficients by name; alpha_m, alpha_f, beta, gamma as Chung and Hulbert (1993) choose them for a given rho_inf.

        "paper"           w = a, residual weighted between n and n + 1 (paper, eqs. 16-23)
        "arnold-bruels"   (1 - alpha_m) w_+ + alpha_m w_n = (1 - alpha_f) a_+ + alpha_f a_n, residual at n + 1
                          (Arnold and Bruels 2007)

    The order is 2 for "arnold-bruels". It is 1 for "paper" with rho_inf < 1, because m(q) and J(q) are taken at another point
    of the step than the acceleration, and 2 only for rho_inf = 1.

    Raises
    ------
    InputError
        The scheme is unknown.
    """
    alpha_m, alpha_f = (2 * rho_inf - 1) / (rho_inf + 1), rho_inf / (rho_inf + 1)
    gamma = 0.5 - alpha_m + alpha_f
    beta = (1 - alpha_m + alpha_f) ** 2 / 4
    if name == "paper":
        return Scheme(h, beta, gamma, 1.0, 0.0, 0.0, 1 - alpha_m, 1 - alpha_f, alpha_m, alpha_f)
    if name == "arnold-bruels":
        new, old, carry = (1 - alpha_f) / (1 - alpha_m), alpha_f / (1 - alpha_m), alpha_m / (1 - alpha_m)
        return Scheme(h, beta, gamma, new, old, carry, 1.0, 1.0, 0.0, 0.0)
    raise InputError(f"unknown scheme {name!r}; available: arnold-bruels, paper.")
