"""The state in which a run starts: consistent with the joints, or in equilibrium if there is no inertia."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from toolkit.analyses.statics import equilibrium_beside, solve_statics
from toolkit.description.run_options import RunOptions, step_lengths, time_grid
from toolkit.foundation.errors import InputError
from toolkit.foundation.itself import Itself
from toolkit.solvers.start.initial_conditions import ConsistentMotion, State, consistent_motion, moving, with_accelerations
from toolkit.solvers.start.kept_start import kept_start
from toolkit.solvers.start.start_velocities import written_velocities
from toolkit.solvers.transient.scheme import start_levels
from toolkit.system.solution import Solution
from toolkit.system.system import System


def start_at_rest(system: System, options: RunOptions) -> Solution | None:
    """The equilibrium at time 0 in which a run begins; None if it begins otherwise."""
    at_rest = options.quasi_static or (options.start == "equilibrium" and options.equilibrium != "spinning")
    return solve_statics(system, options.model_copy(update={"end_time": 0.0, "load_steps": 1})) if at_rest else None


def run_start(
    system: System,
    options: RunOptions,
    q: np.ndarray | None = None,
    v: np.ndarray | None = None,
    beside: Solution | None = None,
) -> State:
    """State at time 0; `q` and `v` (n_q,) replace the scene's own start, `beside` is that of `simulate`; raises as `run_motion`."""
    return accelerated_start(system, options, run_motion(system, options, q, v, beside))


def accelerated_start(system: System, options: RunOptions, found: ConsistentMotion | State) -> State:
    """State at time 0 with the accelerations of its steps, whose lengths are all that matters of these options."""
    return found if isinstance(found, State) else with_accelerations(system, run_levels(options), *found)


def known_start(solution: Solution) -> ConsistentMotion | State | None:
    """Start that `run_motion` has found for this motion, None if it has not; it holds for all step lengths."""
    found: ConsistentMotion | State | None = solution.known.get(ConsistentMotion)
    return found


def run_levels(options: RunOptions) -> np.ndarray:
    """Levels of the constraints in which the accelerations of a start are found."""
    return _levels(Itself(options)).copy()


@lru_cache(maxsize=8)
def _levels(same: Itself[RunOptions]) -> np.ndarray:
    """Constraint levels (3,) of the accelerations at the start, kept for the many designs that have the same options."""
    return start_levels(same.item, step_lengths(time_grid(same.item)))


def run_motion(
    system: System,
    options: RunOptions,
    q: np.ndarray | None = None,
    v: np.ndarray | None = None,
    beside: Solution | None = None,
) -> ConsistentMotion | State:
    """Coordinates and velocities at time 0, or the whole state where it is found in one; arguments as of `run_start`.

    Raises
    ------
    InputError, SingularSystemError
        As `consistent_start` and `kept_start`; or a run without inertia is given a start.
    ConvergenceError
        There is no equilibrium or steady spin at time 0, see `solve_statics`.
    """
    own = q is not None or v is not None
    if not options.quasi_static and (own or options.start == "given"):
        if options.start != "given":
            raise InputError(
                f'solver.start = "{options.start}" leaves no other start. Leave it out where the start of another run is given.'
            )
        return consistent_motion(system, q, v, 0.0, options)
    if own:
        raise InputError("solver.quasi_static starts from the equilibrium at time 0, so that no other start can be given.")
    if options.start_file is not None:
        return kept_start(system, options)
    if options.equilibrium == "spinning":
        return _spinning(system, options)
    found = start_at_rest(system, options) if beside is None else equilibrium_beside(system, beside)
    assert found is not None
    rest = _at_rest(system, found)
    if options.quasi_static:
        return rest
    motion = moving(system, rest.q, rest.dq)
    return rest if _stays(system, motion) else motion


def _stays(system: System, motion: ConsistentMotion) -> bool:
    """Whether nothing leads out of an equilibrium at once: then its accelerations are zero.

    Found from its equations they would be the round-off of elastic forces, which stiff bodies make (h omega)^2 times as large in a step.
    """
    driven = system.plan.joints.curve[system.plan.joints.curve >= 0]
    inputs = system.inputs(0.0, np.zeros(3))
    led = np.isin(system.plan.curve_index, driven)
    return not any(np.any(each) for each in (motion.v, motion.dv, inputs.curves[driven, 1:], inputs.curves_x[led, 1:]))


def _at_rest(system: System, found: Solution) -> State:
    """Coordinates and multipliers of an equilibrium, with their design derivatives."""
    free = system.n - system.n_q
    rest: np.ndarray = np.zeros(system.n, system.dtype)
    still = np.zeros((system.n, system.n_x))
    q, acc = np.append(found.q[0], rest[:free]), np.append(rest[: system.n_q], found.multipliers[0])
    dq, dacc = np.vstack([found.dq[0], still[:free]]), np.vstack([still[: system.n_q], found.dmultipliers[0]])
    return State(q, rest, acc, dq, still, dacc)


def _spinning(system: System, options: RunOptions) -> State:
    """The steady spin under the loads at time 0, with the rate that its driver has then, and its design derivatives."""
    if written := written_velocities(system):
        raise InputError(
            f"{next(iter(written.values()))} is written, but a motion that starts in a steady spin has the velocities of that spin. "
            'Leave it out, or one of solver.start = "equilibrium" and equilibrium = "spinning".'
        )
    found, free = solve_statics(system, options.model_copy(update={"end_time": 0.0})), system.n - system.n_q
    none: np.ndarray = np.zeros(free, system.dtype)
    still = np.zeros((free, system.n_x))
    q, v = (np.append(state[0], none) for state in (found.q, found.v))
    dq, dv = (np.vstack([change[0], still]) for change in (found.dq, found.dv))
    acc, dacc = np.append(found.a[0], found.multipliers[0]), np.vstack([found.da[0], found.dmultipliers[0]])
    return State(q, v, acc, dq, dv, dacc)
