"""Partial design derivatives of markers in the compiled loop: the formulas of `marker_kernel` with z0, t0, Z, T differentiated."""

from toolkit.foundation.kernel import inlined, inner
from toolkit.markers.planar.marker_kernel import known_turn, rotate_sum, rotated


@inner
def update_marker_designs(markers, state, q, v, acc, scratch):
    """Compute the partial design derivatives of y, B v, B a and b: the formulas with the derivatives of z0, t0, Z, T."""
    for m in range(len(markers.frame)):
        first, last, frame = markers.start[m], markers.start[m + 1], markers.frame[m]
        for d in range(markers.design_start[m], markers.design_start[m + 1]):
            offset = markers.design_shape_start[d]
            for i, vector in enumerate((q, v, acc)):
                for j in range(3):
                    scratch[i, j] = 0
                for k in range(first + 3 if frame >= 0 else first, last):
                    for j in range(3):
                        scratch[i, j] += markers.design_shape[offset + k - first, j] * vector[markers.coordinate[k]]
            for i in range(3):
                scratch[0, i] += markers.design_point[d, i]
            store_design(markers, state, m, d, v, acc, scratch[0], scratch[1], scratch[2])


@inlined
def store_design(markers, state, m, d, v, acc, u, du, ddu):
    """Store the derivatives of one marker by one design variable."""
    frame = markers.frame[m]
    if frame < 0:
        for i in range(3):
            state.y_x[d, i], state.rate_x[d, i], state.acceleration_x[d, i] = u[i], du[i], ddu[i]
        return
    c, s = known_turn(markers, state, m)
    omega, alpha = v[frame + 2], acc[frame + 2]
    rotated(state.y_x[d], c, s, 1.0, u[0], u[1])
    state.y_x[d, 2] = u[2]
    rotate_sum(state.rate_x[d], c, s, 0.0, u, omega, u)
    rotate_sum(state.acceleration_x[d], c, s, 0.0, u, alpha, u)
    for i in range(2):
        state.rate_x[d, i] += (c * du[0] - s * du[1]) if i == 0 else (s * du[0] + c * du[1])
        state.acceleration_x[d, i] += (c * ddu[0] - s * ddu[1]) if i == 0 else (s * ddu[0] + c * ddu[1])
    state.rate_x[d, 2], state.acceleration_x[d, 2] = du[2], ddu[2]
    rotate_sum(state.centripetal_x[d], c, s, -omega * omega, u, 2 * omega, du)
