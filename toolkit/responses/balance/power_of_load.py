"""Power of a load between two markers: of its forces along their rates."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from toolkit.compilation.numbering import grips_of
from toolkit.compilation.quantities import named_loads
from toolkit.loads.load import Load
from toolkit.responses.kinematics.marker_formula import one_of
from toolkit.responses.kinematics.marker_motion import MarkerMotion, Motion
from toolkit.responses.response import Partials
from toolkit.system.solution import Solution
from toolkit.system.system import System


def power_of_load(solution: Solution, name: str) -> Callable[[int], Partials]:
    """Power P = f . w of the load of that name, step by step, with its force law f(z, w) (see `load_kernel`):

        P_z = w . f_z,   P_w = f + w . f_w

    with the poses, the parameters and the value of the time curve in z.
    """
    system, loads = solution.system, solution.system.plan.loads
    load, k = named_loads(system.scene)[name], list(named_loads(system.scene)).index(name)
    motion, curve = MarkerMotion.of(system, grips_of(f"loads.{name}", load)), loads.curve[k]
    curves, curves_x = system.curves(solution.times)
    designs = slice(loads.design_start[k], loads.design_start[k + 1])
    active = (system.plan.curve_index == curve) & (curve >= 0)

    def look(step: int) -> Partials:
        a, b = motion.at(solution, step)
        size, w = len(a.y), np.concatenate([a.rate, b.rate, [0.0]])  # no work is done on a state
        own = solution.q[step, loads.state[k]] if loads.state[k] >= 0 else 0.0
        force, f_z, f_w = law_of_load(system, load, k, (a, b), own, curves[step, curve, 0] if curve >= 0 else 1.0)
        by_z, by_w = (w @ f_z)[None], (force + w @ f_w)[None]
        design = np.zeros((1, system.n_x))
        by_parameter = np.real(by_z[0, 2 * size + loads.design_parameter[designs]]) * loads.design_value[designs]
        np.add.at(design[0], loads.design_variable[designs], by_parameter)
        np.add.at(design[0], system.plan.curve_variable[active], np.real(by_z[0, -1]) * curves_x[step, active, 0])
        sides = [Motion(by_z[:, side], by_w[:, side]) for side in (slice(0, size), slice(size, 2 * size))]
        found = one_of(motion.partials(np.array([force @ w]), sides, design), 0, solution, step)
        if loads.state[k] >= 0 and found.q is not None:
            found.q[loads.state[k]] += w @ f_w[:, -1]
        return found

    return look


def law_of_load(
    system: System, load: Load, k: int, motions: tuple[Motion, Motion], own: Any, scale: Any
) -> tuple[np.ndarray, ...]:
    """Force law f (w,), f_z (w, z) and f_w (w, w) of load number k at its markers' poses and rates and its `own` state."""
    a, b = motions
    z: np.ndarray = np.concatenate([a.y, b.y, system.plan.loads.parameter[k], [scale]]).astype(system.dtype)
    w: np.ndarray = np.concatenate([a.rate, b.rate, [own]]).astype(system.dtype)
    shapes = (len(w), (len(w), len(z)), (len(w), len(w)))
    found: tuple[np.ndarray, ...] = tuple(np.zeros(shape, system.dtype) for shape in shapes)
    system.run(load.law(), z, w, *found)
    return found
