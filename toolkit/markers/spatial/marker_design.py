"""Partial design derivatives of spatial markers in the compiled loop: the formulas of `marker_kernel` with z0, Z, T and e_m differentiated.

With dphi = dT c and the derivatives D of R(phi) e_m by phi, for the axes (m = 1, 2, 3):

    dX_m = D_i dphi_i + R de_m,   dX_m,j = D_i dT_ij + (D_il dphi_l + D_i[de_m]) T_ij

and likewise for X_m' and X_m''; for the position dX_0 = dz0 + dZ c.
"""

from toolkit.foundation.kernel import inner
from toolkit.kinematics.nodal_rotation import turn
from toolkit.markers.spatial.marker_kernel import apply


@inner
def update_spatial_marker_designs(markers, state, q, v, acc):
    """Compute the partial design derivatives of y, B v, B a and b, and of X_m and X_m,j."""
    for m in range(len(markers.frame)):
        if markers.design_start[m] == markers.design_start[m + 1]:
            continue
        sum_up(markers.shape, markers.start[m], markers, m, q, v, acc, state.sums)
        for d in range(markers.design_start[m], markers.design_start[m + 1]):
            sum_up(markers.design_shape, markers.design_shape_start[d], markers, m, q, v, acc, state.sums_x)
            local_design(markers, state, m, d)
            pose_design(markers, state, m, d)


@inner
def sum_up(shape, first_row, markers, m, q, v, acc, sums):
    """Compute Z c and T c, and their derivatives by time, for the rows of one marker."""
    sums[:] = 0
    offset = markers.moves[m] + markers.turns[m]
    for k in range(offset, markers.start[m + 1] - markers.start[m]):
        at = markers.coordinate[markers.start[m] + k]
        for i in range(6):
            entry = shape[first_row + k, i]
            sums[0, i] += entry * q[at]
            sums[1, i] += entry * v[at]
            sums[2, i] += entry * acc[at]


@inner
def local_design(markers, state, m, d):
    """Compute dX_m, dX_m', both parts of dX_m'' (rows of `motion_x`), and dX_m,j."""
    motion, change = state.motion_x, state.sums_x
    for i in range(3):
        motion[0, i], motion[1, i], motion[2, i], motion[3, i] = (
            markers.design_point[d, i] + change[0, i],
            change[1, i],
            change[2, i],
            0,
        )
    first = markers.design_shape_start[d]
    count, offset = markers.start[m + 1] - markers.start[m], markers.moves[m] + markers.turns[m]
    for k in range(offset, count):
        for c in range(12):
            state.slope_x[first + k, c] = markers.design_shape[first + k, c] if c < 3 else 0
    for block in range(3, markers.size[m], 3):
        add_axis_design(markers, state, m, d, block, first, offset, count)
    for c in range(markers.size[m]):
        state.local_x[d, c] = motion[0, c]


@inner
def add_axis_design(markers, state, m, d, block, first, offset, count):
    """Add the part of one axis to the local design derivatives."""
    motion, sums, change, turned = state.motion_x, state.sums, state.sums_x, state.turned
    if markers.bends[m] == 0 and not has_rotation(markers, d, count):
        for c in range(3):
            motion[0, block + c] = markers.design_point[d, block + c]
            for row in range(1, 4):
                motion[row, block + c] = 0
        return
    turn(sums[0, 3:6], sums[1, 3:6], sums[2, 3:6], markers.design_point[d, block : block + 3], turned)
    for c in range(3):
        k = block + c
        motion[0, k] = turned.value[c]
        motion[1, k], motion[2, k], motion[3, k] = 0 * motion[0, k], 0 * motion[0, k], 0 * motion[0, k]
        for i in range(3):
            motion[1, k] += turned.by[i, c] * sums[1, 3 + i]
            motion[2, k] += turned.by[i, c] * sums[2, 3 + i]
            motion[3, k] += turned.along_rate[i, c] * sums[1, 3 + i]
    for row in range(offset, count):
        for c in range(3):
            for i in range(3):
                state.slope_x[first + row, block + c] += turned.by[i, c] * markers.shape[markers.start[m] + row, 3 + i]
    turn(sums[0, 3:6], sums[1, 3:6], sums[2, 3:6], markers.point[m, block : block + 3], turned)
    for c in range(3):
        k = block + c
        for i in range(3):
            phi, rate, growth = change[0, 3 + i], change[1, 3 + i], change[2, 3 + i]
            motion[0, k] += turned.by[i, c] * phi
            motion[1, k] += turned.along_rate[i, c] * phi + turned.by[i, c] * rate
            motion[2, k] += turned.along_growth[i, c] * phi + turned.by[i, c] * growth
            motion[3, k] += turned.curved[i, c] * phi + 2 * turned.along_rate[i, c] * rate
    for row in range(offset, count):
        at = markers.start[m] + row
        for c in range(3):
            for i in range(3):
                bent = 0 * motion[0, 0]
                for n in range(3):
                    bent += turned.by_by[i, n, c] * change[0, 3 + n]
                state.slope_x[first + row, block + c] += turned.by[i, c] * markers.design_shape[first + row, 3 + i]
                state.slope_x[first + row, block + c] += bent * markers.shape[at, 3 + i]


@inner
def has_rotation(markers, d, count):
    """Whether the variable changes any T of the marker."""
    for row in range(markers.design_shape_start[d], markers.design_shape_start[d] + count):
        for i in range(3, 6):
            if markers.design_shape[row, i] != 0:
                return True
    return False


@inner
def pose_design(markers, state, m, d):
    """Compute dy, d(B v), d(B a) and db of one marker."""
    f, size, frames, motion = markers.frame[m], markers.size[m], state.frames, state.motion_x
    y, rate, acceleration, centripetal = state.y_x[d], state.rate_x[d], state.acceleration_x[d], state.centripetal_x[d]
    for array in (y, rate, acceleration, centripetal):
        array[:] = 0
    for i in range(3):
        y[i] = y[i] + markers.design_point[d, 12 + i]
    apply(size, frames.A[f], motion[0], y, 1.0)
    apply(size, frames.A[f], motion[1], rate, 1.0)
    apply(size, frames.A[f], motion[2], acceleration, 1.0)
    apply(size, frames.A[f], motion[3], centripetal, 1.0)
    if markers.turns[m] > 0:
        apply(size, frames.V[f], motion[0], rate, 1.0)
        apply(size, frames.X[f], motion[0], acceleration, 1.0)
        apply(size, frames.W[f], motion[0], centripetal, 1.0)
        apply(size, frames.V[f], motion[1], centripetal, 2.0)
