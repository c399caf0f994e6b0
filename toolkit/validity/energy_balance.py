"""Energy balance of a finished run: what the loads put in against what is there, and how far its joints are from closed."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from toolkit.components.bodies.kernels.constant_kernel import LEFT_OUT, add_drag, moving_residual
from toolkit.components.joints.kernels.all_joints import evaluate_any_joint
from toolkit.components.joints.kernels.composition import gap
from toolkit.components.joints.kernels.planar_pin import pin_rows
from toolkit.components.joints.kernels.records import CURVE, FIRST_ROW, N_ROWS, PHI, PINNED
from toolkit.components.markers.poses import set_frames, update_positions
from toolkit.foundation.kernel import inlined, kernel
from toolkit.foundation.near_ties import TIE_BAND, spread
from toolkit.responses.balance import power_of_load
from toolkit.system.equations import Inputs, Plan, allocate_terms, allocate_work
from toolkit.system.quantities import named_loads
from toolkit.system.solution import Solution

ONES = (1.0, 1.0, 1.0, 1.0)


class EnergyBalance(NamedTuple):
    """Kinetic and strain energy T, U at all times, and the work W of loads, drivers and dampers since the start, each (n_t,)."""

    kinetic: np.ndarray
    strain: np.ndarray
    work: np.ndarray
    damped: np.ndarray  # power v . D v that the damping of flexible bodies takes

    @property
    def defect(self) -> np.ndarray:
        """T + U - W minus its value at the start: what the scheme created (or lost, negative), (n_t,)."""
        total = self.kinetic + self.strain - self.work
        return total - total[0]

    @property
    def relative_defect(self) -> float:
        """Largest defect over the largest energy or work; 0 if nothing ever moves."""
        largest = max(np.abs(part).max() for part in (self.kinetic + self.strain, self.work))
        return float(np.abs(self.defect).max() / largest) if largest > 0 else 0.0


@kernel
def powers(evaluator, plan, functions, curves, curves_x, levels, inertia, q, v, lam, out, acc, terms, work):
    """T, P = - v . A - v . phi_q^T lam, q . K q / 2 and v . D v at all times: out (n_t, 4).

    K and D are those of flexible bodies, D with what follows their mass. A is the applied group of the residual without K q, of bodies that
    feel no velocities but by dampers: what their velocities add, v . (M' v / 2 - f_v), is zero for every mass matrix M. `work` has the
    care that leaves the constant part to be summed up here, and at the acceleration v the inertial group is M v.
    """
    n_q, constant, plane, frames = plan.n_q, plan.constant, plan.markers.plane, plan.markers.frames
    for n in range(len(q)):
        for i in range(plan.n):
            acc[i] = lam[n, i]
        inputs = Inputs(curves[n], curves_x[n], 1.0, levels, False, False)
        evaluator(plan, functions, inputs, q[n], v[n], acc, False, False, terms, work)
        for i in range(n_q):
            out[n, 1] -= v[n, i] * (terms.applied[i] + terms.inertial[i])
        for i in range(len(constant.force)):
            out[n, 1] += v[n, i] * constant.force[i]
        for e in range(len(constant.row)):
            i, j = constant.row[e], constant.column[e]
            out[n, 2] += q[n, i] * constant.stiffness[e] * q[n, j] / 2
            out[n, 3] += v[n, i] * constant.damping[e] * v[n, j]
            if inertia:
                out[n, 0] += v[n, i] * constant.mass[e] * v[n, j] / 2
        out[n, 1] -= out[n, 3]
        if inertia and len(plan.floating.frame) > 0:
            terms.inertial[:] = 0
            set_frames(frames, work.markers, q[n], v[n], v[n])
            moving_residual(
                plane, frames, plan.floating, work.markers, q[n], v[n], v[n], 1.0, work.floating, terms.inertial, terms.applied
            )
            for i in range(n_q):
                out[n, 0] += v[n, i] * terms.inertial[i] / 2
        if len(plan.drag.frame) > 0:
            for i in range(plan.n):
                acc[i] = 0
            still = work.rest
            add_drag(
                plan.markers.plane, plan.markers.frames, plan.drag, work.markers, q[n], v[n], still, False, ONES, False,
                work.drag, acc, terms.A_q, terms.A_v,
            )  # fmt: skip
            for i in range(n_q):
                out[n, 3] += v[n, i] * acc[i]


def _driven(plan: Plan) -> np.ndarray:
    """Which unknowns are multipliers of drivers, (n,)."""
    found = np.zeros(plan.n, bool)
    driven = plan.joints.curve >= 0
    found[(plan.joints.row + plan.joints.n_rows - 1)[driven]] = True
    return found


def energy_balance(solution: Solution) -> EnergyBalance:
    """Energies and work of a transient solution; the work is integrated by the trapezoidal rule, so its error is of second order.

    Dampers count as loads that take energy out, gravity as a load, not as a potential.
    """
    return _summed(solution.times, _powers(solution))


def energy_balances(solution: Solution) -> tuple[EnergyBalance, EnergyBalance]:
    """The same, and that of every second state alone."""
    found = _powers(solution)
    if _has_inertia(solution):
        return _summed(solution.times, found), _summed(solution.times[::2], found[::2])
    states = ("times", "q", "v", "a", "multipliers")  # from which other velocities follow
    every_second = replace(solution, **{name: getattr(solution, name)[::2] for name in states})
    return _summed(solution.times, found), energy_balance(every_second)


def _has_inertia(solution: Solution) -> bool:
    return not (solution.options or solution.system.scene.solver).quasi_static


def _powers(solution: Solution) -> np.ndarray:
    """What `powers` finds, (n_t, 4)."""
    system, plan, n_t, inertia = solution.system, solution.system.plan, len(solution.times), _has_inertia(solution)
    work = allocate_work(plan, system.dtype)
    work.care[0] = LEFT_OUT
    # without inertia velocities are those of the middle of a step, which would cost an order of the work
    velocity = solution.v if inertia else np.gradient(solution.q, solution.times, axis=0, edge_order=2 if n_t > 2 else 1)
    states: np.ndarray = np.zeros((3, n_t, system.n), system.dtype)
    q, v, lam = states
    q[:, : system.n_q], v[:, : system.n_q], lam[:, system.n_q :] = solution.q, velocity, solution.multipliers
    v[:, system.numbering.states] = 0  # integrals, which do no work
    lam[:, ~_driven(plan)] = 0  # other joints do no work: what they do while they drift is the scheme's doing
    out: np.ndarray = np.zeros((n_t, 4), system.dtype)
    curves, curves_x = system.curves(solution.times)
    system.run(
        powers, system.evaluator, system.driven, system.functions, curves, curves_x, np.zeros(3), inertia, q, v, lam,
        out, np.zeros(system.n, system.dtype), allocate_terms(plan, system.dtype), work,
    )  # fmt: skip
    return out


def _summed(times: np.ndarray, found: np.ndarray) -> EnergyBalance:
    """Energies and work from energies and powers (n_t, 4)."""
    kinetic, power, strain, damped = found.T
    gained = np.diff(times) * (power[1:] + power[:-1]) / 2
    return EnergyBalance(kinetic, strain, np.append(0, np.cumsum(gained)), damped)


def created_energy(solution: Solution) -> float:
    """Largest energy that nothing accounts for, over the largest energy or work; infinite where it is no number.

        max over time of  E - E_start - |E_2 - E|,   E = T + U - W - integral of v . D v

    The damping D of flexible bodies can only take energy, so what it took is left out: of stiff damping that no step resolves, the sum
    over the steps is wrong by far more than there is. E_2 is summed over every second state alone: what the sum of the work is wrong by
    was not created.
    """
    return energy_defects(solution)[0]


SUMMED_INSTANTS = 200
"""Instants, evenly spread over the motion, from which works are summed whose size alone counts."""
DEFECT_WITH_LOSSES = 0.01
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
    if max(created, lost) > DEFECT_WITH_LOSSES * largest:
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
    steps = np.array(spread(len(solution.times) - 1, SUMMED_INSTANTS))
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


@inlined
def find_rows(plane, frames, functions, joints, j, markers, state, rest, work):
    """Rows of one joint, in `work.row[PHI]`."""
    if plane is not None and joints.of[j, PINNED]:
        pin_rows(joints, j, state, work.row[PHI])
        return
    evaluate_any_joint(plane, frames, functions, joints, j, markers, state, rest, work)


@kernel
def largest_drift(plan, functions, curves, weights, q, rest, found, work):
    """Largest weighted |phi| over all times and rows, (value, time index, unknown, value there) in `found` (4,); `rest` is zero,
    (n,).

    The place is the first one where it is the largest but for a part `TIE_BAND` of it, see `near_ties`.
    """
    plane, frames = plan.markers.plane, plan.markers.frames
    for n in range(len(q)):
        update_positions(plane, frames, plan.markers, work.markers, q[n], rest)
        for j in range(len(plan.joints.of)):
            find_rows(plane, frames, functions[0], plan.joints, j, plan.markers, work.markers, rest, work.joint)
            rows = plan.joints.of[j, N_ROWS]
            for i in range(rows):
                target = 0.0
                if plan.joints.of[j, CURVE] >= 0 and i == rows - 1:
                    target = curves[n, plan.joints.of[j, CURVE], 0]
                value = gap(plan.joints, j, i, work.joint.row[PHI, i], target)
                row = plan.joints.of[j, FIRST_ROW] + i
                violation = weights[row] * abs(value.real)
                if not violation <= found[0] and not np.isnan(found[0]):
                    found[0] = violation
                if not violation <= (1 + TIE_BAND) * found[3] and not np.isnan(found[3]):
                    found[1], found[2], found[3] = n, row, violation
