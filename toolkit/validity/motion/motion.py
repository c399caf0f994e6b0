"""Cautions about how exactly a motion was integrated: its energy, its steps, what Newton left over."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from toolkit.description.run_options import RunOptions
from toolkit.foundation.verdict import Caution
from toolkit.system.solution import Solution
from toolkit.validity.motion.created_energy import energy_defects
from toolkit.validity.motion.noisy_forces import force_noise

ENERGY, SUSPICIOUS = 0.04, 0.01
"""Part of the largest energy or work that may be gained or lost, and from which on steps are looked at more closely: of a motion
that rings it may be the whole vibration, of one that follows its loads nothing that matters."""
COARSE = 1e-3
"""Local error of a step, a part of the scene's size (or rad), above which steps are coarse."""


def unbalanced_energy(solution: Solution, balance: Mapping[str, float]) -> Iterator[Caution]:
    """Energy that the scheme created, or took out where nothing damps; the balance as `measured` gives it."""
    if not balance:
        yield Caution(
            "energy-not-checked",
            f"the energy balance was not checked: of {solution.steps} steps only {len(solution.times)} states are kept, because all exceed "
            "solver.memory.",
            doubt=False,
        )
    for name, what in (("created", "gained"), ("lost", "lost")):
        if not balance.get(name, 0.0) <= ENERGY:
            better = ', or solver.scheme = "arnold-bruels"' * (_options(solution).scheme == "paper")
            yield Caution(
                "energy",
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
    created, lost = (0.0, 0.0) if solution.run_times is not None else energy_defects(solution)
    return {
        "drift": solution.drift,
        "newton_correction": solution.correction,
        "energy_balance": {} if solution.run_times is not None else {"created": created, "lost": lost},
        "force_noise": {} if solution.run_times is not None else force_noise(solution),
        "estimated_error": {} if solution.local_error is None else {"local": solution.local_error},
    }


def _options(solution: Solution) -> RunOptions:
    return solution.options or solution.system.scene.solver


def coarse_steps(solution: Solution) -> Iterator[Caution]:
    """Steps that leave the motion unresolved, by the largest error that one of them is estimated to make."""
    error = solution.local_error
    if error is not None and not error <= COARSE:
        yield Caution(
            "coarse-steps",
            f"steps are coarse for this motion: one of them is estimated to be off by {error:.1e} of the scene's size (limit {COARSE:g}), "
            "so that peaks and vibrations may be wrong. Try a smaller solver.step, or let the run choose: "
            f'solver.local_error = {COARSE / 10:g} with solver.scheme = "arnold-bruels".',
        )


def left_over(solution: Solution) -> Iterator[Caution]:
    """A Newton iteration that round-off kept from its tolerance."""
    allowed = _options(solution).tolerance
    if not solution.correction <= allowed:
        yield Caution(
            "newton",
            f"Newton was content with a correction of {solution.correction:.1e}: round-off kept it above solver.tolerance = {allowed:.1e}.",
            doubt=not solution.correction <= COARSE,
        )
