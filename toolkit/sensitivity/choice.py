"""Which exact method is cheaper, by a model of what both cost per time step beside the run itself.

    direct:   evaluation of the design partials, and per variable a solve and products with the derivatives by the state
    adjoint:  the linearised equations again and their factors, evaluation of the design partials, and per response a transposed solve

The work is counted from the compiled scene. Its price was measured on a wing and chains of 10 to 1000 unknowns, with 1 to 600 variables and
1 to 20 responses, in time of the processor, where the choice was the better method or at most a tenth slower. `python -m
tests.benchmarks.method_choice` measures it again; on another machine all prices change together, so that the choice stays.
"""

from __future__ import annotations

import numpy as np

from toolkit.description.time_grid import time_grid
from toolkit.foundation.itself import Itself
from toolkit.foundation.memory_sizes import GIGABYTE, in_gigabytes
from toolkit.scene.scene import Scene
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.preparation import Kind, responses_of
from toolkit.system.system import System

DIRECT = np.array([2.1, 0.12, 0.00054, 0.00014])
"""Price in us of the parts of `direct_work`."""
ADJOINT = np.array([2.3, 0.137, 0.0094, 0.0011])
"""Price in us of the parts of `adjoint_work`."""


def choose(compiled: Compiled, kind: Kind, keep_states: bool = False) -> tuple[str, str]:
    """The cheaper exact method for a run, or the only one that can do it, and the sentence that says why.

    Parameters
    ----------
    keep_states : bool
        Whether derivatives of the states are wanted too, which only direct differentiation has.
    """
    if keep_states:
        return "direct", "direct differentiation, because derivatives of the states are to be kept, which the adjoint has not."
    if kind == "static":
        return "direct", "direct differentiation, because an equilibrium costs one more solve by either method."
    scene, system = compiled.scene, compiled.full
    key = (
        "method",
        Itself(scene.solver),
        Itself(scene.responses),
        system.n,
        system.n_x,
        _entries(system),
        len(system.plan.touched_row),
    )
    if key not in compiled.decided:
        compiled.decided[key] = _chosen(compiled, scene, system)
    found: tuple[str, str] = compiled.decided[key]
    return found


def _chosen(compiled: Compiled, scene: Scene, system: System) -> tuple[str, str]:
    """The cheaper exact method for a motion whose derivatives of the states need not be kept."""
    needed = 8 * len(time_grid(scene.solver)) * (3 * system.n + system.n_x * (2 * system.n_q + system.n))
    if scene.solver.local_error is None and needed > GIGABYTE * scene.solver.memory:
        return "adjoint", f"the adjoint, because derivatives of all states would take {in_gigabytes(needed)}."
    n_r = len(responses_of(scene))
    by_direct, by_adjoint = direct_work(system, n_r) @ DIRECT, adjoint_work(system, n_r) @ ADJOINT
    method, name = ("adjoint", "the adjoint") if by_adjoint < by_direct else ("direct", "direct differentiation")
    part = min(by_direct, by_adjoint) / max(by_direct, by_adjoint)
    counts = f"{counted(len(compiled.names), 'design variable')} and {counted(n_r, 'response')}"
    return method, f"{name}, estimated at {100 * part:.0f} % of the other exact method's price for {counts}."


def counted(number: int, word: str) -> str:
    """A number and a word in its singular or plural."""
    return f"{number} {word}{'s' * (number != 1)}"


def direct_work(system: System, n_r: int) -> np.ndarray:
    """Work of a step of direct differentiation: unknowns, equations per variable, and unknowns per variable and response."""
    return np.array([1, system.n, system.n_x * _entries(system), n_r * system.n_x * system.n])


def adjoint_work(system: System, n_r: int) -> np.ndarray:
    """Work of a step of the adjoint: unknowns, design partials, and equations per response."""
    return np.array([1, system.n, len(system.plan.touched_row), n_r * _entries(system)])


def _entries(system: System) -> int:
    """Number of entries of the equations' sparsity pattern and of their factors."""
    return len(system.plan.indices) + int(system.lu_plan.row_start[-1])
