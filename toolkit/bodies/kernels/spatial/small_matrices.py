"""Sums of products with matrices of three by three, and with nine rows of numbers, for bodies in space."""

from toolkit.foundation.kernel import inlined


@inlined
def transposed_product(a, b, out):
    """out = a^T b for matrices of three by three."""
    for i in range(3):
        for j in range(3):
            out[i, j] = a[0, i] * b[0, j] + a[1, i] * b[1, j] + a[2, i] * b[2, j]


@inlined
def by_transpose(a, s, factor, out):
    """out += factor a s^T for matrices of three by three."""
    for i in range(3):
        for j in range(3):
            out[i, j] += factor * (a[i, 0] * s[j, 0] + a[i, 1] * s[j, 1] + a[i, 2] * s[j, 2])


@inlined
def add_matrix(a, out):
    """out += a for matrices of three by three."""
    for i in range(3):
        for j in range(3):
            out[i, j] += a[i, j]


@inlined
def product(a, b):
    """<a, b>, the sum of products of all nine entries."""
    total = 0 * a[0, 0]
    for i in range(3):
        for j in range(3):
            total += a[i, j] * b[i, j]
    return total


@inlined
def flat_product(matrix, nine):
    """<a, b>, the sum of products of all nine entries, with the second matrix as nine numbers in a row."""
    total = 0 * nine[0]
    for i in range(3):
        for j in range(3):
            total += matrix[i, j] * nine[3 * i + j]
    return total


@inlined
def turned_dot(matrix, vector, other):
    """Scalar product other . (matrix vector)."""
    total = 0 * vector[0]
    for i in range(3):
        total += other[i] * (matrix[i, 0] * vector[0] + matrix[i, 1] * vector[1] + matrix[i, 2] * vector[2])
    return total


@inlined
def add_nine_rows(matrix, factor, rows, first, target):
    """target_j += factor <matrix, rows[:, first + j]>, the nine rows in the order of the matrix's entries."""
    m = matrix
    a, b, c = factor * m[0, 0], factor * m[0, 1], factor * m[0, 2]
    d, e, f = factor * m[1, 0], factor * m[1, 1], factor * m[1, 2]
    g, h, i = factor * m[2, 0], factor * m[2, 1], factor * m[2, 2]
    row_a, row_b, row_c = rows[0, first:], rows[1, first:], rows[2, first:]
    row_d, row_e, row_f = rows[3, first:], rows[4, first:], rows[5, first:]
    row_g, row_h, row_i = rows[6, first:], rows[7, first:], rows[8, first:]
    for j in range(len(target)):
        upper = a * row_a[j] + b * row_b[j] + c * row_c[j]
        middle = d * row_d[j] + e * row_e[j] + f * row_f[j]
        target[j] += upper + (middle + (g * row_g[j] + h * row_h[j] + i * row_i[j]))


@inlined
def add_three_rows(x, y, z, rows, first, target):
    """target_j += x rows[0, first + j] + y rows[1, first + j] + z rows[2, first + j]."""
    row_x, row_y, row_z = rows[0, first:], rows[1, first:], rows[2, first:]
    for j in range(len(target)):
        target[j] += x * row_x[j] + y * row_y[j] + z * row_z[j]


@inlined
def along(matrix, column, vector):
    """Entry of matrix^T vector with the number of a column."""
    return matrix[0, column] * vector[0] + matrix[1, column] * vector[1] + matrix[2, column] * vector[2]
