"""Vibrations that a jump of the accelerations excites, and what a scheme makes of each, step by step.

Of a large system few modes matter. Ritz vectors that start from the static answer to the load find them (Wilson, Yuan and Dickens, Dynamic
analysis by direct superposition of Ritz vectors, 1982):

    (K + s^2 M) x_1 = K a,   (K + s^2 M) x_(k+1) = M x_k,   all x in the motions that the joints allow

The jump a of the accelerations comes in as K a, so that what moves without a deformation counts as none. The shift s^2 keeps the matrix
regular where something is free to move, and leaves to slow motions what is theirs.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import scipy

from toolkit.components.curves.curve import Curve
from toolkit.foundation.compiled.calls import call
from toolkit.foundation.kernel import kernel
from toolkit.solvers.direct_solve import solve_linear
from toolkit.solvers.static.static_matrix import Saddle, factorised, whole_array
from toolkit.solvers.transient.scheme import Scheme, generalized_alpha
from toolkit.system.equations import Inputs, Terms
from toolkit.system.solution import Solution
from toolkit.system.system import System


def part_kept(scheme: Scheme, rates: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Part of the complex amplitude of modes (m,) that steps of some lengths (n,) keep, (n, m), its phase behind the true one."""
    phases = np.multiply.outer(lengths, rates)
    found: np.ndarray = root(scheme, phases) * np.exp(-1j * phases)
    return found


def amplification(scheme: Scheme, phase: np.ndarray | float) -> np.ndarray:
    """Amplification matrices (..., 4, 4) of the scheme for q'' = -phase^2 q with steps of length 1, of (q, v, a, w), by phases (...)."""
    s, square = scheme, np.square(phase)
    after, before = np.zeros((2, *square.shape, 4, 4))
    after[...] = [[1, 0, 0, -s.beta], [0, 1, 0, -s.gamma], [0, 0, -s.new, 1], [0, 0, s.weight_inertial, 0]]
    after[..., 3, 0] = s.weight_applied * square
    before[...] = [
        [1, s.keep, 0, s.beta_old],
        [0, s.keep, 0, s.gamma_old],
        [0, 0, s.old, -s.carry],
        [0, 0, -s.carried_inertial, 0],
    ]
    before[..., 3, 0] = -s.carried_applied * square
    found: np.ndarray = np.linalg.solve(after, before)
    return found


def root(scheme: Scheme, phase: np.ndarray | float) -> np.ndarray:
    """The eigenvalue of the amplification matrix that stays longest, with the phase of a step, by phases (...); no larger than one."""
    values = np.linalg.eigvals(amplification(scheme, phase)).astype(complex)
    forward = np.where(values.imag >= 0, np.abs(values), -1.0)
    found = np.take_along_axis(values, np.argmax(forward, axis=-1)[..., None], axis=-1)[..., 0]
    return found / np.maximum(np.abs(found), 1.0)


def error_after(scheme: Scheme, rate: float, step: float, time: float) -> float:
    """Error of a vibration of some angular frequency, by its phase and by what is damped away, after some time; 1 if all is wrong."""
    kept = root(scheme, rate * step) * np.exp(-1j * rate * step)
    return float(min(abs(kept ** (time / step) - 1), 1.0))


KEPT_AMPLITUDE, LIVES = 0.6, np.exp(-1)
"""Part of an amplitude that steps keep, from which on runs with other steps show the difference: at the end, or where damping has
left so much of it."""
EQUAL_PIECES = 1e-9
"""Part of a piece of a curve by which others may be longer and are as long: sixteen in a row turn a phase by no more."""
EXCITING_LOSS = 1e-3
"""Lost amplitude, relative to the variation of a curve, above which the curve excites vibrations that count."""
LOOKED_FOR = np.geomspace(0.3, 30.0, 12)
"""Angular frequencies times step at which `shakes` examines a curve."""


class ForceHistory(NamedTuple):
    """Values of a curve over time: instants (k,), with both sides of every corner, and its numbers there (k,)."""

    times: np.ndarray
    values: np.ndarray


class ForcePieces(NamedTuple):
    """Straight pieces of a curve in which it changes, after some instant.

    They have their middles, lengths and growth (k,), and the number of those before each step and before the end, (n_t,).
    """

    middle: np.ndarray
    length: np.ndarray
    growth: np.ndarray
    before: np.ndarray


def lost_parts(
    solution: Solution, history: ForceHistory | None, begin: float, rates: np.ndarray, damping: np.ndarray
) -> np.ndarray:
    """Amplitudes that are lost at all times, (n_t, m), complex, of modes with angular frequencies and damping ratios (m,).

    Every growth dg of the curve within a step leaves a vibration that is a part dg of what a sudden one would, with its phase, which is
    zero at the time `begin`; without a curve the force is there at once. Of modes that last, nothing counts.
    """
    options, times = solution.options or solution.system.scene.solver, solution.times
    lengths, which = np.unique(np.diff(times).round(15), return_inverse=True)
    keeps = part_kept(generalized_alpha(options.scheme, options.rho_inf), rates, lengths)
    fades = np.exp(-np.outer(lengths, rates * np.minimum(damping, 1.0)))
    lost = np.zeros((len(times), len(rates)), complex)
    at_once = 1.0 if history is None else 0.0
    parts = (np.ascontiguousarray(each).view(float).reshape(*each.shape, 2) for each in (keeps, lost))
    call(add_lost, *_pieces(history, begin, times), which, fades, rates, at_once, *parts)
    return lost


def _pieces(history: ForceHistory | None, begin: float, times: np.ndarray) -> ForcePieces:
    """Straight pieces of a curve in which it changes; none without a curve."""
    if history is None:
        none = np.zeros(0)
        return ForcePieces(none, none, none, np.zeros(len(times), np.int64))
    growth = np.diff(history.values)
    middle, changes = (history.times[1:] + history.times[:-1]) / 2, growth != 0
    middle = middle[changes]
    before = np.searchsorted(middle, times, side="right")
    before[0], before[-1] = 0, len(middle)
    return ForcePieces(middle - begin, np.diff(history.times)[changes], growth[changes], before)


@kernel
def add_lost(middle, length, growth, before, which, fades, rates, at_once, keeps, lost):
    """Add to `lost` (n_t, m, 2) what steps have lost of vibrations: of some that are there at once, and of those by pieces of a curve.

    Steps are numbers `which` (n_t - 1,) of the rows of what damping leaves of an amplitude and of what they keep of that, (.., m, 2). A
    piece leaves the Fourier integral of its slope. Its phase is that of the one before it, turned on, where both are as long as the one
    before these: samples within a step mostly are. Complex numbers are written as pairs.
    """
    for j in range(len(rates)):
        lives, lasting = 1.0, 1.0
        for n in range(len(which)):
            keep_x, keep_y = keeps[which[n], j, 0], keeps[which[n], j, 1]
            lasting *= np.sqrt(keep_x * keep_x + keep_y * keep_y) if lives > LIVES else 1.0
            lives *= fades[which[n], j]
        if lasting >= KEPT_AMPLITUDE:
            continue
        x, y, kept_x, kept_y = at_once, 0.0, at_once, 0.0
        known, size, turn_x, turn_y, c, s = -1.0, 1.0, 1.0, 0.0, 1.0, 0.0
        for n in range(len(which)):
            grown_x, grown_y = 0.0, 0.0
            for k in range(before[n], before[n + 1]):
                alike = np.abs(length[k] - known) <= EQUAL_PIECES * length[k]
                if not alike:
                    known, half = length[k], rates[j] * length[k] / 2
                    size = np.sin(half) / half if half != 0 else 1.0
                    turn_x, turn_y = np.cos(2 * half), -np.sin(2 * half)
                if alike and k > before[n] and np.abs(middle[k] - middle[k - 1] - known) <= EQUAL_PIECES * known:
                    c, s = c * turn_x - s * turn_y, c * turn_y + s * turn_x
                else:
                    c, s = np.cos(rates[j] * middle[k]), -np.sin(rates[j] * middle[k])
                grown_x += growth[k] * size * c
                grown_y += growth[k] * size * s
            fade, keep_x, keep_y = fades[which[n], j], keeps[which[n], j, 0], keeps[which[n], j, 1]
            x, y = grown_x + fade * x, grown_y + fade * y
            kept_x, kept_y = (
                grown_x + fade * (keep_x * kept_x - keep_y * kept_y),
                grown_y + fade * (keep_x * kept_y + keep_y * kept_x),
            )
            lost[n + 1, j, 0] += x - kept_x
            lost[n + 1, j, 1] += y - kept_y


def shakes(solution: Solution, history: ForceHistory) -> bool:
    """Whether a curve excites what steps take out, whatever it acts on."""
    rates = LOOKED_FOR / float(np.diff(solution.times).max())
    lost = lost_parts(solution, history, float(solution.times[0]), rates, np.zeros(len(rates)))
    return bool(np.abs(lost).max(initial=0.0) > EXCITING_LOSS * np.ptp(history.values))


QUIET_JUMP = 1e-7
"""Part of the model size (or rad) by which a jump of accelerations moves anything in a step, below which it excites nothing."""
MOST_KICKS = 6
"""So many of them are looked at, the largest."""
FORCES, ACCELERATIONS = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
"""Levels of the joints: their gaps, as statics closes them, and their accelerations alone."""
SAMPLES, MOST_SAMPLES, LEAST_SAMPLES = 16, 20_000, 2
"""Instants of a step at which curves are looked at, in how many instants at most, and in how many of a step at least."""


class Kick(NamedTuple):
    """What accelerates a motion out of what it follows.

    Attributes
    ----------
    time
        When, or when most.
    state
        Number of the last state of the motion before it.
    jumps
        Accelerations that set in, and their rates, (n, 2).
    changes
        Their derivatives by the design, (2, n, n_x).
    history
        Of the curve that multiplies them; None of the start, where they are there at once.
    """

    time: float
    state: int
    jumps: np.ndarray
    changes: np.ndarray
    history: ForceHistory | None = None


def kicks(solution: Solution) -> list[Kick]:
    """The start, and what the curves of loads and drivers do, as far as it moves something within a step."""
    found = [_start(solution), *_of_curves(solution)]
    system, longest = solution.system, float(np.diff(solution.times).max())
    spans = system.weights[: system.n_b, None] * longest ** np.array([2.0, 3.0])
    sizes = [float((np.abs(kick.jumps[: system.n_b]) * spans).max(initial=0.0)) * _variation(kick.history) for kick in found]
    order = sorted(range(len(found)), key=lambda n: -sizes[n])[:MOST_KICKS]
    return [found[n] for n in sorted(order) if sizes[n] > QUIET_JUMP]


def _variation(history: ForceHistory | None) -> float:
    return 1.0 if history is None else float(np.ptp(history.values))


def padded(solution: Solution, state: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, v, a of a state, (n,), with nothing for multipliers."""
    rest = np.zeros(solution.system.n - solution.system.n_q)
    q, v, a = (np.append(each[state], rest) for each in (solution.q, solution.v, solution.a))
    return q, v, a


def _start(solution: Solution) -> Kick:
    """Accelerations out of rest, and velocities that deform."""
    system = solution.system
    q, v, a = padded(solution, 0)
    terms = system.evaluate(system.inputs(solution.times[0], ACCELERATIONS), q, v, np.zeros(system.n))
    rate = system.times(terms.I_q + terms.A_q, v[:, None]) + system.times(terms.A_v, a[:, None])
    rate[system.n_b :] = 0
    mass = terms.I_acc + system.unit_of_states
    changes = np.zeros((2, system.n, system.n_x))
    if solution.da.shape[-1]:
        changes[0, : system.n_q] = solution.da[0]
    return Kick(float(solution.times[0]), 0, np.column_stack([a, _accelerated(solution, mass, rate)[:, 0]]), changes)


def _accelerated(solution: Solution, mass: np.ndarray, residuals: np.ndarray) -> np.ndarray:
    """Accelerations (n, k) by residuals (n, k) and a mass matrix with joints on the pattern, with nothing for multipliers."""
    found = solve_linear(solution.system, mass, -residuals, "accelerations")
    found[solution.system.n_b :] = 0
    return found


def _of_curves(solution: Solution) -> Iterator[Kick]:
    """Curves act by their value as loads, and by their second derivative as drivers."""
    for c, curve in enumerate(solution.system.values.curves.values()):
        if curve.is_constant:
            continue
        times = _instants(solution, curve)
        numbers = np.real(curve.evaluate(times))
        for column in (0, 2):
            history = ForceHistory(times, numbers[:, column])
            if np.ptp(history.values) > 0 and (kick := _kick(solution, c, column, history)) is not None:
                yield kick


def _instants(solution: Solution, curve: Curve) -> np.ndarray:
    """Some in every step, and both sides of every corner."""
    times = solution.times
    count = min(max(MOST_SAMPLES // len(times), LEAST_SAMPLES), SAMPLES)
    parts = times[:-1, None] + np.diff(times)[:, None] * np.arange(count) / count
    corners = np.array([float(np.real(t)) for t in curve.corners()])
    corners = corners[(corners >= times[0]) & (corners < times[-1])]
    before = corners[corners > times[0]]
    return np.unique([*parts.ravel(), times[-1], *np.nextafter(before, -np.inf), *np.nextafter(corners, np.inf)])


def _kick(solution: Solution, curve: int, column: int, history: ForceHistory) -> Kick | None:
    """Accelerations by a curve that grows by one, about where it changes most in a step; None if they excite nothing."""
    system, times = solution.system, solution.times
    in_step = np.abs(np.diff(np.interp(times, *history)))
    state = int(np.argmax(in_step))
    q, v, _ = padded(solution, state)
    inputs, rest = system.inputs(times[state], ACCELERATIONS), np.zeros(system.n)
    size, moved = float(np.ptp(history.values)), inputs.curves.copy()
    moved[curve, column] += size
    there = inputs._replace(curves=moved)
    (before, before_x), (after, _) = (_residual(solution, each, q, v, rest) for each in (inputs, there))
    if np.array_equal(before, after) or not shakes(solution, history):
        return None
    mass = system.evaluate(inputs, q, v, rest).I_acc + system.unit_of_states
    acceleration = _accelerated(solution, mass, (after - before)[:, None])
    changes = np.zeros((2, system.n, system.n_x))
    if system.n_x:
        _, after_x = _residual(solution, there, q, v, acceleration[:, 0])
        changes[0] = _accelerated(solution, mass, after_x - before_x) / size
    jumps = np.column_stack([acceleration[:, 0] / size, np.zeros(system.n)])
    return Kick(float(times[state]), state, jumps, changes, history)


def _residual(solution: Solution, inputs: Inputs, q: np.ndarray, v: np.ndarray, acc: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Residual (n,) and its partial derivatives by the design (n, n_x)."""
    terms = solution.system.evaluate(inputs, q, v, acc, design=True, linearize=False)
    return terms.inertial + terms.applied, terms.I_x + terms.A_x


MOST_RITZ_VECTORS = 24
"""Most Ritz vectors: some twenty modes of a load."""
DEPENDENT_VECTOR = 1e-6
"""Part of a vector that earlier ones leave of it, below which it is their sum."""


class ExcitedModes(NamedTuple):
    """Modes of unit modal mass, how they are damped, and how jumps push them.

    Attributes
    ----------
    rates
        Angular frequencies, (m,), in 1/time.
    damping
        Damping ratios, (m,).
    shapes
        Of coordinates, (n_q, m).
    resisted
        Stiffness times shapes, (n_q, m).
    forces
        Of multipliers, (n_lam, m), while the mode is at its largest.
    pushes
        Modal accelerations by each jump, (jumps, m).
    """

    rates: np.ndarray
    damping: np.ndarray
    shapes: np.ndarray
    resisted: np.ndarray
    forces: np.ndarray
    pushes: np.ndarray


def excited_modes(system: System, terms: Terms, jumps: np.ndarray, shift: float) -> ExcitedModes:
    """The modes that jumps of accelerations (n, jumps) excite, of a state whose terms are linearised.

    Parameters
    ----------
    shift : float
        Angular frequency in 1/time below which motions are none of these.

    Raises
    ------
    SingularSystemError
        The joints repeat each other, or something has neither mass nor stiffness.
    """
    stiffness, mass = _of_coordinates(system, terms.I_q + terms.A_q), _of_coordinates(system, terms.I_acc)
    of_multiplier = system.plan.indices >= system.n_q
    shifted = stiffness + shift**2 * (mass + system.unit_of_states)
    saddle = factorised(system, whole_array(system, np.where(of_multiplier, terms.I_acc, shifted)))
    basis = _ritz_vectors(system, saddle, mass, _forces(system, stiffness, jumps))
    reduced = basis.T @ _forces(system, stiffness, basis)
    squares, turned = scipy.linalg.eigh((reduced + reduced.T) / 2)
    kept = squares > (DEPENDENT_VECTOR * shift) ** 2
    rates, shapes = np.sqrt(squares[kept]), basis @ turned[:, kept]
    damped = np.einsum("im,im->m", shapes, system.times(_of_coordinates(system, terms.A_v), shapes))
    held = saddle.solve(_forces(system, mass, shapes))[system.n_q :] * (rates**2 + shift**2)
    n_q, resisted = system.n_q, _forces(system, stiffness, shapes)
    pushes = jumps.T @ resisted / rates**2
    return ExcitedModes(rates, damped / (2 * rates), shapes[:n_q], resisted[:n_q], held, pushes)


def _of_coordinates(system: System, values: np.ndarray) -> np.ndarray:
    """Values on the pattern without the columns of multipliers."""
    return np.where(system.plan.indices < system.n_q, values, 0.0)


def _forces(system: System, values: np.ndarray, motions: np.ndarray) -> np.ndarray:
    """What a matrix of coordinates makes of motions (n, k), on bodies alone."""
    found = system.times(values, motions)
    found[system.n_b :] = 0
    return found


def _ritz_vectors(system: System, saddle: Saddle, mass: np.ndarray, pushed: np.ndarray) -> np.ndarray:
    """Vectors (n, m) with X^T M X = 1, zero for multipliers."""
    basis, masses = np.zeros((system.n, 0)), np.zeros((system.n, 0))
    block = pushed
    while basis.shape[1] < MOST_RITZ_VECTORS and block.shape[1]:
        found = saddle.solve(block)
        found[system.n_b :] = 0
        block = np.zeros((system.n, 0))
        for each in found.T:
            before = np.sqrt(max(each @ _forces(system, mass, each[:, None])[:, 0], 0.0))
            for _ in range(2):
                each = each - basis @ (masses.T @ each)
            moved = _forces(system, mass, each[:, None])
            size = np.sqrt(max(each @ moved[:, 0], 0.0))
            if size > DEPENDENT_VECTOR * before:
                basis, masses = np.column_stack([basis, each / size]), np.column_stack([masses, moved / size])
                block = np.column_stack([block, moved / size])
    return basis
