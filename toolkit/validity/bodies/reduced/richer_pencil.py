"""Vibrations of a scene whose cut bodies are reduced, in so many more shapes that they are those of all coordinates.

About the state that the reduced scene has come to, every part keeps, besides its own shapes, all modes with its kept coordinates held that
are slower than `TIMES` the fastest vibration that is asked for. What is then left out makes frequencies too high by less than 3e-4
(measured), and none is missing, so that their numbers are those of all coordinates.
"""

from __future__ import annotations

import numpy as np
import scipy

from toolkit.responses.pencil import Pencil
from toolkit.responses.vibration import any_pencil_of
from toolkit.system.solution import Solution
from toolkit.validity.bodies.reduced.full_scene import full_scene_of

TIMES = 10.0
"""Frequency of the slowest shape that is left out, in parts of that of the vibration."""


def richer_pencil(solution: Solution, fastest: float) -> tuple[Pencil, np.ndarray]:
    """Stiffness with multipliers, damping and mass about the last state (n, n), and what makes its coordinates comparable (n_q,).

    Parameters
    ----------
    solution
        Of a scene in which something is reduced.
    fastest
        The fastest vibration that is asked for, in rad/time.
    """
    full = full_scene_of(solution)
    assert full is not None
    system, n_q = full.system, full.system.n_q
    shapes = full.expansion(lambda part: part.richer(TIMES * fastest))
    columns = scipy.sparse.csr_array(scipy.sparse.block_diag([shapes, scipy.sparse.eye_array(system.n - n_q)]))
    found = Pencil(*(columns.T @ np.real(each) @ columns for each in any_pencil_of(full.last_state(solution))))
    return found, np.asarray((abs(shapes) * system.weights[:n_q, None]).max(axis=0).todense()).ravel()
