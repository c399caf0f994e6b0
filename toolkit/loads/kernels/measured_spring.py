"""A spring and damper along any measure u(z) of two poses, in the plane and in space: what its force and its derivatives have in common."""

from toolkit.foundation.kernel import inner


@inner
def add_measured_spring(z, w, u, k, stiff, damp, force, force_z, force_w):
    """Adds f = -T u_z, T = k u + c u', u' = u_z . w, c = z[damp]; but for -T u_zz, T is returned. k is z[stiff], or zero of a damper alone.

        f_z = -u_z (k u_z + c u_zz w)^T - T u_zz,     f_w = -c u_z u_z^T

    On entry u_z is in column `stiff` of force_z, and u_zz w in column `damp`; on return they have the derivatives by k and c.
    """
    rate, n = 0 * u, len(w)
    for row in range(n):
        rate += force_z[row, stiff] * w[row]
    tension = k * u + z[damp] * rate
    for row in range(n):
        slope = force_z[row, stiff]
        if slope != 0:
            force[row] -= tension * slope
            for column in range(n):
                force_z[row, column] -= slope * (k * force_z[column, stiff] + z[damp] * force_z[column, damp])
                force_w[row, column] -= z[damp] * slope * force_z[column, stiff]
    for row in range(n):
        slope = force_z[row, stiff]
        force_z[row, stiff], force_z[row, damp] = -u * slope, -rate * slope
    return tension
