"""All joints in the compiled loop: chain rule, acceleration level and stabilization, the same for every kind of joint.

A joint is g(z) - f(t) = 0 with z = (pose of marker a, pose of marker b, parameters). Its kind supplies g and the derivatives
g_z, g_zz and d(w^T g_zz w)/dz for the rates w = z' (zero for parameters). Its rows of the residual are

    inertial:   k_2 g_z B a
    applied:    k_2 (g_z b + w^T g_zz w - f'') + k_1 (g_z w - f') + k_0 (g - f)

with (k_2, k_1, k_0) = (1, 2 damping, stiffness^2) in dynamics (Baumgarte), (0, 0, 1) in statics; the forces g_z^T lam enter the
inertial group. Coordinates and design variables are treated alike: each is a direction with its derivatives of y, B v, B a, b.
"""

from typing import NamedTuple

import numba
import numpy as np

from toolkit.foundation.kernel import inlined, kernel
from toolkit.markers.planar.marker_forces import add_force

ROWS, ARGUMENTS = 3, 12
"""Most rows of a joint, and most arguments z: two poses and six parameters."""

_f8 = numba.float64
SIGNATURE = numba.void(_f8[::1], _f8[::1], _f8[::1], _f8[:, ::1], _f8[:, :, ::1], _f8[:, ::1])
"""g(z, w, phi, phi_z, phi_zz, phi_zww); the last four are zero on entry and are filled."""


class Joints(NamedTuple):
    """What never changes."""

    family: np.ndarray  # (n_j,) which function
    curved: np.ndarray  # (n_j,) 1 if g_zz is not zero
    marker: np.ndarray  # (n_j, 2)
    row: np.ndarray  # (n_j,) number of its first multiplier among all unknowns
    n_rows: np.ndarray  # (n_j,)
    parameter: np.ndarray  # (n_j, ARGUMENTS - 6)
    curve: np.ndarray  # (n_j,) time curve that its last row follows, or -1
    designed: np.ndarray  # (n,) 1 if any design variable matters to it
    design_start: np.ndarray  # (n_j + 1,) into the next three
    design_variable: np.ndarray
    design_parameter: np.ndarray  # which parameter
    design_value: np.ndarray  # its derivative
    position_start: np.ndarray  # (n_j,) into the next
    position: np.ndarray  # where local entries are stored: coordinates x coordinates, rows x coordinates, transposed

    def work(self, dtype: type) -> "JointWork":
        """Memory for any joint."""
        r, z = ROWS, ARGUMENTS
        shapes = [z, z, r, (r, z), (r, z, z), (r, z), (r, 3, z), (z, z), z, z, (4, 3), (4, r)]
        return JointWork(*(np.zeros(shape, dtype) for shape in shapes))


class JointWork(NamedTuple):
    """Scratch memory for one joint."""

    z: np.ndarray
    w: np.ndarray
    phi: np.ndarray
    phi_z: np.ndarray
    phi_zz: np.ndarray
    phi_zww: np.ndarray
    along: np.ndarray  # (ROWS, 3, ARGUMENTS): g_zz w, g_zz (B a), g_zz b + d(w g_zz w)/dz
    stiffness: np.ndarray  # lam . g_zz
    force: np.ndarray  # g_z^T lam
    dforce: np.ndarray
    unit: np.ndarray  # (4, 3) the direction of one parameter, as if it were a pose
    row: np.ndarray  # (4, ROWS) of one direction: d inertial, d applied, d applied by its rate, g_z y


@kernel
def evaluate_joint(functions, joints, j, markers, state, acc, work):
    """g and its derivatives at the poses of the two markers, and their contractions with rates and multipliers."""
    z, w = work.z, work.w
    for side in range(2):
        m = joints.marker[j, side]
        for i in range(3):
            z[3 * side + i] = state.y[m, i]
            w[3 * side + i] = state.rate[m, i]
    for i in range(ARGUMENTS - 6):
        z[6 + i] = joints.parameter[j, i]
    work.phi[:] = 0
    work.phi_z[:] = 0
    if joints.curved[j]:
        work.phi_zz[:] = 0
        work.phi_zww[:] = 0
    functions[joints.family[j]](z, w, work.phi, work.phi_z, work.phi_zz, work.phi_zww)
    row = joints.row[j]
    for k in range(6):
        work.force[k] = 0
        for i in range(joints.n_rows[j]):
            work.force[k] += work.phi_z[i, k] * acc[row + i]
    if joints.curved[j]:
        contract_curvature(joints, j, state, acc, work)


@inlined
def contract_curvature(joints, j, state, acc, work):
    """The products of g_zz that all directions share."""
    a, b, row = joints.marker[j, 0], joints.marker[j, 1], joints.row[j]
    work.stiffness[:] = 0
    for i in range(joints.n_rows[j]):
        for k in range(ARGUMENTS):
            rates, accelerations, centripetal = 0 * work.z[0], 0 * work.z[0], work.phi_zww[i, k]
            for c in range(3):
                g_a, g_b = work.phi_zz[i, k, c], work.phi_zz[i, k, 3 + c]
                rates += g_a * work.w[c] + g_b * work.w[3 + c]
                accelerations += g_a * state.acceleration[a, c] + g_b * state.acceleration[b, c]
                centripetal += g_a * state.centripetal[a, c] + g_b * state.centripetal[b, c]
            work.along[i, 0, k], work.along[i, 1, k], work.along[i, 2, k] = rates, accelerations, centripetal
            for c in range(ARGUMENTS):
                work.stiffness[k, c] += acc[row + i] * work.phi_zz[i, k, c]


@inlined
def joint_residual(joints, j, markers, state, curves, levels, work, inertial, applied):
    """Constraint rows, and constraint forces on both bodies."""
    a, b, row = joints.marker[j, 0], joints.marker[j, 1], joints.row[j]
    k2, k1, k0 = levels[0], levels[1], levels[2]
    for i in range(joints.n_rows[j]):
        rows_a, total, rate = 0 * work.z[0], 0 * work.z[0], 0 * work.z[0]
        for c in range(3):
            g_a, g_b = work.phi_z[i, c], work.phi_z[i, 3 + c]
            rows_a += g_a * state.acceleration[a, c] + g_b * state.acceleration[b, c]
            total += g_a * state.centripetal[a, c] + g_b * state.centripetal[b, c]
            rate += g_a * work.w[c] + g_b * work.w[3 + c]
            if joints.curved[j]:
                total += work.along[i, 0, c] * work.w[c] + work.along[i, 0, 3 + c] * work.w[3 + c]
        inertial[row + i] += k2 * rows_a
        applied[row + i] += k2 * total + k1 * rate + k0 * work.phi[i]
    if joints.curve[j] >= 0:
        f = curves[joints.curve[j]]
        applied[row + joints.n_rows[j] - 1] -= k2 * f[2] + k1 * f[1] + k0 * f[0]
    add_force(markers, state, a, work.force[:3], 1.0, inertial)
    add_force(markers, state, b, work.force[3:6], 1.0, inertial)
