"""Energy that a run creates or loses: what no load put in or took out, and no round-off explains."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from toolkit.compilation.quantities import named_loads
from toolkit.foundation.near_ties import spread
from toolkit.responses.balance import power_of_load
from toolkit.system.solution import Solution
from toolkit.validity.motion.energy_balance import EnergyBalance, energy_balance, energy_balances


def created_energy(solution: Solution) -> float:
    """Largest energy that nothing accounts for, over the largest energy or work; infinite where it is no number.

        max over time of  E - E_start - |E_2 - E|,   E = T + U - W - integral of v . D v

    The damping D of flexible bodies can only take energy, so what it took is left out: of stiff damping that no step resolves, the sum
    over the steps is wrong by far more than there is. E_2 is summed over every second state alone: what the sum of the work is wrong by
    was not created.
    """
    return energy_defects(solution)[0]


LOOKED_AT = 200
"""Instants, evenly spread over the motion, from which works are summed whose size alone counts."""
LOOKED_AT_AGAIN = 0.01
"""Part of the largest energy or work from which on a defect is compared with what friction and dampers took, too."""
ROUND_OFF = 1e-12
"""Part of `held_energy` that is no energy of a motion: positions are exact to 1e-16 of the model size, over some thousand steps."""


def energy_defects(solution: Solution) -> tuple[float, float]:
    """Energy that was created, see `created_energy`, and energy that vanished, both over the largest energy or work.

        lost = max over time of  E_start - E - |E_2 - E|,   E = T + U - W   with what damping took in W

    A single step says nothing: both are zero.
    """
    if solution.steps < 2:
        return 0.0, 0.0
    balance, coarse = energy_balances(solution)
    parts = (balance.kinetic + balance.strain, balance.work)
    sizes = (unresolved_energy(solution), ROUND_OFF * held_energy(solution), largest_work(solution))
    largest = max(*sizes, *(np.abs(part).max() for part in parts))
    created = _beyond(_surplus(solution.times, balance), _surplus(solution.times[::2], coarse))
    lost = _beyond(-balance.defect, -coarse.defect)
    if max(created, lost) > LOOKED_AT_AGAIN * largest:
        largest = max(largest, taken_by_loads(solution, balance))
    return _part(created, largest), _part(lost, largest)


def _beyond(defect: np.ndarray, coarse: np.ndarray) -> float:
    """Largest defect (n_t,) that its sum over every second state (n_t // 2 + 1,) confirms."""
    return float((defect[::2] - np.abs(coarse - defect[::2])).max())


def _part(energy: float, largest: float) -> float:
    relative = energy / largest if largest != 0 else 0.0
    return relative if np.isfinite(relative) else np.inf


def _surplus(times: np.ndarray, balance: EnergyBalance) -> np.ndarray:
    """E minus its start, (n_t,)."""
    taken = balance.damped
    return balance.defect - np.append(0, np.cumsum(np.diff(times) * (taken[1:] + taken[:-1]) / 2))


def held_energy(solution: Solution) -> float:
    """Largest force of a joint times the model size, or moment times 1 rad: round-off of positions works against it where all rests."""
    weights = solution.system.weights[solution.system.n_q :]
    return float((np.abs(np.real(solution.multipliers)) / weights).max(initial=0.0))


def taken_by_loads(solution: Solution, balance: EnergyBalance) -> float:
    """Largest energy that friction, dampers and other loads that oppose rates took or gave since the start; what bodies damp is left out.

    Where a weight sinks against friction, both works cancel but for a little: a part of these works is what an error has to be compared
    with, as energy that is taken is forgotten. Their power is the part of all that stays when rates change sign,

        P_d = (P(q, v) + P(q, -v)) / 2
    """
    back = energy_balance(replace(solution, v=-solution.v))
    bodies = np.append(0, np.cumsum(np.diff(solution.times) * (balance.damped[1:] + balance.damped[:-1]) / 2))
    return float(np.abs(np.real((balance.work + back.work) / 2 + bodies)).max())


def largest_work(solution: Solution) -> float:
    """What the busiest load has turned over in a run without inertia: there the works of all loads cancel but for what bodies store.

    Zero with inertia, where the sum of the works is a size itself.
    """
    scene = solution.system.scene
    if not (solution.options or scene.solver).quasi_static:
        return 0.0
    steps = np.array(spread(len(solution.times) - 1, LOOKED_AT))
    lengths, largest = np.diff(solution.times[steps]), 0.0
    for name in named_loads(scene):
        look = power_of_load(solution, name)
        each = np.abs([float(np.real(look(int(step)).value)) for step in steps])
        largest = max(largest, float(lengths @ (each[1:] + each[:-1]) / 2))
    return largest


def unresolved_energy(solution: Solution) -> float:
    """Energy of what Newton leaves open, at the start: sum_i (M_ii v_i^2 + |K_ii| q_i^2) / 2.

    q_i is the coordinate's part of `solver.tolerance`, v_i = q_i / h. Less than this is round-off: a scene at rest creates some.
    """
    system, n_q = solution.system, solution.system.n_q
    pad = np.zeros(system.n - n_q)
    q, v = np.append(solution.q[0], pad), np.append(solution.v[0], pad)
    acc = np.append(solution.a[0], solution.multipliers[0])
    terms = system.evaluate(system.inputs(solution.times[0], np.array([0, 0, 1.0])), q, v, acc)
    open_q = system.scene.solver.tolerance / system.weights[:n_q]
    open_v = open_q / (solution.times[1] - solution.times[0])
    mass, stiffness = (np.abs(system.diagonal(each)[:n_q]) for each in (terms.I_acc, terms.A_q))
    return float(np.real(mass @ open_v**2 + stiffness @ open_q**2) / 2)
