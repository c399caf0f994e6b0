"""The joints of a scene as flat arrays, in the plane and in space alike."""

from typing import Any, NamedTuple

import numpy as np

from toolkit.components.joints.kernels.laws import MOST_FORMS

CONSTANT, LINEAR, PAIR = 0, 1, 2
"""Kinds of numbers of a form."""
ROWS, SPATIAL_ROWS = 3, 6
"""Most rows of a joint in the plane, and in space."""
NUMBERS, SPATIAL_NUMBERS = 6, 24
"""Count of the numbers in the poses of two markers, in the plane and in space."""


MARKER, FIRST_ROW, N_ROWS, CURVE, DESIGNED, CURVED, FORM, TURNED, POSITION, DESIGN, PINNED, LAW = (
    0,
    2,
    3,
    4,
    5,
    6,
    7,
    8,
    10,
    11,
    13,
    14,
)
"""Columns of `Joints.of`: markers a and b; number of its first multiplier among all unknowns; number of rows; time curve that its last row
follows, or -1; 1 if any design variable matters to it; 1 if g_zz is not zero; its first form; in the plane 1 if the axes of marker a
count, and of marker b; start in `position`; start and end in `design`; in the plane 1 if it is a
pin, see `planar_pin`; and for each row which function, or PLAIN or ANGLE, and how many forms."""


class Joints(NamedTuple):
    """Arrays of the joints, which never change.

    They are few, because every call in the loop passes them on: measured, seven more cost a small mechanism a fifth.

    Rows of a joint follow each other, and so do the forms of a row: one if the row is a form itself. A form has its numbers in `value`:
    its constant, its linear terms, and its pairs, which take two places each.
    """

    numbers: int  # of the poses of two markers
    of: np.ndarray  # (n_j, LAW + 2 * most rows)
    start: np.ndarray  # (n_forms + 1, 2) into the next two: the constant, the first pair
    place: np.ndarray  # (n,) of a linear term which number of the poses, of a pair (i, k) which vectors
    value: np.ndarray  # (n,) of a pair (p, q) in the plane, see `planar_forms`, in space only the first
    design: np.ndarray  # (n_d, 5) variable, row of the joint, form of the row, kind of number (CONSTANT, LINEAR, PAIR), its place
    design_value: np.ndarray  # (n_d, 2) derivative of the value, of a pair of both
    position: np.ndarray  # where local entries are stored: coordinates x coordinates, rows x coordinates, transposed
    felt_start: np.ndarray | None  # in space: (n_j * most rows + 1,) into the next
    felt: np.ndarray | None  # vectors that a row feels

    @property
    def marker(self) -> np.ndarray:
        """Markers of every joint, (n_j, 2)."""
        return self.of[:, MARKER : MARKER + 2]

    @property
    def row(self) -> np.ndarray:
        """Number of the first multiplier of every joint among all unknowns."""
        return self.of[:, FIRST_ROW]

    @property
    def n_rows(self) -> np.ndarray:
        """Number of constraint rows of every joint, (n_j,)."""
        return self.of[:, N_ROWS]

    @property
    def curve(self) -> np.ndarray:
        """Time curve of every joint, or -1."""
        return self.of[:, CURVE]

    @property
    def designed(self) -> np.ndarray:
        """1 for joints that any design variable matters to, 0 for others."""
        return self.of[:, DESIGNED]

    def changing(self, j: int) -> np.ndarray:
        """Variables that change a number of joint number j."""
        return self.design[self.of[j, DESIGN] : self.of[j, DESIGN + 1], 0]

    def work(self, dtype: type) -> "JointWork":
        """Scratch memory for any joint."""
        n, rows, wide = self.numbers, (self.of.shape[1] - LAW) // 2, MOST_FORMS + 1
        shapes = [(5, n), (5, rows), (rows, 4, n), (n, n), (2, n)]
        shapes += [(wide, 5 + n, n), (5 + wide, wide), (rows, MOST_FORMS, 5 + MOST_FORMS + n)]
        parts: list[Any] = [*(np.zeros(shape, dtype) for shape in shapes), SPARE]
        return JointWork(*parts)


SPARE = (*[np.zeros(1)] * 2, *[np.zeros((1, 1))] * 6)
"""Nothing. A call in the loop copies every word of its arguments onto the stack, about a thousand, and the processor waits where copy and
source lie a multiple of 4096 bytes apart: measured, a step of a small mechanism takes up to 20 percent longer without these."""
PHI = 4
"""Place of g in `JointWork.row`."""
GRADIENT = 5 + MOST_FORMS
"""Place of h_z in `JointWork.composed`."""


class JointWork(NamedTuple):
    """Scratch memory for one joint: its poses, its rows g, the forms h of one row, and what a law makes of them."""

    pose: np.ndarray  # (5, n) z, both poses; w = B v, their rates; B a; b; in the plane cosine and sine of both angles
    row: np.ndarray  # (5, rows) of one direction: d inertial, d applied, d applied by its rate, g_z y; and g
    slope: np.ndarray  # (rows, 4, n) g_z; along the rates: g_zz w, g_zz (B a), g_zz b + d(w g_zz w)/dz
    stiffness: np.ndarray  # (n, n) lam . g_zz, in the plane
    force: np.ndarray  # (2, n) g_z^T lam, and its derivative in one direction
    forms: np.ndarray  # (MOST_FORMS + 1, 5 + n, n) as `slope`, h_zww, h_zz of each form, and of what one number changes in a form
    law: (
        np.ndarray
    )  # (6 + MOST_FORMS, MOST_FORMS + 1) h, w = h', g, g_h, g_hww, g_hh; behind the last h what one number changes in a form
    composed: (
        np.ndarray
    )  # (rows, MOST_FORMS, 5 + MOST_FORMS + n) of each form: g_h, g_hww, h_z w, h_z (B a), h_z b + w h_zz w, g_hh, h_z
    spare: tuple  # see SPARE
