"""The load margin, and the slowest vibration on the whole way of a static load.

Where on the way of a static load the slowest vibration is slowest, and its derivatives by the design there.

    f(x) = min over mu of f_1(z(mu, x), mu, x),    df = f_z dz + f_x

with the derivatives at the load factor mu of the least one: how that changes counts for nothing.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Annotated, NamedTuple

import numpy as np
import scipy

from toolkit.description.description import Positive, Quantity
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError
from toolkit.responses.pencil import Pencil, free_pencil, pencil_change, pencil_of, real_pencil, softest_vibration
from toolkit.responses.response import Partials, Response
from toolkit.responses.vibration import Frequency
from toolkit.scene.scene import Scene
from toolkit.solvers.direct_solve import solve_linear
from toolkit.solvers.static.continuation import to_full_load
from toolkit.solvers.static.equilibrium import DIRECTION_LOAD_PART, Equilibrium, find_equilibrium, inputs_at, static_matrix
from toolkit.solvers.static.static_start import start_of_path
from toolkit.system.solution import Solution, StaticPath
from toolkit.system.system import System, compile_scene


class LoadMargin(Response):
    """Load factor of the first limit point, in parts of the full load: 1.3 says that an equilibrium snaps through when all loads have grown
    by 30 %, in proportion. Statics alone have it; a load that is beyond its limit point is followed there by `--past-limit`.

    Attributes
    ----------
    up_to
        Load factor up to which a limit point is looked for.
    """

    kind = "load-margin"
    quantity = "none"

    up_to: Annotated[Positive, Quantity("none")] = 10.0

    @property
    def needs_rest(self) -> bool:
        """Whether the response exists for an equilibrium only; always true of a load margin."""
        return True

    def partials(self, solution: Solution) -> Partials:
        """Load factor and its partial derivatives; the path goes beyond the full load unless it passed a limit point before.

        Raises
        ------
        InputError
            It is the steady state of a spin.
        ConvergenceError
            There is none up to `up_to`.
        BifurcationError
            The path loses its stability at a bifurcation before.
        """
        from toolkit.solvers.static.continuation import factor_of_limit_point, next_limit_point  # read where one is asked for

        if solution.spins:
            raise InputError(
                "a load margin is that of an equilibrium at rest: a spin has no path of loads to follow. Leave out the response, or "
                'solver.equilibrium = "spinning".'
            )
        system, options = solution.system, solution.options or solution.system.scene.solver
        known = solution.path
        if known is not None and known.limit_points:
            at = known.limit_points[0].place
            z = np.concatenate([known.q[at], known.multipliers[at], known.load_factors[at : at + 1]])
        else:
            real = system if system.compiled else compile_scene(real_scene(system.scene))
            begin = np.concatenate([solution.q[-1], solution.multipliers[-1], [1.0]])
            z = next_limit_point(real, options, np.real(begin), self.up_to)
        value, design = factor_of_limit_point(system, options, np.real(z))
        return Partials(value, design=design)


def real_scene(scene: Scene) -> Scene:
    """Scene with the real parts of its numbers."""
    for path, value in list(scene.numbers()):
        if isinstance(value, complex):
            scene = scene.with_number(path, value.real)
    return scene


PARTS_PER_STEP = 2
"""Parts that every step of the path is cut into, where it is looked for."""
LOAD_FACTOR_TOLERANCE, SLOPE_TOLERANCE = 1e-3, 1e-8
"""How well its load factor is found by values, in parts of these; and by slopes, in parts of what is left."""
STRAYING_DISTANCE = 0.1
"""Distance, in parts of the model size (or rad), of an equilibrium between two points of the path from the straight line."""
FREQUENCY = Frequency()


class LoadWay(NamedTuple):
    """Path of a static load, on which equilibria are found by their load factors."""

    solution: Solution
    options: RunOptions
    path: StaticPath

    def state(self, factor: float) -> Equilibrium:
        """Equilibrium at a load factor."""
        system, known = self.solution.system, self.path
        k = int(np.clip(np.searchsorted(known.load_factors, factor), 1, len(known.load_factors) - 1))
        low, high = known.load_factors[k - 1 : k + 1]
        part = (factor - low) / (high - low)
        q, lam = (each[k - 1] + part * (each[k] - each[k - 1]) for each in (known.q, known.multipliers))
        free = np.zeros(system.n - system.n_q)
        found, _ = find_equilibrium(
            system, self.options, factor, np.append(q, free), np.append(np.zeros(system.n_q), lam), STRAYING_DISTANCE
        )
        return found

    def stiffness(self, factor: float) -> float:
        """Least squared angular frequency at a load factor: quick, and without vectors."""
        there = _beside(self.solution, self.state(factor))
        pencil = _undamped(pencil_of(there, inputs_at(self.solution.system, self.options, factor)))
        matrices = free_pencil(self._weights, pencil)[1]
        return float(np.min(scipy.linalg.eigvals(matrices.stiffness, matrices.mass).real))

    def slope(self, factor: float) -> float:
        """Derivative of the least frequency along the path."""
        system, options = self.solution.system, self.options
        found = self.state(factor)
        there = _beside(self.solution, found)
        here, further = (inputs_at(system, options, each) for each in (factor, factor + DIRECTION_LOAD_PART))
        pencil = _undamped(pencil_of(there, here))
        s, u, w, scale, _ = softest_vibration(self._weights, pencil)
        by_z = pencil_change(there, s, u, w, damped=False, inputs=here)[0]
        own = (
            w @ (_undamped(pencil_of(there, further)).stiffness - pencil.stiffness) @ u / DIRECTION_LOAD_PART
        )  # of loads that follow the body
        return float(FREQUENCY.slope(s, -(by_z @ found.tangent + own) / scale) if scale else 0.0)

    def softest(self) -> float:
        """Load factor of the least frequency: between the points of the path first, then where its slope along the path vanishes."""
        from scipy.optimize import (
            brentq,
            minimize_scalar,
        )  # for this response alone: they take longer to import than a wing to solve

        steps = pairwise(self.path.load_factors)
        factors = [low + (high - low) * k / PARTS_PER_STEP for low, high in steps for k in range(PARTS_PER_STEP)] + [1.0]
        found = [self.stiffness(each) for each in factors]
        k = int(np.argmin(found))
        low, high = factors[max(k - 1, 0)], factors[min(k + 1, len(factors) - 1)]
        best = float(
            minimize_scalar(
                self.stiffness, bounds=(low, high), method="bounded", options={"xatol": LOAD_FACTOR_TOLERANCE * (high - low)}
            ).x
        )
        low, high = (
            max(low, best - 10 * LOAD_FACTOR_TOLERANCE * (high - low)),
            min(high, best + 10 * LOAD_FACTOR_TOLERANCE * (high - low)),
        )
        if self.slope(low) >= 0 or self.slope(high) <= 0:
            return min((low, best, high), key=self.stiffness)  # at an end of the path, or where two vibrations change places
        return float(brentq(self.slope, low, high, xtol=SLOPE_TOLERANCE * (high - low)))

    @property
    def _weights(self) -> np.ndarray:
        system = self.solution.system
        return system.weights[: system.n_q]


def path_from_rest(system: System, options: RunOptions) -> StaticPath:
    """Static path from the unloaded state to the full load, for an equilibrium that was found beside another one."""
    state, factor, _ = start_of_path(system, options)
    return to_full_load(system, options, state, factor, False).path


def _beside(solution: Solution, found: Equilibrium) -> Solution:
    n_q = solution.system.n_q
    return replace(solution, q=found.q[None, :n_q], multipliers=found.acc[None, n_q:])


def _undamped(pencil: Pencil) -> Pencil:
    return real_pencil(pencil._replace(damping=0 * pencil.damping))


def frequency_at(solution: Solution, options: RunOptions, factor: float, known: Equilibrium) -> Partials:
    """Least frequency at a load factor, near a known real equilibrium there, with its derivatives by the design."""
    system, inputs = solution.system, inputs_at(solution.system, options, factor)
    found, _ = find_equilibrium(
        system, options, factor, known.q.astype(system.dtype), known.acc.astype(system.dtype), STRAYING_DISTANCE
    )
    there = _beside(solution, found)
    pencil = pencil_of(there, inputs)
    s, u, w, scale, alone = softest_vibration(system.weights[: system.n_q], _undamped(pencil))
    if not alone:
        return Partials(FREQUENCY.of(s), design=np.full(system.n_x, np.nan))
    moved = s * s * np.imag(pencil.mass) + np.imag(pencil.stiffness)
    value = FREQUENCY.of(s) + 1j * FREQUENCY.slope(s, -(w @ moved @ u) / scale)
    by_z, by_x = (FREQUENCY.slope(s, -each / scale) for each in pencil_change(there, s, u, w, damped=False, inputs=inputs))
    design = by_x
    if system.n_x:
        terms = system.evaluate(inputs, found.q, np.zeros_like(found.q), found.acc, design=True)
        design = by_x - by_z @ solve_linear(system, static_matrix(system, terms), terms.I_x + terms.A_x, "a least frequency")
    return Partials(value.real if system.compiled else value, design=design)


class LeastFrequency(Response):
    """Least frequency of the slowest vibration about all equilibria between the unloaded state and the full load, in cycles per time. It
    goes to zero where a limit point is born on the way, at which a load margin jumps without a warning. Statics alone have it.
    """

    kind = "least-frequency"
    quantity = "rate"

    @property
    def needs_rest(self) -> bool:
        """Whether the response exists for an equilibrium only; always true of a least frequency."""
        return True

    def partials(self, solution: Solution) -> Partials:
        """Value and partial derivatives at the load factor of the least frequency, which is searched along the path.

        Raises
        ------
        InputError
            It is the steady state of a spin, or the path has snapped through.
        ConvergenceError
            The path from the unloaded state does not lead to the full load.
        """
        system, options = solution.system, solution.options or solution.system.scene.solver
        if solution.spins or (solution.path is not None and solution.path.limit_points):
            raise InputError(
                "a least frequency is that of a path of loads at rest that does not snap through. Leave out the response, "
                'solver.equilibrium = "spinning" or solver.continuation = "arc-length".'
            )
        real = system if system.compiled else compile_scene(real_scene(system.scene))
        way = LoadWay(replace(solution, system=real), options, solution.path or path_from_rest(real, options))
        factor = way.softest()
        return frequency_at(solution, options, factor, way.state(factor))
