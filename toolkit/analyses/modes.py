"""Eigenfrequencies of the constrained, linearised system about an equilibrium."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence, Sized
from typing import NamedTuple

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import SHORT, ConvergenceError, InputError, SingularSystemError, retold
from toolkit.foundation.near_ties import told_apart
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.responses.flutter import unstable_vibrations
from toolkit.solvers.direct_solve import check_dense
from toolkit.solvers.free_motions import (
    ROUND_OFF,
    VIBRATING_PART,
    all_roots,
    count_of_zeros,
    counts,
    felt_state,
    free_motions,
    frequency_of,
    made_of,
    refined,
    undamped_modes,
)
from toolkit.solvers.spin_axis import angular_velocity, generator, linearised, refuse_what_changes, spin_of
from toolkit.solvers.start.initial_conditions import closed, initial_accelerations
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.solvers.steady_state import steady_state
from toolkit.system.solution import Solution
from toolkit.system.system import System
from toolkit.validity.bodies.critical_speed import cautions_of_spin
from toolkit.validity.bodies.frequencies import cautions_of_damping, cautions_of_modes
from toolkit.validity.judge import judge


class Modes(NamedTuple):
    """Frequencies in cycles per time, ascending, and mode shapes.

    A negative frequency f stands for an unstable equilibrium: the motion grows like exp(2 pi |f| t).
    The verdict holds what speaks against them: that the scene spins, for example, while these are modes about a state at rest.

    About a steady spin frequencies are those that the frame sees which spins with the scene, and shapes are complex: real and imaginary
    part follow each other a quarter of a period apart. `damping`, in parts of the critical one, is None about a state at rest, whose
    modes are those without dampers, unless two of these flutter: then their shapes are complex, too. A negative one stands for a
    vibration that grows like exp(2 pi f zeta t / sqrt(1 - zeta^2)) with the size zeta of it.
    """

    frequencies: np.ndarray  # (n_modes,)
    shapes: np.ndarray  # (n_q, n_modes)
    verdict: Verdict = Verdict()
    damping: np.ndarray | None = None  # (n_modes,)

    def __repr__(self) -> str:
        return f"<Modes: {', '.join(f'{each:.6g}' for each in self.frequencies)} per unit of time>"


NEGLIGIBLE_DAMPING = 1e-6
"""Real part of a root, in parts of its size, below which it is round-off: of two roots that are nearly one it is the root of it."""


def solve_spinning(
    system: System, options: RunOptions | None = None, speed: float | None = None, known: Solution | None = None
) -> Solution:
    """The steady state of a scene that a driver spins, under the loads at the end time; with its design derivatives.

    Every body turns with the driver, about its axis, and deforms under its own inertia.

    Parameters
    ----------
    system
        The compiled scene.
    options
        By default the scene's own.
    speed
        In rad/time, instead of the driver's; then design derivatives are left out.
    known
        A steady state of the same scene next to it, to begin in.

    Raises
    ------
    InputError
        Nothing says the speed, or the scene cannot turn as a whole, or is not the same at every angle.
    ConvergenceError, SingularSystemError
        There is no steady state, or something is free to move in the frame that spins.
    """
    options = options or system.scene.solver
    check_dense(system, options)
    n_q = system.n_q
    beside = None if known is None else (known.q[-1].astype(system.dtype), known.multipliers[-1].astype(system.dtype))
    found = steady_state(system, options, speed, beside)
    inputs = system.inputs(options.end_time, LEVELS)
    spin = spin_of(system, options, inputs)
    motion = spin.generator(system).times(found.speed / spin.speed)
    if system.compiled:
        refuse_what_changes(system, inputs, motion, found.speed, found.q)
    return Solution(
        system, np.array([options.end_time]), found.q[None], found.v[None], found.acc[None, :n_q], found.acc[None, n_q:],
        found.dq[None], found.dv[None], found.dacc[None, :n_q], found.dacc[None, n_q:], options=options, judge=judge,
        load_steps=found.steps, newton_iterations=found.iterations,
    )  # fmt: skip


def spinning_modes(solution: Solution, count: int | None = None) -> Modes:
    """Modes about a steady spin, as they are seen from the frame that spins, with gyroscopic and centrifugal forces and with dampers.

        (s^2 M + s C + K) u = 0,   J u = 0,   see `solvers.spin.state.Linearised.spinning`

    Raises
    ------
    SingularSystemError
        The joints leave no motion.
    """
    system, n_q = solution.system, solution.system.n_q
    q, v = solution.q[-1], solution.v[-1]
    omega = angular_velocity(system, q, v)
    motion = generator(system, omega, np.zeros(system.scene.dimension)).matrix
    acc = np.concatenate([solution.a[-1], solution.multipliers[-1]])
    whole = linearised(system, system.inputs(solution.times[-1], LEVELS), q, v, acc)
    free = free_motions(whole.by_acc[:n_q, n_q:].T, system.weights[:n_q])
    if not free.shape[1]:
        raise SingularSystemError("the joints leave no motion, so there are no modes. Remove a joint or a driver.")
    K, C, M = (free.T @ each[:n_q, :n_q] @ free for each in whole.spinning(motion))
    values, left, right = all_roots(K, C, M)
    largest = float(np.abs(values).max())
    chosen = [k for k in range(len(values)) if counts(values[k], largest)]
    roots, shapes = [], []
    for k in chosen:
        s, u, _ = refined(K, C, M, values[k], right[:, k], left[:, k])
        near = abs(s - values[k]) < 0.1 * abs(values[k])
        roots.append(s if near else values[k])
        shapes.append(free @ (u if near else right[:, k]))
    zeros = count_of_zeros(values, largest)
    order = np.argsort([frequency_of(s) for s in roots], kind="stable")
    frequencies = np.array([frequency_of(roots[k]) for k in order])
    ratios = np.array([-roots[k].real / abs(roots[k]) for k in order])
    ratios[np.abs(ratios) < NEGLIGIBLE_DAMPING] = 0.0
    place = int(np.searchsorted(frequencies, 0.0))
    frequencies, ratios = np.insert(frequencies, place, [0.0] * zeros), np.insert(ratios, place, [0.0] * zeros)
    columns = [_scaled(shapes[k], system.weights[:n_q]) for k in order]
    columns[place:place] = [np.zeros(n_q)] * zeros
    cautions = [*_cautions(np.array(roots)), *cautions_of_modes(solution, frequencies[:count], count)]
    return Modes(frequencies[:count], np.column_stack(columns)[:, :count], Verdict.of(cautions), ratios[:count])


def _scaled(shape: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Mode shape divided by its entry for the coordinate that moves most, in comparable units, so that this entry is real."""
    place = int(np.argmax(weights * np.abs(shape)))
    return shape / shape[place]


def _cautions(roots: np.ndarray) -> list[Caution]:
    growing = roots[roots.real > NEGLIGIBLE_DAMPING * np.abs(roots)]
    if not len(growing):
        return []
    worst = growing[np.argmax(growing.real)]
    what = f"vibrates with {worst.imag / (2 * np.pi):.4g} Hz and" if worst.imag > VIBRATING_PART * abs(worst) else "runs away and"
    return [
        Caution(
            "unstable",
            f"this spin is unstable: a small disturbance {what} grows like exp({worst.real:.4g} t). A real scene would not stay in it; "
            "spin it slower, or stiffen what grows.",
        )
    ]


def solve_modes(solution: Solution, count: int | None = None) -> Modes:
    """Undamped modes about the last state of a static solution (or any state at rest); of a steady spin those of `spinning_modes`.

        Z^T K Z y = omega^2 Z^T M Z y,   J Z = 0,   K = d (residual) / dq with the joint forces' geometric stiffness

    K holds the change of the inertia forces of the accelerations, which vanish in an equilibrium: of what falls they cancel the weight.
    K is unsymmetric under following forces; then the general eigenvalue problem is solved, and two modes may flutter: they have one
    frequency, one grows and the other decays. Whether an imaginary part is round-off is decided by the condition of its own pair.

    Raises
    ------
    SingularSystemError
        The joints leave no motion, or the mass matrix is not positive definite.
    """
    if solution.spins:
        return spinning_modes(solution, count)
    system = solution.system
    n_q, n_b = system.n_q, system.n_b
    pad = np.zeros(system.n - n_q)
    q, rest = np.concatenate([solution.q[-1], pad]), np.zeros(system.n)
    acc = np.concatenate([solution.a[-1], solution.multipliers[-1]])  # what falls feels no weight
    terms = system.evaluate(system.inputs(solution.times[-1], np.array([0, 0, 1.0])), q, rest, acc)
    dense = {name: system.dense(getattr(terms, name)) for name in ("I_acc", "I_q", "A_q", "A_v")}
    mass, stiffness = dense["I_acc"][:n_b, :n_b], (dense["I_q"] + dense["A_q"])[:n_b, :n_q]
    felt = felt_state(system, stiffness)
    if felt:
        raise SingularSystemError(
            f"{felt} is an integral over time, which undamped modes do not have. Ask for the response "
            "damping-ratio, whose vibrations feel it, or leave the integral out."
        )
    stiffness = stiffness[:, :n_b]
    phi_q, weights, multipliers = dense["I_acc"][:n_b, n_q:].T, system.weights[:n_b], solution.multipliers[-1]
    free = free_motions(phi_q, weights)
    if not free.shape[1]:
        raise SingularSystemError("the joints leave no motion, so there are no modes. Remove a joint or a driver.")
    largest = made_of(stiffness, phi_q, multipliers, weights, free).max()
    squares, shapes = undamped_modes(stiffness, mass, free, largest)
    terms_of = np.diag(made_of(stiffness, phi_q, multipliers, weights, shapes))
    zero = (np.abs(squares) < ROUND_OFF * np.maximum(np.abs(squares).max(), terms_of)) & (np.imag(squares) == 0)
    squares = np.where(zero, 0.0, squares)
    frequencies, ratios = _vibrations(squares)
    order = np.lexsort((ratios, frequencies))
    squares, frequencies, ratios, shapes = squares[order], frequencies[order], ratios[order], shapes[:, order]
    real = np.flatnonzero(ratios == 0)
    if real.size:
        shapes[:, real] = told_apart(squares[real].real, shapes[:, real].real, weights)
    damped = cautions_of_damping(dense["A_v"][:n_b, :n_b], mass, *_first(squares, shapes, real[real < (count or len(squares))]))
    raised = cautions_of_modes(solution, frequencies[:count], count)
    unstable = unstable_vibrations(solution)
    found = Verdict.of([*cautions_of_spin(solution, frequencies), *damped, *raised, *unstable, *_flutter(frequencies, ratios)])
    shapes = np.pad(shapes[:, :count], ((0, n_q - n_b), (0, 0)))
    return Modes(frequencies[:count], shapes, found, ratios[:count] if np.any(ratios) else None)


def _first(squares: np.ndarray, shapes: np.ndarray, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return squares[chosen].real, shapes[:, chosen].real


def _vibrations(squares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies in cycles per time, and damping in parts of the critical one, of squares that are complex where vibrations flutter.

    Of a pair of squares one belongs to a vibration that grows, the other to one of the same frequency that decays.
    """
    s = np.sqrt(-squares + 0j)
    s = np.where(s.imag < 0, -s, s)
    flutters = np.imag(squares) != 0
    sizes = np.sqrt(np.abs(squares))
    frequencies = np.where(flutters, s.imag, np.sign(squares.real) * sizes) / (2 * np.pi)
    return frequencies, np.divide(-s.real, sizes, out=np.zeros(len(s)), where=flutters)


def _flutter(frequencies: np.ndarray, ratios: np.ndarray) -> Iterator[Caution]:
    """Caution on a mode of negative damping, with its numbers, where modes without dampers flutter."""
    growing = np.flatnonzero(ratios < 0)
    if growing.size:
        k = int(growing[0])
        rate = -2 * np.pi * frequencies[k] * ratios[k] / np.sqrt(1 - ratios[k] ** 2)
        yield Caution(
            "flutter",
            f"two modes have merged into one frequency, {frequencies[k]:.4g} Hz (numbers {k + 1} and {k + 2}): without dampers one grows "
            f"like exp({rate:.4g} t), the other one decays as fast.",
            doubt=False,
        )


def undeformed(system: System) -> Solution:
    """The given positions without deflection and velocity, with the joint forces that the loads at t = 0 call for.

    Raises
    ------
    InputError, SingularSystemError
        As `consistent_start`.
    """
    q, dq = closed(system, *system.undeformed(), 0.0)
    rest, drest = np.zeros_like(q), np.zeros_like(dq)
    acc, dacc = initial_accelerations(system, q, rest, dq, drest, np.array([1.0, 0.0, 0.0]), 0.0)
    options = system.scene.solver.model_copy(update={"equilibrium": "rest"})  # whatever statics would find
    states = tuple(item[None] for item in (q, rest, acc, dq, drest, dacc))
    return Solution.from_padded(system, np.zeros(1), states, options=options, judge=judge)


MOST_SPEEDS = 10_000
"""Speeds of one diagram."""


def refuse_too_many(count: int) -> None:
    """Refuse more speeds than a diagram may have, before they take memory.

    Raises
    ------
    InputError
        There are more than a diagram has.
    """
    if count > MOST_SPEEDS:
        raise InputError(f"{SHORT.repr(count)} speeds are more than the {MOST_SPEEDS} of one diagram. Ask for fewer.")


class Campbell(NamedTuple):
    """Frequencies in cycles per time and damping in parts of the critical one, in the order of the frequencies at every speed.

    They are those that the frame sees which spins with the scene. Curves that cross change places there. The verdict says at which
    speeds something speaks against them.
    """

    speeds: np.ndarray  # (n_speeds,) in rad/time
    frequencies: np.ndarray  # (n_speeds, n_modes), nan where there are fewer
    damping: np.ndarray  # (n_speeds, n_modes)
    verdict: Verdict = Verdict()

    def __repr__(self) -> str:
        count, modes = self.frequencies.shape
        return f"<Campbell: {modes} frequencies at {count} speeds from {self.speeds.min():g} to {self.speeds.max():g} rad per unit of time>"


def campbell(
    system: System, speeds: Sequence[float], count: int = 6, progress: Callable[[int, int], None] | None = None
) -> Campbell:
    """Modes of the steady states of a scene at several speeds of its driver.

    Parameters
    ----------
    speeds
        In rad/time, not negative; the sense is that of the driver.
    count
        How many frequencies, from the lowest.
    progress
        Called with the speeds done and the speeds in all.

    Raises
    ------
    InputError
        A speed is invalid, or as `solve_spinning`.
    ConvergenceError, SingularSystemError
        As `solve_spinning`; names the speed.
    """
    refuse_too_many(len(speeds) if isinstance(speeds, Sized) else 0)
    wanted = np.asarray(speeds, float)
    if wanted.ndim != 1 or not 1 <= len(wanted) <= MOST_SPEEDS or not np.all(np.isfinite(wanted)) or np.any(wanted < 0):
        raise InputError(f"speeds are a list of 1 to {MOST_SPEEDS} numbers in rad per unit of time, none of them negative.")
    options = system.scene.solver.model_copy(update={"equilibrium": "spinning"})
    count = min(count, 2 * system.n)
    frequencies, damping = np.full((2, len(wanted), count), np.nan)
    said: dict[str, list[tuple[float, Caution]]] = {}
    known: Solution | None = None
    for k, speed in enumerate(wanted):
        try:
            known = solve_spinning(system, options, float(speed), known)
            found = spinning_modes(known, count)
        except (ConvergenceError, SingularSystemError) as error:
            raise retold(error, f"at {speed:g} rad per unit of time: {error}") from error
        n = len(found.frequencies)
        frequencies[k, :n] = found.frequencies
        damping[k, :n] = np.nan if found.damping is None else found.damping
        for caution in (*found.verdict.warnings, *known.verdict.warnings):
            said.setdefault(caution.code, []).append((float(speed), caution))
        if progress:
            progress(k + 1, len(wanted))
    modes = max(1, int(np.isfinite(frequencies).any(axis=0).sum()))
    return Campbell(wanted, frequencies[:, :modes], damping[:, :modes], Verdict.of(map(_of_all, said.values())))


def _of_all(said: list[tuple[float, Caution]]) -> Caution:
    """One caution for all speeds, with the words of the last doubt, or of the last remark where none is a doubt."""
    doubts = [each for each in said if each[1].doubt] or said
    speeds = sorted({speed for speed, _ in doubts})
    where = f"at {speeds[0]:g}" if len(speeds) == 1 else f"at {len(speeds)} speeds from {speeds[0]:g} to {speeds[-1]:g}"
    speed, worst = doubts[-1]
    return Caution(worst.code, f"{where} rad per unit of time, here at {speed:g}: {worst.text}", worst.doubt)
