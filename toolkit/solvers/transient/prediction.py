"""Prediction of a step, the same for states and their sensitivities."""

from toolkit.foundation.kernel import inlined

SAME = 1e-9
"""Relative difference of two step lengths that is round-off."""
STEEP = 4.0
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
    """Ratio of a step length to the one before, which is 0 at the start; 1 if they differ by round-off, 0 beyond STEEP."""
    ratio = h / before if before > 0 else 1.0
    if ratio > STEEP:
        return 0.0
    return ratio if abs(ratio - 1) > SAME else 1.0


@inlined
def rescale_auxiliary(ratio, acc, count, aux):
    """Rescale w for another step length, a_n + ratio (w_n - a_n); also its sensitivities, flattened.

    w_n - a_n = D h a' belongs to a point of the step (see `scheme`); left as it is, it would cost an order of accuracy. With the ratio 0
    the step begins anew, as the first one.
    """
    for i in range(count):
        aux[i] = acc[i] + ratio * (aux[i] - acc[i])
