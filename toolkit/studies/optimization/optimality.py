"""How nearly a design meets the conditions of Karush, Kuhn and Tucker, and at which multipliers.

    dF = sum of lam_i dc_i,   lam >= 0,   lam_i c_i = 0,   c >= 0;   bounds of variables are constraints like all others

The multipliers are those of non-negative least squares of the first and the third condition together, so that nothing has to be decided
about which constraints are active.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from toolkit.studies.optimization.program import Program, Values
from toolkit.studies.optimization.promise import promised

ROUND_OFF = 1e-12
"""Part of the objective that no derivative decides."""
SURELY = 1e-3
"""Part of what may be left to gain, below which slopes are not asked."""
NOTHING = 1e-4
"""Objective, in parts of its scale, beside which smaller ones are none: a mean of squares may end at zero."""


class Optimality(NamedTuple):
    """What is left of the conditions at a design.

    Attributes
    ----------
    residual
        Largest entry of what multipliers cannot balance, and of the products of multipliers and constraints, in parts of the objective's
        scale, or of its largest derivative there if that is more: by less than this part it would change over the whole range of a
        variable. A number that is added to the objective changes nothing.
    violation
        Largest violation of a constraint, in parts of its size.
    multipliers
        Of all constraints, (m,).
    at_bounds
        Multipliers of the least and the largest values of the variables, (2, n).
    gain
        What is to be gained at most by the curvature that the objective tells, and by the slopes of the constraints, in parts of the
        objective; zero where it tells none. A search of few designs has seen steep slopes only, beside which a residual looks small.
    """

    residual: float
    violation: float
    multipliers: np.ndarray
    at_bounds: np.ndarray
    gain: float = 0.0

    def met(self, optimality: float, feasibility: float) -> bool:
        """Whether nothing of size is left; where next to nothing is to be gained, slopes need not be small beside those of other designs,
        all of which may stand at the optimum."""
        flat = self.residual <= optimality or 0 < self.gain <= SURELY * optimality
        return flat and self.gain <= optimality and self.violation <= feasibility


def optimality_of(program: Program, z: np.ndarray, found: Values, typical: float) -> Optimality:
    """What is left at z; `typical` is a large change of the scaled objective."""
    n, identity = len(z), np.eye(len(z))
    constraints = np.concatenate([found.c, z, program.top - z])
    slopes = np.vstack([found.dc, identity, -identity])
    matrix = np.vstack([slopes.T, np.diag(constraints)])
    wanted = np.concatenate([found.df, np.zeros(len(constraints))])
    multipliers, _ = nnls(matrix, wanted)
    left = np.abs(matrix @ multipliers - wanted)
    scale = max(float(np.max(np.abs(found.df))), typical, ROUND_OFF * abs(found.f), np.finfo(float).tiny)
    violation = max(0.0, float(np.max(-constraints)))
    m = len(found.c)
    gain = promised(z, program.top - z, found) / max(abs(found.f), NOTHING * scale)
    return Optimality(float(np.max(left)) / scale, violation, multipliers[:m], multipliers[m:].reshape(2, n), gain)
