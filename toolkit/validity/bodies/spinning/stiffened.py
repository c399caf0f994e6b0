"""How much more the elements of a body that its spin stiffens would move without that under the same forces."""

from __future__ import annotations

import numpy as np

from toolkit.reduced_model.parts import stiffness_of_spin
from toolkit.system.flexible_bodies import elastic_coordinates, flexible_body, spins_of
from toolkit.system.solution import Solution
from toolkit.validity.bodies.static_deflection import static_deflection


def kept_back(solution: Solution, body: str, instants: np.ndarray) -> np.ndarray | None:
    """K^-1 S(omega) q (n_t, n_f) at some instants of a run; None of a body that does not ask for its stiffening.

    Forces on the body are (K + S) q. Elements that turn find the part S q by themselves.
    """
    scene = solution.system.scene
    found = flexible_body(scene, body)
    stiffening = found.stiffening(scene)
    if stiffening is None:
        return None
    spins = spins_of(solution, body, instants)
    elastic = np.real(solution.q[instants][:, elastic_coordinates(solution, body)])
    forces = [stiffness_of_spin(np.real(stiffening), spin) @ q for spin, q in zip(spins, elastic, strict=True)]
    stiffness = np.real(found.invariants(scene).stiffness)
    return static_deflection(stiffness, np.array(forces).T).T
