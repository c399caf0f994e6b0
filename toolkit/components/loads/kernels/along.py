"""Loads that act along what they measure: f = u(g, g', parameters) g_z, so that u does work as g grows.

`force` holds g_z and `force_z` holds g_zz (see `measured`) until f and its derivatives take their places:

    f_z = g_z (u_g g_z + u_r g_zz w)^T + u g_zz,    f_w = u_r g_z g_z^T,    f_p = u_p g_z
"""

import numpy as np

from toolkit.foundation.kernel import inner


@inner
def rate_along(n, w, force):
    """Rate g' = g_z w of what is measured."""
    total = 0 * w[0]
    for i in range(n):
        total += force[i] * w[i]
    return total


@inner
def act_along(n, u, u_g, u_r, w, force, force_z, force_w):
    """Compute f_z and f_w.

    f itself is left to `scale_force`, because derivatives by parameters still need g_z.
    """
    for j in range(n):
        turned = 0 * u
        for i in range(n):
            turned += w[i] * force_z[i, j]
        across = u_g * force[j] + u_r * turned
        for i in range(n):
            force_z[i, j] = force[i] * across + u * force_z[i, j]
            force_w[i, j] = u_r * force[i] * force[j]


@inner
def add_parameter(n, p, u_p, force, force_z):
    """Put the derivative f_p by a parameter into its column."""
    for i in range(n):
        force_z[i, p] = u_p * force[i]


@inner
def add_state(n, u_x, force, force_w):
    """Add the derivative of f by a state x = w[n] of the load."""
    for i in range(n):
        force_w[i, n] = u_x * force[i]


@inner
def counted_turns(n, g, w, force, force_z, force_w):
    """g with the turns that a state x = w[n] of the load counts, x' = g' + (1 + |g'|) h, where h is g - x without whole turns, in rad/s.

    What rounds has no derivative, so x only decides on the turn: f does not change with it. The error of the steps is a part e of the rate,
    which alone would lose a turn in the long run; so x stays behind by less than e rad however fast it turns. In an equilibrium h is zero.
    """
    behind, rate = g - w[n], rate_along(n, w, force)
    whole = 2 * np.pi * np.ceil(behind.real / (2 * np.pi) - 0.5)  # half a turn is one of (-pi, pi]
    behind, sign = behind - whole, np.sign(rate.real)
    for j in range(n):
        turned = 0 * g
        for i in range(n):
            turned += w[i] * force_z[i, j]
        force_w[n, j] = (1 + sign * behind) * force[j]
        force_z[n, j] = (1 + sign * behind) * turned + (1 + sign * rate) * force[j]
    force[n], force_w[n, n] = rate + (1 + sign * rate) * behind, -1 - sign * rate
    return g - whole


@inner
def scale_force(n, u, force):
    """Compute f = u g_z."""
    for i in range(n):
        force[i] = u * force[i]


@inner
def spring_along(n, g, z, w, force, force_z, force_w):
    """u = k (g_0 - g) - c g', (k, c, g_0) = z[n:n+3]."""
    rate, error = rate_along(n, w, force), z[n + 2] - g
    u = z[n] * error - z[n + 1] * rate
    act_along(n, u, -z[n], -z[n + 1], w, force, force_z, force_w)
    add_parameter(n, n, error, force, force_z)
    add_parameter(n, n + 1, -rate, force, force_z)
    add_parameter(n, n + 2, z[n], force, force_z)
    scale_force(n, u, force)


@inner
def control_along(n, g, z, w, force, force_z, force_w):
    """u = k_p (s - g) + k_i x - k_d g', x' = s - g, (k_p, k_d, k_i) = z[n:n+3], s the value of the curve, x the state."""
    last = len(z) - 1
    rate, error = rate_along(n, w, force), z[last] - g
    u = z[n] * error + z[n + 2] * w[n] - z[n + 1] * rate
    for i in range(n):
        force_z[n, i] = -force[i]
    act_along(n, u, -z[n], -z[n + 1], w, force, force_z, force_w)
    add_parameter(n, n, error, force, force_z)
    add_parameter(n, n + 1, -rate, force, force_z)
    add_parameter(n, n + 2, w[n], force, force_z)
    add_parameter(n, last, z[n], force, force_z)
    add_state(n, z[n + 2], force, force_w)
    scale_force(n, u, force)
    force[n], force_z[n, last] = error, 1


@inner
def friction_along(n, z, w, force, force_z, force_w):
    """u = - s F tanh(g' / d), (F, d) = z[n:n+2], s the value of the curve."""
    last = len(z) - 1
    rate = rate_along(n, w, force)
    part = rate / z[n + 1]
    level, slope = np.tanh(part), slope_of_tanh(part)
    u, slope = -z[last] * z[n] * level, -z[last] * z[n] * slope / z[n + 1]
    act_along(n, u, 0 * u, slope, w, force, force_z, force_w)
    add_parameter(n, n, -z[last] * level, force, force_z)
    add_parameter(n, n + 1, -slope * part, force, force_z)
    add_parameter(n, last, -z[n] * level, force, force_z)
    scale_force(n, u, force)


@inner
def slope_of_tanh(x):
    """Slope 1 / cosh^2 of tanh, without cancellation and for any x."""
    small = np.exp(-2 * x) if x.real > 0 else np.exp(2 * x)
    return 4 * small / ((1 + small) * (1 + small))
