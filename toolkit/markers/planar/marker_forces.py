"""Forces on markers in the compiled loop: B^T F, and its derivatives by coordinates and design at constant F."""

from toolkit.foundation.kernel import inlined


@inlined
def add_force(markers, state, m, force, factor, residual):
    """residual += factor * B^T F for a force F = (f_x, f_y, torque) on marker m."""
    for k in range(markers.start[m], markers.start[m + 1]):
        total = state.B[k, 0] * force[0] + state.B[k, 1] * force[1] + state.B[k, 2] * force[2]
        residual[markers.coordinate[k]] += factor * total


@inlined
def add_geometric_stiffness(markers, state, m, force, factor, positions, stride, offset, values):
    """values += factor * d(B^T F)/dq at constant F.

        theta, theta: -F . A u        theta, c and c, theta: F . A J Z

    `positions[i * stride + k]` holds where the local entry (i, k) is stored; `offset` numbers this marker's first column.
    """
    if markers.frame[m] < 0:
        return
    first, last = markers.start[m], markers.start[m + 1]
    turn, local = first + 2, offset + 2
    entry = state.B[turn, 0] * force[1] - state.B[turn, 1] * force[0]
    values[positions[local * stride + local]] += factor * entry
    for k in range(turn + 1, last):
        entry = state.B[k, 0] * force[1] - state.B[k, 1] * force[0]
        i = offset + k - first
        values[positions[local * stride + i]] += factor * entry
        values[positions[i * stride + local]] += factor * entry


@inlined
def add_force_design(markers, state, m, d, force, factor, c, s, residual_x):
    """residual_x += factor * d(B^T F)/dx at constant F: theta: F . A J du, c: F . A dZ + dT F_3; (c, s) of theta."""
    x = markers.design_variable[d]
    first, last, frame = markers.start[m], markers.start[m + 1], markers.frame[m]
    across, along = c * force[0] + s * force[1], -s * force[0] + c * force[1]
    if frame >= 0:
        turned_force = state.y_x[d, 0] * force[1] - state.y_x[d, 1] * force[0]
        residual_x[frame + 2, x] += factor * turned_force
    offset = markers.design_shape_start[d]
    for k in range(first + 3 if frame >= 0 else first, last):
        row = offset + k - first
        shape = markers.design_shape
        total = shape[row, 0] * across + shape[row, 1] * along + shape[row, 2] * force[2]
        residual_x[markers.coordinate[k], x] += factor * total
