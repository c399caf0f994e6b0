"""Check of the joints of a run: whether they have come apart, and why."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.errors import ConvergenceError
from toolkit.solvers.transient.run import Integration, at_limit_position
from toolkit.system.system import System
from toolkit.validity.motion.drift import largest_drift

UNSTABILISED = "nothing pulls them back. Leave out solver.baumgarte, or give it a positive stiffness"

THROWN_OPEN = 0.05
"""Violation of a joint, a part of the model size (or rad), that is no error of long steps: Newton has found another solution there."""


def can_be_closed(run: Integration) -> bool:
    """Whether joints that have come apart are a matter of the steps alone: positions are stabilised, and no joint was left out."""
    options = run.options
    return options.formulation == "index-1" and options.baumgarte.stiffness != 0 and len(run.system.plan.dropped) == 0


def drift(system: System, times: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Largest violation of any joint in states (n_t, n), and where it is, as `largest_drift` finds it."""
    found = np.zeros(4)
    system.run(
        largest_drift, system.plan, system.functions, system.curve_values(times), system.weights, q,
        np.zeros(system.n, system.dtype), found, system.work,
    )  # fmt: skip
    return found


def first_opened(run: Integration, q: np.ndarray, allowed: float) -> int | None:
    """First step to a state (n_t, n) in which joints are open by more than is allowed; None without any."""
    if not can_be_closed(run) or drift(run.system, run.times, q)[0] <= allowed:
        return None
    ends = (k for k in range(1, len(q)) if not drift(run.system, run.times[k : k + 1], q[k : k + 1])[0] <= allowed)
    return next(ends, 1) - 1


def check_drift(run: Integration, q: np.ndarray, first: int) -> float:
    """Largest violation of any joint in states (n, ...) from step `first` on, relative to the model size or in rad.

    Raises
    ------
    ConvergenceError
        The joints came apart, also those left out as redundant; names joint, time and remedy.
    """
    system, options, times = run.system, run.options, run.times[first : first + len(q)]
    found = drift(system, times, q)
    if not found[0] <= options.drift_tolerance and found[2] in system.plan.dropped:
        raise ConvergenceError(
            f"{system.numbering.names[int(found[2])]} was left out because other joints imply it at the start; it is off by {found[0]:.1e} "
            f"of the model size at t = {times[int(found[1])]:g}: they do so in the start position alone (a folded or stretched one), or "
            "points and axes do not fit exactly. Start elsewhere, fix them, or remove the joint that is too much."
        )
    if not found[0] <= options.drift_tolerance:
        stabilised = options.baumgarte.stiffness != 0
        cause = (
            f"the step of {run.lengths.max():g} is far too large for this motion. Try a tenth of it"
            if stabilised
            else UNSTABILISED
        )
        came_apart = ConvergenceError(
            f"the joints came apart: {system.numbering.names[int(found[2])]} is off by {found[0]:.1e} of the model size at "
            f"t = {times[int(found[1])]:g}, more than solver.drift_tolerance = {options.drift_tolerance:g}: {cause}."
        )
        raise at_limit_position(run, q[0], float(times[0]), float(times[int(found[1])] - times[0]) / 10, came_apart)
    return float(found[0])
