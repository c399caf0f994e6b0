"""Whether a symmetric matrix is positive definite, at the price of what is not zero in it."""

from __future__ import annotations

import numpy as np

from toolkit.reduced_model.thin_arrays import is_thin


def positive_definite(matrix: np.ndarray) -> bool:
    """Whether a symmetric matrix is positive definite.

    By Cholesky's factors; a large matrix that is zero nearly everywhere by the pivots of Gauss' elimination in a sparing order.

    A symmetric matrix is positive definite if and only if all pivots of an elimination down its diagonal are positive
    (Sylvester).
    """
    if not is_thin(matrix):
        try:
            np.linalg.cholesky(matrix)
        except np.linalg.LinAlgError:
            return False
        return True
    return _pivots_are_positive(matrix)


def _pivots_are_positive(matrix: np.ndarray) -> bool:
    from scipy.sparse import csc_array  # only large models are worth its start
    from scipy.sparse.linalg import splu

    try:
        found = splu(csc_array(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:  # a pivot is zero
        return False
    return bool(np.array_equal(found.perm_r, found.perm_c) and np.all(found.U.diagonal() > 0))
