"""What is constant in the equations of motion: rigid bodies (frame at the centre of mass) and grounded flexible bodies.

With the constant force f, in the two groups of the residual:

    inertial: M a        applied: D v + K q - scale f,    scale = 1 but in a stepwise loaded static analysis
"""

from typing import NamedTuple

import numpy as np

from toolkit.kernel import inner


class Constant(NamedTuple):
    """Entries of M, D, K (global rows and columns), the constant force f, and their design derivatives."""

    row: np.ndarray  # (n_entries,)
    column: np.ndarray
    position: np.ndarray  # where the entry is stored in the pattern
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    force: np.ndarray  # (n_q,)
    design_entry: np.ndarray  # (n_d,) which entry
    design_variable: np.ndarray
    design_mass: np.ndarray
    design_damping: np.ndarray
    design_stiffness: np.ndarray
    force_row: np.ndarray  # (n_d,) which entry of f
    force_variable: np.ndarray
    design_force: np.ndarray


@inner
def constant_residual(part, q, v, acc, scale, inertial, applied):
    """Residual of the constant part."""
    for e in range(len(part.row)):
        i, k = part.row[e], part.column[e]
        inertial[i] += part.mass[e] * acc[k]
        applied[i] += part.damping[e] * v[k] + part.stiffness[e] * q[k]
    for i in range(len(part.force)):
        applied[i] -= scale * part.force[i]


@inner
def constant_jacobian(part, I_acc, A_q, A_v):
    """The same entries in every step."""
    for e in range(len(part.row)):
        at = part.position[e]
        I_acc[at] += part.mass[e]
        A_q[at] += part.stiffness[e]
        A_v[at] += part.damping[e]


@inner
def constant_design(part, q, v, acc, scale, I_x, A_x):
    """Partial design derivatives of the residual."""
    for d in range(len(part.design_entry)):
        i, k, x = part.row[part.design_entry[d]], part.column[part.design_entry[d]], part.design_variable[d]
        I_x[i, x] += part.design_mass[d] * acc[k]
        A_x[i, x] += part.design_damping[d] * v[k] + part.design_stiffness[d] * q[k]
    for d in range(len(part.force_row)):
        A_x[part.force_row[d], part.force_variable[d]] -= scale * part.design_force[d]
