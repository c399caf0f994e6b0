"""The joints of a scene as flat arrays, in the plane and in space alike."""

from typing import NamedTuple

import numpy as np

from toolkit.joints.kernels.laws import FORMS

CONSTANT, LINEAR, PAIR = 0, 1, 2
"""Kinds of numbers of a form."""
ROWS, SPATIAL_ROWS = 3, 6
"""Most rows of a joint in the plane, and in space."""
NUMBERS, SPATIAL_NUMBERS = 6, 24
"""Of the poses of two markers."""


class Joints(NamedTuple):
    """What never changes; few arrays, because every call of the loop passes them on.

    Rows of a joint follow each other, and so do the forms of a row: one if the row is a form itself. A form has its numbers in `value`:
    its constant, its linear terms, and its pairs, which take two places each.
    """

    numbers: int  # of the poses of two markers
    marker: np.ndarray  # (n_j, 2)
    row: np.ndarray  # (n_j,) number of its first multiplier among all unknowns
    n_rows: np.ndarray  # (n_j,)
    curve: np.ndarray  # (n_j,) time curve that its last row follows, or -1
    designed: np.ndarray  # (n_j,) 1 if any design variable matters to it
    curved: np.ndarray  # (n_j,) 1 if g_zz is not zero
    form: np.ndarray  # (n_j, 3) its first form; in the plane 1 if the axes of marker a count, and of marker b
    law: np.ndarray  # (n_j, most rows, 2) which function, or PLAIN or ANGLE, and number of forms
    start: np.ndarray  # (n_forms + 1, 2) into the next two: the constant, the first pair
    place: np.ndarray  # (n,) of a linear term which number of the poses, of a pair (i, k) which vectors
    value: np.ndarray  # (n,) of a pair (p, q) in the plane, see `planar.joint_kernel`, in space only the first
    block_start: np.ndarray | None  # in space: (n_j * most rows + 1,) into the next
    block: np.ndarray | None  # vectors that a row feels
    design_start: np.ndarray  # (n_j + 1,) into the next two
    design: np.ndarray  # (n_d, 5) variable, row of the joint, form of the row, kind of number (CONSTANT, LINEAR, PAIR), its place
    design_value: np.ndarray  # (n_d, 2) derivative of the value, of a pair of both
    position_start: np.ndarray  # (n_j,) into the next
    position: np.ndarray  # where local entries are stored: coordinates x coordinates, rows x coordinates, transposed

    def work(self, dtype: type) -> "JointWork":
        """Memory for any joint."""
        n, rows, wide = self.numbers, self.law.shape[1], FORMS + 1
        shapes = [(4, n), (2, 2), (rows,), (rows, n), (rows, 3, n), (n, n), (n,), (n,), (4, rows)]
        shapes += [(wide, 5 + n, n), (5 + wide, wide), (rows, FORMS, 5 + FORMS), (rows, FORMS, n)]
        return JointWork(*(np.zeros(shape, dtype) for shape in shapes))


class JointWork(NamedTuple):
    """Scratch memory for one joint: its poses, its rows g, the forms h of one row, and what a law makes of them."""

    pose: np.ndarray  # (4, n) z, both poses; w = B v, their rates; B a; b
    turn: np.ndarray  # (2, 2) cosine and sine of both angles, in the plane
    phi: np.ndarray  # (rows,) g
    phi_z: np.ndarray  # (rows, n)
    along: np.ndarray  # (rows, 3, n): g_zz w, g_zz (B a), g_zz b + d(w g_zz w)/dz
    stiffness: np.ndarray  # (n, n) lam . g_zz, in the plane
    force: np.ndarray  # (n,) g_z^T lam
    dforce: np.ndarray  # (n,)
    row: np.ndarray  # (4, rows) of one direction: d inertial, d applied, d applied by its rate, g_z y
    forms: (
        np.ndarray
    )  # (FORMS + 1, 5 + n, n) h_z, `along` of h, h_zww, h_zz of each form, and of what one number changes in a form
    law: (
        np.ndarray
    )  # (6 + FORMS, FORMS + 1) h and w = h', g, g_h, g_hww, g_hh; behind the last h what one number changes in a form
    composed: np.ndarray  # (rows, FORMS, 5 + FORMS) of each form: g_h, g_hww, h_z w, h_z (B a), h_z b + w h_zz w, g_hh
    form_z: np.ndarray  # (rows, FORMS, n) h_z
