"""The first limit point of a scene, and how its load factor follows the design.

At a limit point the static matrix K has a left null vector psi. With the residual R(q, lam, factor; x) = 0 along all designs,

    psi^T (K d[q; lam] + R_factor dfactor + R_x dx) = 0,     dfactor/dx = - psi^T R_x / psi^T R_factor

so that neither the change of the state nor second derivatives are needed.
"""

from __future__ import annotations

from itertools import islice
from typing import Any

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import NoLimitPointError
from toolkit.solvers.static.acting import GrowingLoads
from toolkit.solvers.static.equilibrium import Equilibrium, inputs_at
from toolkit.solvers.static.path.continuation import bifurcation
from toolkit.solvers.static.path.corrector import first_point
from toolkit.solvers.static.path.limit_points import limit_point
from toolkit.solvers.static.path.path_equations import PathEquations
from toolkit.solvers.static.path.path_steps import arcs
from toolkit.solvers.static.stability.critical_state import soft_motion, softest_motion
from toolkit.system.system import System


def next_limit_point(system: System, options: RunOptions, begin: np.ndarray, up_to: float) -> np.ndarray:
    """First limit point z = [q; lam; factor] on the path of equilibria beyond a stable one.

    Raises
    ------
    BifurcationError
        The path loses its stability at a bifurcation before.
    NoLimitPointError
        There is no limit point below the load factor `up_to`, or in `options.path_steps` steps.
    """
    equations = PathEquations(system, options, GrowingLoads(system, options))
    factor = float(begin[-1])
    for arc in islice(arcs(equations, first_point(equations, begin), 1.0 / options.load_steps), options.path_steps):
        place = limit_point(equations, arc)
        if place is not None:
            return place.z
        if arc.branching:
            here = Equilibrium(*equations.padded(arc.begin.z), arc.begin.direction)
            raise bifurcation(system, arc.begin.factor, soft_motion(system, options, here, arc.begin.factor))
        factor = arc.end.factor
        if factor > up_to:
            break
    raise NoLimitPointError(
        f"the path of equilibria has no limit point up to {factor:.4g} times the load: nothing snaps through there. Raise `up_to` (and "
        "solver.path_steps), or leave the load margin out.",
        factor,
    )


def factor_of_limit_point(system: System, options: RunOptions, z: np.ndarray) -> tuple[Any, np.ndarray]:
    """Load factor at a limit point z (n + 1,) and its design derivatives (n_x,).

    The limit point is that of the real parts of the system's numbers.

    Of a system with a complex step the factor follows that step.
    """
    equations = PathEquations(system, options, GrowingLoads(system, options))
    residual, matrix = equations.linearised(z)
    left = softest_motion(system, matrix.T)[1]
    left = left / (left @ equations.load(z, residual))
    q, acc = equations.padded(z)
    terms = system.evaluate(inputs_at(system, options, float(z[-1])), q, np.zeros_like(q), acc, design=True)
    value = z[-1] - left @ (terms.inertial + terms.applied)
    return value, -left @ np.real(terms.I_x + terms.A_x)
