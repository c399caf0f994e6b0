"""Forces on spatial markers in the compiled loop: B^T F, and its derivatives by coordinates and design at constant F.

F is conjugate to the pose: four vectors F_m, a force and what turns the axes. A torque M is F_m = M x y_m / 2 on the three axes.

    d(B^T F)/dq:   beta_k, beta_l: F_m . A_kl X_m      beta_k, c_j: F_m . A_k X_m,j      c_i, c_j: F_m . A X_m,ij
"""

from toolkit.foundation.kernel import inlined, inner
from toolkit.kinematics.spatial import second_products
from toolkit.markers.spatial.marker_kernel import second_index


@inlined
def add_spatial_force(markers, state, m, force, factor, residual):
    """residual += factor * B^T F for F (12,) on marker m."""
    for k in range(markers.start[m], markers.start[m + 1]):
        total = 0 * force[0]
        for c in range(markers.size[m]):
            total += state.B[k, c] * force[c]
        residual[markers.coordinate[k]] += factor * total


@inner
def outer(size, force, vectors, out):
    """Sum out = sum_m F_m X_m^T, so that sum_m F_m . M X_m = <M, out> for any matrix M."""
    for i in range(3):
        for j in range(3):
            out[i, j] = force[i] * vectors[j]
            for m in range(3, size, 3):
                out[i, j] += force[m + i] * vectors[m + j]


@inner
def turn_back(size, matrix, force, out):
    """Vectors out_m = M^T F_m, so that sum_m F_m . M X_m = sum_m out_m . X_m for any vectors X_m."""
    for m in range(0, size, 3):
        for i in range(3):
            out[m + i] = matrix[0, i] * force[m] + matrix[1, i] * force[m + 1] + matrix[2, i] * force[m + 2]


@inner
def contract(size, matrix, force, vectors):
    """Sum sum_m F_m . M X_m over the vectors of a pose."""
    total = 0 * force[0]
    for m in range(0, size, 3):
        for i in range(3):
            total += force[m + i] * (matrix[i, 0] * vectors[m] + matrix[i, 1] * vectors[m + 1] + matrix[i, 2] * vectors[m + 2])
    return total


@inner
def add_spatial_stiffness(markers, state, m, force, factor, positions, stride, offset, values):
    """values += factor * d(B^T F)/dq at constant F.

    `positions[i * stride + k]` holds where the local entry (i, k) is stored; `offset` numbers this marker's first column.
    """
    f, frames = markers.frame[m], state.frames
    n_b, first = markers.turns[m], markers.start[m] + markers.moves[m]
    turn = offset + markers.moves[m]
    square, curved = frames.scratch, state.square
    if n_b > 0:
        outer(markers.size[m], force, state.local[m], square)
        second_products(markers.frames, frames, f, square, curved)
    for i in range(n_b):
        for k in range(n_b):
            values[positions[(turn + i) * stride + turn + k]] += factor * curved[i, k]
    for i in range(n_b):
        back = state.motion[3]
        turn_back(markers.size[m], frames.A_k[f, i], force, back)
        for column in range(first + n_b, markers.start[m + 1]):
            k, entry = offset + column - markers.start[m], 0 * force[0]
            for c in range(markers.size[m]):
                entry += back[c] * state.slope[column, c]
            values[positions[(turn + i) * stride + k]] += factor * entry
            values[positions[k * stride + turn + i]] += factor * entry
    if markers.bends[m] == 1:
        add_bent_stiffness(markers, state, m, force, factor, positions, stride, offset, values)


@inner
def add_bent_stiffness(markers, state, m, force, factor, positions, stride, offset, values):
    """Add the entries between elastic coordinates, T_i . S T_j with S_il = F_m . A D_il."""
    stiffness, back, acts = state.frames.scratch, state.motion[3], False
    turn_back(markers.size[m], state.frames.A[markers.frame[m]], force, back)
    for i in range(3):
        for j in range(i, 3):
            entry = 0 * force[0]
            for c in range(3, markers.size[m]):
                entry += back[c] * state.bend[m, second_index(i, j), c]
            stiffness[i, j], stiffness[j, i] = entry, entry
            acts = acts or entry != 0
    if not acts:  # nothing turns the axes
        return
    first, last = markers.start[m] + markers.moves[m] + markers.turns[m], markers.start[m + 1]
    for row in range(first, last):
        T, at = markers.shape[row, 3:6], (offset + row - markers.start[m]) * stride + offset + first - markers.start[m]
        x = factor * (T[0] * stiffness[0, 0] + T[1] * stiffness[1, 0] + T[2] * stiffness[2, 0])
        y = factor * (T[0] * stiffness[0, 1] + T[1] * stiffness[1, 1] + T[2] * stiffness[2, 1])
        z = factor * (T[0] * stiffness[0, 2] + T[1] * stiffness[1, 2] + T[2] * stiffness[2, 2])
        for column in range(first, last):
            T = markers.shape[column]
            values[positions[at + column - first]] += x * T[3] + y * T[4] + z * T[5]


@inner
def add_spatial_force_design(markers, state, m, d, force, factor, residual_x):
    """residual_x += factor * d(B^T F)/dx at constant F, with the derivatives of X_m and X_m,j that `marker_design` left."""
    x, f, frames = markers.design_variable[d], markers.frame[m], state.frames
    first = markers.start[m] + markers.moves[m]
    for k in range(markers.turns[m]):
        residual_x[markers.coordinate[first + k], x] += factor * contract(
            markers.size[m], frames.A_k[f, k], force, state.local_x[d]
        )
    for k in range(first + markers.turns[m], markers.start[m + 1]):
        row = markers.design_shape_start[d] + k - markers.start[m]
        residual_x[markers.coordinate[k], x] += factor * contract(markers.size[m], frames.A[f], force, state.slope_x[row])
