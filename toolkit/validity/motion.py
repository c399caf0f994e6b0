"""Cautions about how exactly a motion was integrated: its energy, its steps, what Newton left over, and noisy joint forces."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple, TypedDict

import numpy as np

from toolkit.description.description import Registered
from toolkit.description.run_options import RunOptions
from toolkit.foundation.value_types import Record
from toolkit.foundation.verdict import MOTION, STATES, Caution, check
from toolkit.responses.balance import Power
from toolkit.responses.extremes import TimeKS, TimeMax, TimeMin
from toolkit.responses.joint_force import JointForce
from toolkit.responses.over_time import OverTime
from toolkit.system.solution import Solution
from toolkit.validity.energy_balance import energy_defects

FORCE_NOISE_LIMIT = 0.03
"""Noise of a joint's force, a part of its largest one, above which forces are not to be trusted."""
LEAST_FORCE_PART = 1e-3
"""Part of the largest force in the scene that a joint's largest force counts as, at least."""
STATES_ON_BOTH_SIDES = 6
"""Number of states on both sides of the one that is asked for in which a force may alternate."""
ALTERNATING_STATES = 4
"""Number of states in a row that have to alternate: a load that jumps does it twice."""


class JointNoise(NamedTuple):
    """Noise of a joint's force, (n_t - 5, rows), as a part of its largest; and its first multiplier among all unknowns."""

    noise: np.ndarray
    row: int


class ForceNoise(TypedDict, total=False):
    """Noise of the joint that has most, a part of its largest force, and where and when it has it; empty without joints."""

    size: float
    where: str
    time: float


class Measures(TypedDict, total=False):
    """What is measured to judge a solution: how exactly its states were found, and what its model leaves out."""

    drift: float
    newton_correction: float
    energy_balance: dict[str, float]
    force_noise: ForceNoise
    estimated_error: Record
    frames: Record
    left_out_shapes: Record


def force_noise(solution: Solution) -> ForceNoise:
    """Amplitude of joint forces at the shortest wave that steps can hold, of two steps.

        d_n = lam_n - (h_+ lam_(n-1) + h_- lam_(n+1)) / (h_- + h_+),   amplitude = min |d_n| / 2 of four neighbours with alternating signs

    Index 3 makes it where bodies turn too far in a step (see `option_checks.DAMPED`), and round-off in tiny steps; a vibration
    that steps do not resolve looks the same.

    Parameters
    ----------
    solution : Solution
        Result of `simulate`, with all its states.

    Returns
    -------
    noise : dict
        "size", a part of the largest force of the same joint, "where", the direction and the joint, and "time"; empty without joints.
    """
    joints = noise_of_joints(solution)
    if not joints:
        return {}
    name = max(joints, key=lambda each: float(joints[each].noise.max()))
    noise, row = joints[name]
    step, column = np.unravel_index(int(np.argmax(noise)), noise.shape)
    where, time = solution.system.numbering.names[row + int(column)], float(solution.times[step + 1])
    return {"size": float(noise[step, column]), "where": where, "time": time}


def noise_of_joints(solution: Solution) -> dict[str, JointNoise]:
    """Noise of every joint's force by name; empty for a run of fewer than six states."""
    system, first = solution.system, solution.system.n_q
    rows = {
        name: slice(row - first, row - first + len(system.scene.joints[name].row_names))
        for name, row in system.numbering.row.items()
    }
    if not rows or len(solution.times) < ALTERNATING_STATES + 2:
        return {}
    forces = solution.multipliers / system.weights[first:]
    largest, amplitudes = np.abs(forces).max(axis=0), _amplitudes(forces, np.diff(solution.times))
    sizes = {name: float(largest[each].max()) for name, each in rows.items()}
    own = {name: max(size, LEAST_FORCE_PART * max(sizes.values())) or np.inf for name, size in sizes.items()}
    return {name: JointNoise(amplitudes[:, each] / own[name], first + each.start) for name, each in rows.items()}


def noise_at(joint: JointNoise, step: int) -> float:
    """Noise of a joint's force in the neighbourhood of one state."""
    last = min(step, len(joint.noise) - 1)
    return float(joint.noise[max(min(step - ALTERNATING_STATES, last), 0) : last + 1].max())


def noise_of_values(values: np.ndarray, times: np.ndarray, size: float) -> float:
    """Noise of a number made of joint forces, (n_t,), at states in a row, relative to a size.

    Of a magnitude it is less than of the components that jump across it.
    """
    if len(times) < ALTERNATING_STATES + 2 or not size > 0:
        return np.inf
    return float(_amplitudes(values[:, None], np.diff(times)).max()) / size


def _amplitudes(force: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Amplitude from each inner state and the next three, (n_t - 5, rows), of forces (n_t, rows) after steps (n_t - 1,)."""
    before, after = lengths[:-1, None], lengths[1:, None]
    off = force[1:-1] - (after * force[:-2] + before * force[2:]) / (before + after)
    signs = np.where(np.arange(len(off)) % 2, -1.0, 1.0)[:, None]
    four = [(signs * off)[k : len(off) - ALTERNATING_STATES + 1 + k] for k in range(ALTERNATING_STATES)]
    least, largest = four[0], four[0]
    for each in four[1:]:
        least, largest = np.minimum(least, each), np.maximum(largest, each)
    return np.maximum(least, -largest).clip(min=0) / 2


@check("noisy-forces")
def noisy_forces(
    options: RunOptions, noise: ForceNoise, asked: Sequence[str] | None = None, quiet: Sequence[str] = ()
) -> Iterator[Caution]:
    """Forces of joints jump from step to step.

    Limit: 3 % of the joint's largest force.
    Fix: a smaller `solver.step` or `solver.rho_inf`, or `solver.formulation = "ggl"`.

    A caution about joint forces that alternate; the noise as `force_noise` gives it.

    A doubt, unless nothing that was asked for is one of them: `asked` names the responses that are, and `quiet` those that are
    such forces too, but at another time, or means. Without `asked` all states are asked for.
    """
    if not noise or noise["size"] <= FORCE_NOISE_LIMIT:
        return
    whose = (
        ""
        if asked is None
        else f", {', '.join(asked)} among them"
        if asked
        else f"; {', '.join(quiet)} feel less than {FORCE_NOISE_LIMIT:.0%} of it, at other times, as means, or along what does not jump"
        if quiet
        else "; no response that was asked for is one of them"
    )
    yield noisy_forces.caution(
        f"joint forces jump from step to step{whose}: {noise['where']} by {noise['size']:.1%} of that joint's largest force at t = "
        f"{noise['time']:g} (limit {FORCE_NOISE_LIMIT:.0%}). Fix: a smaller solver.step, a smaller solver.rho_inf (now "
        f"{options.rho_inf:g}), or "
        'solver.formulation = "ggl".',
        doubt=asked is None or bool(asked),
    )


def force_cautions(solution: Solution, noise: ForceNoise, sizes: Mapping[str, float]) -> Iterator[Caution]:
    """Cautions about noisy joint forces: a doubt where a response is such a force at its time, otherwise a remark.

    The noise is that of `force_noise`, sizes are the largest that responses are.
    """
    scene = solution.system.scene
    if not noise or noise["size"] <= FORCE_NOISE_LIMIT:
        return
    joints = noise_of_joints(solution)
    noisy = [
        name
        for name, each in scene.responses.items()
        if _noise_in(each, joints, solution, sizes.get(name, 0.0)) > FORCE_NOISE_LIMIT
    ]
    quiet = [
        name for name, each in scene.responses.items() if name not in noisy and _largest_noise(each, joints) > FORCE_NOISE_LIMIT
    ]
    yield from noisy_forces(solution.options or scene.solver, noise, noisy, quiet)


def _largest_noise(response: Registered, joints: Mapping[str, JointNoise]) -> float:
    """Noise at any time in the joint's force that a response is made of, as a part of the joint's largest force."""
    looked = response.source if isinstance(response, OverTime) else response
    joint = looked.joint if isinstance(looked, JointForce | Power) else None
    return 0.0 if joint is None else float(joints[joint].noise.max())


def _noise_in(response: Registered, joints: Mapping[str, JointNoise], solution: Solution, size: float) -> float:
    """Noise in a response that is a joint's force or a driver's power, relative to the largest.

    It is that at the response's time, or of an extreme over time at any. Means do not feel what alternates. It is a part of the
    joint's largest force, or of the largest that the response itself is, whichever is less.
    """
    extreme = isinstance(response, TimeMax | TimeMin | TimeKS)
    looked = response.source if isinstance(response, TimeMax | TimeMin | TimeKS) else response
    if not isinstance(looked, JointForce | Power) or looked.joint is None:
        return 0.0
    joint = looked.joint
    last, step = len(solution.times) - 1, 0 if extreme else looked.step(solution)
    found = float(joints[joint].noise.max()) if extreme else noise_at(joints[joint], step)
    if found <= FORCE_NOISE_LIMIT:
        return found
    states = (
        np.arange(last + 1)
        if extreme
        else np.arange(max(step - STATES_ON_BOTH_SIDES, 0), min(step + STATES_ON_BOTH_SIDES, last) + 1)
    )
    look = looked.instants(solution)
    values = np.array([float(np.real(look(int(n)).value)) for n in states])
    return min(found, noise_of_values(values, solution.times[states], size))


ENERGY_DEFECT_LIMIT, SUSPICIOUS_ENERGY_DEFECT = 0.04, 0.01
"""Part of the largest energy or work that may be gained or lost, and from which on steps are looked at more closely: of a motion
that rings it may be the whole vibration, of one that follows its loads nothing that matters."""
COARSE_LOCAL_ERROR = 1e-3
"""Local error of a step, a part of the model size (or rad), above which steps are coarse."""


@check("energy-not-checked", (MOTION,))
def unchecked_energy(solution: Solution) -> Iterator[Caution]:
    """The energy balance was not checked, because not all states were kept.

    Limit: `solver.memory`.
    Fix: a larger `solver.memory`.
    """
    if not measured(solution)["energy_balance"]:
        yield unchecked_energy.caution(
            f"the energy balance was not checked: {len(solution.times)} states of {solution.steps} steps are kept, because all exceed "
            f"solver.memory. {unchecked_energy.fix}",
            doubt=False,
        )


@check("energy", (MOTION,))
def unbalanced_energy(solution: Solution) -> Iterator[Caution]:
    """Energy is gained or lost beyond what loads, drivers and dampers account for.

    Limit: 4 % of the largest energy or work, which is no error of a response; a remark where steps half as long show that it goes away
    and values are right.
    Fix: a smaller `solver.step`.
    """
    balance = measured(solution)["energy_balance"]
    for name, what in (("created", "gained"), ("lost", "lost")):
        if not balance.get(name, 0.0) <= ENERGY_DEFECT_LIMIT:
            better = ', or solver.scheme = "arnold-bruels"' * (_options(solution).scheme == "paper")
            yield unbalanced_energy.caution(
                f"energy balance: {balance[name]:.1%} of the largest energy or work is {what} (limit "
                f"{ENERGY_DEFECT_LIMIT:.0%}). No load, driver or "
                f"damper accounts for it: it is an error of the time integration. Fix: a smaller solver.step{better}.",
            )


def measured(solution: Solution) -> Measures:
    """What the states of a motion tell about how exactly they were found.

    Returns
    -------
    measures : dict
        "drift" and "newton_correction" as `Solution` has them; "energy_balance" with "created" and "lost", parts of the largest energy or
        work, and "force_noise" of `noisy_forces`, both empty where the states are not kept; "estimated_error" with "local", the largest
        error of one step.
    """
    if measured in solution.known:
        found: Measures = solution.known[measured]
        return found
    created, lost = (0.0, 0.0) if solution.run_times is not None else energy_defects(solution)
    solution.known[measured] = {
        "drift": solution.drift,
        "newton_correction": solution.correction,
        "energy_balance": {} if solution.run_times is not None else {"created": created, "lost": lost},
        "force_noise": {} if solution.run_times is not None else force_noise(solution),
        "estimated_error": {} if solution.local_error is None else {"local": solution.local_error},
    }
    return measured(solution)


def _options(solution: Solution) -> RunOptions:
    return solution.options or solution.system.scene.solver


@check("coarse-steps", (MOTION,), by_result=True)
def coarse_steps(solution: Solution) -> Iterator[Caution]:
    """Steps leave the motion unresolved, by the largest error that one of them is estimated to make.

    Limit: 1e-3 of the model size (or rad) in a step.
    Fix: a smaller `solver.step`, or `solver.local_error`.
    """
    error = solution.local_error
    if error is not None and not error <= COARSE_LOCAL_ERROR:
        yield coarse_steps.caution(
            f"steps are coarse for this motion: the largest estimated error of one is {error:.1e} of the model size (limit "
            f"{COARSE_LOCAL_ERROR:g}). Peaks and vibrations may be wrong. Fix: a smaller solver.step, or solver.local_error = "
            f"{COARSE_LOCAL_ERROR / 10:g} with "
            'solver.scheme = "arnold-bruels".',
        )


@check("newton", STATES)
def left_over(solution: Solution) -> Iterator[Caution]:
    """Round-off kept Newton's iteration from its tolerance.

    Limit: `solver.tolerance`; a doubt from 1e-3 on.
    Fix: a larger tolerance where the correction that is told is small enough.
    """
    allowed = _options(solution).tolerance
    if not solution.correction <= allowed:
        yield left_over.caution(
            f"Newton stopped at a correction of {solution.correction:.1e}: round-off kept it above solver.tolerance = {allowed:.1e}.",
            doubt=not solution.correction <= COARSE_LOCAL_ERROR,
        )


@check("noisy-forces", (MOTION,), by_result=True)
def noisy_states(solution: Solution) -> Iterator[Caution]:
    """Noise in joint forces of a motion, whatever is asked for."""
    yield from noisy_forces(_options(solution), measured(solution)["force_noise"])
