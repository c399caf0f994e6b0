"""Formulation of the constraints in a time step: as weights of their acceleration, velocity and position.

    "index-1"       phi'' + 2 damping phi' + stiffness^2 phi = 0, Baumgarte's stabilization (1972), by default 1/tau and sqrt(2)/tau
                    with tau the step, or after a longer one what time has left of it: see `relaxed`
    "index-3"       phi / c_q = 0 with c_q = d q_+ / d a_+ of the step: positions closed to round-off, Newton's matrix as in index 1
                    (Arnold and Bruels 2007; the scaling is that of Bottasso, Dopico and Trainelli 2008)
    "ggl"           phi' / c_v = 0 with c_v = d v_+ / d a_+, and phi / c_q = 0 with more multipliers, see `ggl_step`: velocities and
                    positions closed to round-off
    quasi-static    positions, as index 3

Multipliers of index 3 carry round-off of 1e-16 of the model size over h^2, and velocities leave the constraint by O(h^2); those of
"ggl" carry that of velocities over h.
"""

from __future__ import annotations

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.solvers.transient.scheme import QUASI_STATIC, Scheme, generalized_alpha


def scheme_of(options: RunOptions) -> Scheme:
    """Coefficients of the run's scheme, for steps of length 1."""
    return QUASI_STATIC if options.quasi_static else generalized_alpha(options.scheme, options.rho_inf)


def relaxed(lengths: np.ndarray, before: float = 0.0) -> np.ndarray:
    """Times tau (n,) in which Baumgarte's defaults close a gap: tau_n = max(h_n, tau_(n-1) exp(-h_n / tau_(n-1))).

    A step leaves joints open by what its own length makes of the motion. A much shorter one must not close them in its own time, which
    would be a blow. `before` is tau of the step before the first, if there is one.
    """
    if np.all(lengths == lengths[0]) and before <= lengths[0]:
        return lengths
    found = lengths.copy()
    for n, h in enumerate(lengths):
        found[n] = max(h, before * np.exp(-h / before)) if before > 0 else h
        before = found[n]
    return found


def constraint_levels(options: RunOptions, lengths: np.ndarray, times: np.ndarray | None = None) -> np.ndarray:
    """Weights (k_2, k_1, k_0) of acceleration, velocity and position in the constraint rows of steps of lengths (n,): (n, 3).

    `times` (n,) are tau of the steps, by default their lengths.
    """
    if options.formulation == "index-3" or options.quasi_static:
        scheme = scheme_of(options)
        return np.outer(1 / (lengths**2 * scheme.beta * scheme.new), [0.0, 0.0, 1.0])
    if options.formulation == "ggl":
        scheme = scheme_of(options)
        return np.outer(1 / (lengths * scheme.gamma * scheme.new), [0.0, 1.0, 0.0])
    given, tau = options.baumgarte, lengths if times is None else times
    damping = 1 / tau if given.damping is None else np.full_like(lengths, given.damping)
    stiffness = np.sqrt(2) / tau if given.stiffness is None else np.full_like(lengths, given.stiffness)
    return np.stack([np.ones_like(lengths), 2 * damping, stiffness**2], axis=1)


def start_levels(options: RunOptions, lengths: np.ndarray) -> np.ndarray:
    """Levels (3,) of the constraints at which the accelerations of the start are found."""
    return constraint_levels(options.model_copy(update={"formulation": "index-1", "quasi_static": False}), lengths[:1])[0]
