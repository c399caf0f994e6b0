"""Prediction of a step, the same for states and their sensitivities."""

from toolkit.kernel import inner


@inner
def predict(scheme, q, v, acc, aux, count, q_new, v_new):
    """Coordinates and velocities at n + 1 for a_+ = 0; also of their sensitivities, flattened."""
    h, beta, gamma = scheme.h, scheme.beta, scheme.gamma
    for i in range(count):
        w_new = scheme.old * acc[i] - scheme.carry * aux[i]
        q_new[i] = q[i] + h * v[i] + h * h * ((0.5 - beta) * aux[i] + beta * w_new)
        v_new[i] = v[i] + h * ((1 - gamma) * aux[i] + gamma * w_new)


@inner
def advance_auxiliary(scheme, acc, acc_new, count, aux):
    """w_+ in place of w_n; also of its sensitivities, flattened."""
    for i in range(count):
        aux[i] = scheme.new * acc_new[i] + scheme.old * acc[i] - scheme.carry * aux[i]
