"""Cautions about how exactly a motion was integrated: its energy, its steps, what Newton left over."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from toolkit.description.run_options import RunOptions
from toolkit.foundation.verdict import MOTION, STATES, Caution, check
from toolkit.system.solution import Solution
from toolkit.validity.motion.created_energy import energy_defects
from toolkit.validity.motion.noisy_forces import force_noise, noisy_forces

ENERGY, SUSPICIOUS = 0.04, 0.01
"""Part of the largest energy or work that may be gained or lost, and from which on steps are looked at more closely: of a motion
that rings it may be the whole vibration, of one that follows its loads nothing that matters."""
COARSE = 1e-3
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

    Limit: 4 % of the largest energy or work; a remark where steps half as long show that it goes away and values are right.
    Fix: a smaller `solver.step`.
    """
    balance = measured(solution)["energy_balance"]
    for name, what in (("created", "gained"), ("lost", "lost")):
        if not balance.get(name, 0.0) <= ENERGY:
            better = ', or solver.scheme = "arnold-bruels"' * (_options(solution).scheme == "paper")
            yield unbalanced_energy.caution(
                f"energy balance: {balance[name]:.1%} of the largest energy or work is {what} (limit {ENERGY:.0%}). No load, driver or "
                f"damper accounts for it: it is an error of the time integration. Fix: a smaller solver.step{better}.",
            )


def measured(solution: Solution) -> dict[str, Any]:
    """What the states of a motion tell about how exactly they were found.

    Returns
    -------
    measures : dict
        "drift" and "newton_correction" as `Solution` has them; "energy_balance" with "created" and "lost", parts of the largest energy or
        work, and "force_noise" of `noisy_forces`, both empty where the states are not kept; "estimated_error" with "local", the largest
        error of one step.
    """
    if measured in solution.known:
        found: dict[str, Any] = solution.known[measured]
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
    if error is not None and not error <= COARSE:
        yield coarse_steps.caution(
            f"steps are coarse for this motion: the largest estimated error of one is {error:.1e} of the model size (limit {COARSE:g}). "
            f"Peaks and vibrations may be wrong. Fix: a smaller solver.step, or solver.local_error = {COARSE / 10:g} with "
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
            doubt=not solution.correction <= COARSE,
        )


@check("noisy-forces", (MOTION,), by_result=True)
def noisy_states(solution: Solution) -> Iterator[Caution]:
    """Noise in joint forces of a motion, whatever is asked for."""
    yield from noisy_forces(_options(solution), measured(solution)["force_noise"])
