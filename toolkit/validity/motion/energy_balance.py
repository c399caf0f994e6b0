"""Energy balance of a finished run: what the loads put in, against what is there."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from toolkit.bodies.kernels.constant_kernel import LEFT_OUT
from toolkit.bodies.kernels.inertia import add_drag, moving_residual
from toolkit.equations.equations import Inputs, Plan, allocate_terms, allocate_work
from toolkit.foundation.kernel import kernel
from toolkit.markers.poses import set_frames
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
