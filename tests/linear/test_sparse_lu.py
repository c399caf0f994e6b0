"""Sparse LU of saddle-point matrices without pivoting, and its dense fallback."""

import tracemalloc
from functools import partial

import numpy as np
import pytest

from toolkit.foundation.compiled.calls import call
from toolkit.foundation.compiled.rows import filled_up
from toolkit.foundation.errors import InputError
from toolkit.foundation.kernel import plain
from toolkit.linear import sparse_lu
from toolkit.linear.linear_solver import (
    dense_factor,
    dense_solve,
    dense_solve_block,
    linear_solver,
    solve_block,
    solve_once,
    to_dense,
    updates_of,
)
from toolkit.linear.sparse_analysis import analyse, minimum_degree

COMPILED = partial(partial, call)
"""A kernel as the program calls it, which compiles it once for both."""
EPS = np.finfo(float).eps
TOLERANCE = 1e-12  # as recommended in sparse_lu


def mechanism(rng, n_bodies=7, n_beam=8):
    """Unsymmetric saddle-point matrix (dense): a chain of planar bodies, two constraints per joint, with a beam at its end."""
    n_q = 3 * (n_bodies + n_beam)
    matrix = np.zeros((n_q + 2 * n_bodies, n_q + 2 * n_bodies))
    for first in range(0, 3 * n_bodies, 3):
        add_definite(rng, matrix, slice(first, first + 3))
    for first in range(3 * n_bodies, n_q - 3, 3):
        add_definite(rng, matrix, slice(first, first + 6))
    for joint in range(n_bodies):
        rows = slice(n_q + 2 * joint, n_q + 2 * joint + 2)
        for first in (3 * joint, 3 * joint + 3):  # the last joint ties the first node of the beam
            jacobian = rng.normal(size=(2, 3))
            matrix[rows, first : first + 3] = jacobian
            matrix[first : first + 3, rows] = jacobian.T * (1 + 0.01 * rng.normal(size=(3, 2)))
    return matrix, n_q


def add_definite(rng, matrix, block):
    """A block with positive definite symmetric part and some gyroscopic terms."""
    size = block.stop - block.start
    factor, gyroscopic = rng.normal(size=(2, size, size))
    matrix[block, block] += factor @ factor.T + np.eye(size) + 0.1 * (gyroscopic - gyroscopic.T)


def csr(matrix):
    """CSR arrays on the symmetric pattern with full diagonal."""
    pattern = (matrix != 0) | (matrix.T != 0) | np.eye(len(matrix), dtype=bool)
    row, column = np.nonzero(pattern)
    indptr = np.searchsorted(row, np.arange(len(matrix) + 1))
    return indptr, column, matrix[row, column]


def factorized(matrix, n_q, run=COMPILED):
    """status, plan, lu by the compiled kernel, or by `run(kernel)`."""
    indptr, indices, values = csr(matrix)
    plan = analyse(indptr, indices, n_q)
    lu, work = np.full(plan.row_start[-1], np.nan, values.dtype), np.full(len(matrix), np.nan, values.dtype)
    return run(sparse_lu.factor)(plan, values, lu, work, TOLERANCE, sparse_lu.still_pivots(plan, values.dtype)), plan, lu


def solved(matrix, n_q, rhs, run=COMPILED):
    status, plan, lu = factorized(matrix, n_q, run)
    assert status == -1
    x = rhs.astype(lu.dtype)
    if rhs.ndim == 1:
        run(sparse_lu.solve)(plan, lu, x, np.full_like(x, np.nan))
        return x
    filled = np.zeros((len(x), filled_up(x.shape[1])), x.dtype)
    filled[:, : x.shape[1]] = x
    run(solve_block)(plan, lu, filled, np.full_like(filled, np.nan))
    return filled[:, : x.shape[1]]


def dense_solved(matrix, rhs, run=COMPILED):
    n = len(matrix)
    a, pivots, x = matrix.copy(), np.zeros(n, dtype=np.int64), rhs.astype(matrix.dtype)
    assert run(dense_factor)(a, pivots, np.empty((3, n)), 1e-14) == -1
    solve = dense_solve if rhs.ndim == 1 else dense_solve_block
    run(solve)(a, pivots, x)
    return x


def round_off(matrix):
    """Relative error to expect of a solution: the condition number times eps, times 100 for the growth without pivoting."""
    return 100 * EPS * np.linalg.cond(matrix)


def error(x, reference):
    return np.linalg.norm(x - reference) / np.linalg.norm(reference)


@pytest.mark.parametrize("seed", range(8))
def test_solution_agrees_with_pivoted_lapack(seed):
    rng = np.random.default_rng(seed)
    matrix, n_q = mechanism(rng)
    rhs = rng.normal(size=len(matrix))
    assert error(solved(matrix, n_q, rhs), np.linalg.solve(matrix, rhs)) < round_off(matrix)


@pytest.mark.parametrize("seed", range(4))
def test_units_that_differ_by_1e18_cost_no_digits(seed):
    rng = np.random.default_rng(seed)
    matrix, n_q = mechanism(rng)
    rhs = rng.normal(size=len(matrix))
    row_unit, column_unit = 10.0 ** rng.uniform(-9, 9, size=(2, len(matrix)))
    scaled = row_unit[:, None] * matrix * column_unit
    reference = np.linalg.solve(matrix, rhs)  # before scaling, where the condition number means something
    assert error(column_unit * solved(scaled, n_q, row_unit * rhs), reference) < round_off(matrix)
    assert error(column_unit * dense_solved(scaled, row_unit * rhs), reference) < round_off(matrix)


def test_units_that_are_powers_of_two_change_no_bit():
    rng = np.random.default_rng(0)
    matrix, n_q = mechanism(rng)
    rhs = rng.normal(size=len(matrix))
    row_unit, column_unit = 2.0 ** rng.integers(-30, 30, size=(2, len(matrix)))
    scaled = row_unit[:, None] * matrix * column_unit
    assert np.array_equal(column_unit * solved(scaled, n_q, row_unit * rhs), solved(matrix, n_q, rhs))


@pytest.mark.parametrize("columns", [1, 4, 7, 12, 21])
def test_every_column_of_a_block_is_the_solution_of_its_vector(columns):
    rng = np.random.default_rng(columns)
    matrix, n_q = mechanism(rng)
    rhs = rng.normal(size=(len(matrix), columns))
    block = solved(matrix, n_q, rhs)
    for x in range(columns):
        assert error(block[:, x], solved(matrix, n_q, rhs[:, x].copy())) < round_off(matrix)


def test_a_wide_block_has_the_bits_of_narrow_ones():
    rng = np.random.default_rng(0)
    matrix, n_q = mechanism(rng)
    rhs = rng.normal(size=(len(matrix), 24))
    narrow = [solved(matrix, n_q, rhs[:, x : x + 4].copy()) for x in range(0, 24, 4)]
    for columns in (5, 12, 24):  # in one vector, two and three
        assert np.array_equal(solved(matrix, n_q, rhs[:, :columns].copy()), np.hstack(narrow)[:, :columns])


@pytest.mark.parametrize("seed", range(4))
def test_pivots_that_never_change_are_eliminated_once_and_serve_for_other_matrices(seed):
    rng = np.random.default_rng(seed)
    matrix, n_q = mechanism(rng, n_beam=20)
    moving = np.arange(len(matrix)) >= n_q
    moving[:24] = moving[39] = True  # the rigid bodies, the beam's first node, and one within it
    indptr, indices, _ = csr(matrix)
    plan = analyse(indptr, indices, n_q, moving)
    still = int(plan.still[0])
    assert still == np.count_nonzero(~moving)
    assert not moving[plan.order[:still]].any()
    solver, other = (linear_solver(plan, np.ones(n_q), 0, float) for _ in range(2))
    rhs, nothing = rng.normal(size=len(matrix)), np.zeros((len(matrix), 0))
    between = np.ix_(moving, moving)
    for turn in range(4):
        if turn == 2:  # what never changes does so after all: all is done anew
            matrix[25, 25] *= 1.5
        matrix[between] *= 1 + 0.1 * rng.normal(size=(np.count_nonzero(moving),) * 2) * (matrix[between] != 0)
        eliminated = solver.kept.made[0] == 1 and turn != 2
        kept, values = solver.lu[: plan.row_start[still]].copy(), csr(matrix)[2]
        found, fresh = np.zeros((2, len(matrix)))
        assert call(solve_once, solver, indptr, indices, values, rhs, found, nothing, nothing) == -1
        assert np.array_equal(kept, solver.lu[: plan.row_start[still]]) == eliminated
        assert error(found, np.linalg.solve(matrix, rhs)) < round_off(matrix)
        other.kept.made[0] = 0
        assert call(solve_once, other, indptr, indices, values, rhs, fresh, nothing, nothing) == -1
        assert np.array_equal(found, fresh)


def test_a_singular_pivot_among_those_that_never_change_is_found_every_time():
    matrix, n_q = mechanism(np.random.default_rng(0))
    moving = np.arange(len(matrix)) >= n_q
    moving[:24] = True
    matrix[40, :], matrix[:, 40] = np.where(matrix[40] != 0, 1e-300, 0), np.where(matrix[:, 40] != 0, 1e-300, 0)
    matrix[40, 40] = 0.0
    indptr, indices, values = csr(matrix)
    plan = analyse(indptr, indices, n_q, moving)
    lu, work, kept = np.zeros(plan.row_start[-1]), np.zeros(len(matrix)), sparse_lu.still_pivots(plan, float)
    for _ in range(2):
        assert COMPILED(sparse_lu.factor)(plan, values, lu, work, TOLERANCE, kept) == 40
        assert kept.made[0] == 0


def test_multiplications_of_a_factorisation_are_counted():
    rng = np.random.default_rng(0)
    matrix, n_q = mechanism(rng)
    indptr, indices, _ = csr(matrix)
    plan, counted = analyse(indptr, indices, n_q), 0
    for k in range(len(matrix)):  # the loops of `factor`
        for _ in range(plan.diagonal[k] + 1, plan.row_start[k + 1]):
            counted += 1 + (plan.row_start[k + 1] - plan.diagonal[k] - 1)
    assert updates_of(plan) == counted


def test_tiny_mass_beside_stiff_spring_and_constraint_is_not_refused():
    # two masses of 1e-9 and 2e-9 on a spring of 1e7, the second one held by a constraint with entries of 1
    mass, stiffness, step = np.array([1e-9, 2e-9]), 1e7, 1e-4
    matrix = np.array([[stiffness, -stiffness, 0.0], [-stiffness, stiffness, 1.0], [0.0, 1.0, 0.0]])
    matrix[[0, 1], [0, 1]] += mass / step**2
    x = solved(matrix, 2, np.array([3.0, 0.0, 0.5]))
    q_1 = (3.0 + stiffness * 0.5) / (mass[0] / step**2 + stiffness)
    # q_2 is given and q_1 a quotient of sums without cancellation: a few eps
    assert np.allclose(x[:2], [q_1, 0.5], rtol=1e-14, atol=0)


def assert_multipliers_come_late(matrix, n_q):
    indptr, indices, _ = csr(matrix)
    order = analyse(indptr, indices, n_q).order
    assert np.array_equal(np.sort(order), np.arange(len(matrix)))
    position = np.argsort(order)
    for multiplier in range(n_q, len(matrix)):
        row = indices[indptr[multiplier] : indptr[multiplier + 1]]
        assert position[row[row < n_q]].max() < position[multiplier]


@pytest.mark.parametrize("seed", range(4))
def test_every_multiplier_follows_all_coordinates_that_it_couples_to(seed):
    rng = np.random.default_rng(seed)
    matrix, n_q = mechanism(rng)
    shuffle = np.append(rng.permutation(n_q), np.arange(n_q, len(matrix)))
    assert_multipliers_come_late(matrix[np.ix_(shuffle, shuffle)], n_q)


@pytest.mark.parametrize("n_tied", [1, 2, 3])
def test_multiplier_of_few_coordinates_waits_although_its_degree_is_smallest(n_tied):
    matrix = np.ones((9, 9))
    matrix[8, n_tied:] = matrix[n_tied:, 8] = 0.0
    assert_multipliers_come_late(matrix, 8)


def test_multiplier_between_particle_and_flexible_body_waits_for_the_body():
    matrix = np.ones((9, 9))
    matrix[0, 1:8] = matrix[1:8, 0] = 0.0  # coordinate 0 is the particle: once it is gone, the multiplier has degree 1
    matrix[8, 2:8] = matrix[2:8, 8] = 0.0
    assert_multipliers_come_late(matrix, 8)


def test_multiplier_does_not_wait_for_bodies_that_it_does_not_tie():
    matrix, n_q = mechanism(np.random.default_rng(0))
    indptr, indices, _ = csr(matrix)
    position = np.argsort(analyse(indptr, indices, n_q).order)
    assert position[n_q] < position[:n_q].max()


def test_factors_multiply_to_the_permuted_matrix():
    matrix, n_q = mechanism(np.random.default_rng(0))
    _, plan, lu = factorized(matrix, n_q)
    n = len(matrix)
    full = np.zeros((n, n))
    full[np.repeat(np.arange(n), np.diff(plan.row_start)), plan.column] = lu
    lower, upper = np.tril(full, -1) + np.eye(n), np.triu(full, 1) + np.diag(1 / full.diagonal())
    # n eps |L| |U| bounds the rounding of an elimination (Higham 2002, theorem 9.3)
    assert np.all(abs(lower @ upper - matrix[np.ix_(plan.order, plan.order)]) <= n * EPS * (abs(lower) @ abs(upper)))


def test_tridiagonal_pattern_has_no_fill():
    n = 50
    indptr, indices, values = csr(np.eye(n) + np.eye(n, k=1) + np.eye(n, k=-1))
    assert analyse(indptr, indices, n).row_start[-1] == len(values)


def test_fill_of_a_chain_of_bodies_grows_linearly():
    fill = []
    for n_bodies in (10, 20, 40):
        indptr, indices, values = csr(mechanism(np.random.default_rng(0), n_bodies)[0])
        fill.append(analyse(indptr, indices, 3 * (n_bodies + 8)).row_start[-1] - len(values))
    assert fill[2] - fill[1] <= 2 * (fill[1] - fill[0]) + 12  # 12: a block of one joint more or less


@pytest.mark.parametrize("n_f", [1, 3, 4, 5, 30])
def test_dense_body_with_constraints_is_solved(n_f):
    rng = np.random.default_rng(n_f)
    matrix = np.zeros((n_f + 1, n_f + 1))
    add_definite(rng, matrix, slice(0, n_f))
    matrix[n_f, :n_f] = matrix[:n_f, n_f] = rng.normal(size=n_f)
    rhs = rng.normal(size=n_f + 1)
    assert error(solved(matrix, n_f, rhs), np.linalg.solve(matrix, rhs)) < round_off(matrix)


def rigid_chain(rng, n_bodies):
    """As `mechanism`, bodies of seven coordinates with three constraints per joint, as in space: (matrix, n_q)."""
    n_q = 7 * n_bodies
    matrix = np.zeros((n_q + 3 * n_bodies, n_q + 3 * n_bodies))
    for body in range(n_bodies):
        add_definite(rng, matrix, slice(7 * body, 7 * body + 7))
        rows = slice(n_q + 3 * body, n_q + 3 * body + 3)
        for first in range(7 * max(body - 1, 0), 7 * body + 7, 7):
            jacobian = rng.normal(size=(3, 7))
            matrix[rows, first : first + 7] = jacobian
            matrix[first : first + 7, rows] = jacobian.T
    return matrix, n_q


@pytest.mark.parametrize("seed", range(4))
def test_pivots_are_eliminated_together_although_their_neighbours_are_scattered(seed):
    rng = np.random.default_rng(seed)
    matrix, n_q = rigid_chain(rng, 9)
    _, plan, _ = factorized(matrix, n_q)
    assert plan.together.max() > 1  # runs of adjacent columns behind four pivots
    rhs = rng.normal(size=len(matrix))
    assert error(solved(matrix, n_q, rhs), np.linalg.solve(matrix, rhs)) < round_off(matrix)


def test_a_dense_body_is_eliminated_four_by_four():
    matrix = np.ones((31, 31))
    assert np.count_nonzero(analyse(*csr(matrix)[:2], 30).together) == 7  # behind the last three nothing is left for a fourth


def test_refused_pivot_within_four_is_named():
    matrix, _ = mechanism(np.random.default_rng(0), n_bodies=0, n_beam=3)
    matrix += 0.1
    matrix[:, 2] = matrix[:, 1]  # zero but for round-off once 1 is gone
    assert factorized(matrix, len(matrix))[0] == 2


@pytest.mark.parametrize("seed", range(4))
def test_what_each_pivot_couples_to_is_the_fill_of_an_elimination_in_this_order(seed):
    rng = np.random.default_rng(seed)
    matrix, n_q = mechanism(rng)
    chosen = rng.permutation(len(matrix))[:6]
    matrix[np.ix_(chosen, chosen)] = 1.0  # a clique across the chain
    indptr, indices, _ = csr(matrix)
    order, below = minimum_degree(indptr, indices, n_q)
    fill = matrix != 0
    fill |= fill.T
    gone = np.zeros(len(matrix), bool)
    for pivot, later in zip(order, below, strict=True):
        gone[pivot] = True
        expected = np.flatnonzero(fill[pivot] & ~gone)
        assert np.array_equal(np.sort(later), expected)
        fill[np.ix_(expected, expected)] = True


def test_analysis_takes_memory_by_entries_and_not_by_the_square_of_the_unknowns():
    n = 12000
    near = np.arange(n)[:, None] + np.arange(-1, 2)
    inside = (near >= 0) & (near < n)
    indptr, indices = np.concatenate([[0], np.cumsum(inside.sum(axis=1))]), near[inside]
    tracemalloc.start()
    analyse(indptr, indices, n)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < n * n / 2  # bytes; a matrix of booleans alone would be twice that, and objects of 3 n entries are 30 MB


@pytest.mark.parametrize("n_x", [0, 1, 3, 4, 5, 8, 11])
def test_block_solution_is_the_solution_of_each_column(n_x):
    rng = np.random.default_rng(0)
    matrix, n_q = mechanism(rng)
    rhs = rng.normal(size=(len(matrix), n_x))
    block, dense_block = solved(matrix, n_q, rhs), dense_solved(matrix, rhs)
    for x in range(n_x):
        assert error(block[:, x], solved(matrix, n_q, rhs[:, x])) < round_off(matrix)
        assert error(dense_block[:, x], dense_solved(matrix, rhs[:, x])) < round_off(matrix)


@pytest.mark.parametrize("n_x", [None, 5])
def test_plain_python_solves_complex_systems(n_x):
    rng = np.random.default_rng(0)
    matrix, n_q = mechanism(rng, n_bodies=3, n_beam=3)
    matrix = matrix * (1 + 0.1j * rng.normal(size=matrix.shape))
    rhs = rng.normal(size=(len(matrix), *([n_x] if n_x else []))) + 1j
    reference = np.linalg.solve(matrix, rhs)
    assert error(solved(matrix, n_q, rhs, plain), reference) < round_off(matrix)
    assert error(dense_solved(matrix, rhs, plain), reference) < round_off(matrix)


def test_complex_step_gives_the_derivative_of_the_solution():
    rng = np.random.default_rng(0)
    matrix, n_q = mechanism(rng, n_bodies=3, n_beam=3)
    rhs, direction = rng.normal(size=len(matrix)), matrix * rng.normal(size=matrix.shape)
    dx = solved(matrix + 1e-30j * direction, n_q, rhs, plain).imag / 1e-30
    reference = -np.linalg.solve(matrix, direction @ np.linalg.solve(matrix, rhs))
    assert error(dx, reference) < round_off(matrix)


def held_by_joint_only():
    """Springs and masses; coordinate 2 has neither, but multiplier 5 ties it to coordinate 3, so all is determined."""
    matrix = np.diag([2.0, 2.0, 0.0, 1.0, 3.0, 0.0])
    matrix[0, 1] = matrix[1, 0] = matrix[3, 4] = matrix[4, 3] = -1.0
    matrix[2, 5] = matrix[5, 2] = 1.0
    matrix[3, 5] = matrix[5, 3] = -1.0
    return matrix


def test_coordinate_without_stiffness_is_named_and_the_dense_fallback_solves():
    matrix, rhs = held_by_joint_only(), np.arange(1.0, 7.0)
    status, *_ = factorized(matrix, 5)
    assert status == 2
    assert error(dense_solved(matrix, rhs), np.linalg.solve(matrix, rhs)) < round_off(matrix)


@pytest.mark.parametrize("seed", range(4))
def test_redundant_constraint_is_named_by_one_of_its_multipliers(seed):
    rng = np.random.default_rng(seed)
    matrix, n_q = mechanism(rng)
    matrix[n_q + 4], matrix[:, n_q + 4] = 3.0 * matrix[n_q + 5], 0.5 * matrix[:, n_q + 5]
    unit = 10.0 ** rng.uniform(-9, 9, size=len(matrix))
    assert factorized(unit[:, None] * matrix * unit, n_q)[0] in (n_q + 4, n_q + 5)


def test_dense_factor_names_the_unknown_that_no_equation_determines():
    matrix = np.random.default_rng(0).normal(size=(6, 6))
    matrix[:, 4] = 0.0
    assert call(dense_factor, matrix, np.zeros(6, dtype=np.int64), np.empty((3, 6)), 1e-14) == 4


def test_value_that_is_not_a_number_is_refused():
    matrix, n_q = mechanism(np.random.default_rng(0))
    matrix[4, 4] = np.nan
    assert factorized(matrix, n_q)[0] >= 0
    n = len(matrix)
    assert call(dense_factor, matrix, np.zeros(n, dtype=np.int64), np.empty((3, n)), 1e-14) >= 0


def test_multiply_and_to_dense_agree_with_the_matrix():
    rng = np.random.default_rng(0)
    matrix, _ = mechanism(rng)
    x, y, a = rng.normal(size=len(matrix)), np.full(len(matrix), np.nan), np.full(matrix.shape, np.nan)
    indptr, indices, values = csr(matrix)
    call(sparse_lu.multiply, indptr, indices, values, x, y)
    call(to_dense, indptr, indices, values, a)
    assert np.array_equal(a, matrix)
    assert np.allclose(y, matrix @ x, rtol=0, atol=len(x) * EPS * (abs(matrix) @ abs(x)).max())  # another order of summation


def test_growth_that_the_pivot_test_cannot_see_is_found_by_refinement_and_mended_by_pivoting():
    matrix, rhs = np.array([[1e-20, 1.0], [1.0, 1.0]]), np.array([1.0, 3.0])
    indptr, indices, values = csr(matrix)
    solver, solution = linear_solver(analyse(indptr, indices, 2), np.ones(2), 0, float), np.zeros(2)
    assert abs(solved(matrix, 2, rhs) - [2, 1]).max() > 0.1  # without pivoting
    failed = call(solve_once, solver, indptr, indices, values, rhs, solution, np.zeros((2, 0)), np.zeros((2, 0)))
    assert failed < 0
    assert solver.mode[0] == 1
    np.testing.assert_allclose(solution, [2, 1], rtol=4 * EPS)


@pytest.mark.parametrize("pivot", [1e-11, 1e-12])
def test_growth_that_two_refinements_mend_takes_no_pivoting(pivot):
    """The tiny pivot leaves some EPS / pivot, 1e-6 to 1e-4, which one refinement squares; the second leaves round-off."""
    matrix, rhs = np.array([[pivot, 1.0], [1.0, 1.0]]), np.array([1.0, 3.0])
    indptr, indices, values = (np.ascontiguousarray(each) for each in csr(matrix))  # as those of a scene are
    solver, solution, several = linear_solver(analyse(indptr, indices, 2), np.ones(2), 2, float), np.zeros(2), np.zeros((2, 2))
    block = np.array([[1.0, 0.0], [3.0, 1.0]])
    exact = np.linalg.solve(matrix, block)
    assert abs(solved(matrix, 2, rhs) - exact[:, 0]).max() > 1e-6
    assert call(solve_once, solver, indptr, indices, values, rhs, solution, block, several) < 0
    assert solver.mode[0] == 0
    np.testing.assert_allclose(solution, exact[:, 0], rtol=8 * EPS)
    np.testing.assert_allclose(several, exact, rtol=8 * EPS)


def test_pattern_without_a_diagonal_entry_is_refused():
    with pytest.raises(InputError, match="row 1 of the pattern has no diagonal"):
        analyse(np.array([0, 2, 3]), np.array([0, 1, 0]), 1)


def test_unsymmetric_pattern_is_refused():
    with pytest.raises(InputError, match=r"entry \(0, 1\) but not \(1, 0\)"):
        analyse(np.array([0, 2, 3]), np.array([0, 1, 1]), 2)


def test_unsorted_pattern_is_refused():
    with pytest.raises(InputError, match="do not ascend"):
        analyse(np.array([0, 2, 4]), np.array([1, 0, 0, 1]), 2)
