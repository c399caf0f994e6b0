"""Motion of the vibrations that steps take out, by the linearised modes.

A force that grows by dg at once leaves in the mode i, of the angular frequency w and unit mass, beside what follows the load

    -dg (a_i / w^2) exp(i w t - zeta w t),    a_i the modal acceleration by the whole force,

and one that grows slowly the sum of these, with their phases. Of each the scheme keeps the part (z exp(-i w h))^n after n
steps, z being the largest eigenvalue of its amplification matrix at w h.

How vibrations that steps take out depend on the design: mostly by their frequency, which the whole time multiplies.

In the basis of the modes a change of the design changes stiffness, mass and jump, whose eigenvalues and motion are found again:

    (M + d M_p) y'' + (K + d K_p) y = F + d F_p,   M = 1, K = diag(w^2),   F = M a

with the partial derivatives of the residual along every mode.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import scipy

from toolkit.analyses.sensitivity.errors.excited_vibrations import FORCES, ExcitedModes, Kick, excited_modes, lost_parts, padded
from toolkit.system.equations import Inputs
from toolkit.system.solution import Solution

RESOLVED_OMEGA_STEP = 0.5
"""Angular frequency times step from which on the scheme begins to take out what vibrates."""


class Lost(NamedTuple):
    """Vibrations that one kick excites and that steps take out, at some times.

    Attributes
    ----------
    kick
        What excites it.
    modes
        Those that it excites.
    passed
        Time since the kick, (n_t,), negative before it.
    swings
        Complex amplitudes of the modes, (n_t, m): each swings by the real part of swing exp(i rate passed).
    history
        The same in parts of the static deflection by the kick, without a rate of the kick.
    """

    kick: Kick
    modes: ExcitedModes
    passed: np.ndarray
    swings: np.ndarray
    history: np.ndarray

    def states(self, turned: float, only: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Coordinates q, v, a and multipliers of the lost motion, by the modes that `only` (m,) names, `turned` by a phase."""
        rates, shapes = self.modes.rates, self.modes.shapes.T
        swung = self.swings * np.exp(1j * (np.outer(self.passed, rates) + turned)) * only
        q, v = np.real(swung), np.real(1j * rates * swung)
        return q @ shapes, v @ shapes, -(q * rates**2) @ shapes, q @ self.modes.forces.T

    def at(self, steps: np.ndarray) -> Lost:
        """The lost motion at some of its times."""
        return self._replace(passed=self.passed[steps], swings=self.swings[steps], history=self.history[steps])


def lost_motion(solution: Solution, kick: Kick, times: np.ndarray) -> Lost | None:
    """Motion that a kick excites and that steps take out, at some times; None if nothing vibrates."""
    system = solution.system
    q, v, _ = padded(solution, kick.state)
    terms = system.evaluate(system.inputs(solution.times[kick.state], FORCES), q, v, np.zeros(system.n))
    modes = excited_modes(system, terms, kick.jumps, RESOLVED_OMEGA_STEP / float(np.diff(solution.times)[kick.state]))
    if not np.any(modes.damping < 1):
        return None
    first, second = modes.pushes
    lost = lost_parts(solution, kick.history, kick.time, modes.rates, modes.damping)
    counting = modes.damping < 1
    history = lost[np.searchsorted(solution.times, times)] * counting
    return Lost(kick, modes, times - kick.time, history * swing(modes.rates, first, second), history)


def swing(rates: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Complex amplitudes (m,) by modal accelerations and their rates (m,) that set in."""
    return -first / rates**2 + 1j * second / rates**3


def sizes_in_motion(seen: Solution, lost: Lost) -> np.ndarray:
    """Largest motion that each mode adds, (m,), relative to the largest of coordinates of that kind, or of multipliers."""
    ours = (seen.q - seen.q[0], seen.v, seen.multipliers)
    amplitude = np.abs(lost.swings).max(axis=0)
    theirs = (lost.modes.shapes * amplitude, lost.modes.shapes * amplitude * lost.modes.rates, lost.modes.forces * amplitude)
    found = np.zeros(len(amplitude))
    for group, place in _groups(seen):
        own, other = np.abs(ours[group][:, place]).max(initial=0.0), np.abs(theirs[group][place]).max(axis=0, initial=0.0)
        found = np.maximum(found, other / own if own > 0 else np.where(other > 0, np.inf, 0.0))
    return found


def _groups(solution: Solution) -> Iterator[tuple[int, np.ndarray | slice]]:
    """Groups of columns of q, v and multipliers: which of the three, and the columns.

    Every body has two groups, the coordinates of its frame and those of its deformation.
    """
    system = solution.system
    for name, body in system.scene.all_bodies().items():
        first = system.numbering.first[name]
        last = min((start for start in system.numbering.first.values() if start > first), default=system.n_b)
        for place in (slice(first, first + body.frame_size), slice(first + body.frame_size, last)):
            if place.start < place.stop:
                yield 0, place
                yield 1, place
    if system.n > system.n_q:
        yield 2, slice(None)


MODE_AMPLITUDE = 1e-4
"""Part of the model size (or rad) by which a mode is moved for the change of its stiffness."""
DESIGN_PHASE_CHANGE = 1e-3
"""Change of any phase, in rad, or of any size, by a change of the design: small, but far above round-off."""


class Reduced(NamedTuple):
    """Stiffness and mass (m, m) in the basis of the modes, and modal accelerations by the jumps (2, m)."""

    stiffness: np.ndarray
    mass: np.ndarray
    pushes: np.ndarray

    def moved(self, change: Reduced, by: float) -> Reduced:
        """Another design."""
        return Reduced(*(own + by * each for own, each in zip(self, change, strict=True)))

    def motion(self, lost: Lost, rates: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What vibrates, its velocities and its accelerations, each (n_t, m) in the basis; with the phases of other `rates` (m,) if there
        are some."""
        squares, turned = scipy.linalg.eigh(self.stiffness, self.mass)
        w = np.sqrt(squares)
        phases = np.exp(1j * np.outer(lost.passed, w if rates is None else rates))
        swung = lost.history * swing(w, *(self.pushes @ turned)) * phases
        q, v = np.real(swung), np.real(1j * w * swung)
        return q @ turned.T, v @ turned.T, -(q * w**2) @ turned.T


def derivatives_of_modes(solution: Solution, lost: Lost, at_peaks: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Derivatives of the modal coordinates, velocities and accelerations of what a kick excites, each (n_t, m, n_x).

    Parameters
    ----------
    at_peaks : bool
        Whether phases stay what they are: a peak, at whatever time it is, does not feel them.
    """
    modes, n_x = lost.modes, solution.system.n_x
    own = Reduced(np.diag(modes.rates**2), np.eye(len(modes.rates)), modes.pushes)
    changes, found = _changes(solution, lost.kick, modes), np.zeros((3, *lost.swings.shape, n_x))
    for x in range(n_x):
        change = Reduced(*(each[..., x] for each in changes))
        step = _step(own, change, float(np.abs(lost.passed).max(initial=0.0)))
        if step > 0:
            rates = modes.rates if at_peaks else None
            there, back = (own.moved(change, side * step).motion(lost, rates) for side in (1, -1))
            found[..., x] = (np.array(there) - np.array(back)) / (2 * step)
    return found[0], found[1], found[2]


def _step(own: Reduced, change: Reduced, time: float) -> float:
    """Change of the design that turns no phase, and changes no size, by more than `DESIGN_PHASE_CHANGE`; 0 where it does nothing."""
    w = np.sqrt(np.diag(own.stiffness))
    rates = np.abs(np.diag(change.stiffness) - w**2 * np.diag(change.mass)) / (2 * w)
    largest = np.abs(own.pushes).max()
    sizes = np.abs(change.pushes).max() / largest if largest > 0 else 0.0
    most = max(float((rates * time).max()), float((rates / w).max()), float(np.abs(change.mass).max()), float(sizes))
    return DESIGN_PHASE_CHANGE / most if most > 0 else 0.0


def _changes(solution: Solution, kick: Kick, modes: ExcitedModes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Derivatives of stiffness and mass (m, m, n_x), and of the modal accelerations (2, m, n_x), all in the basis of the modes."""
    system, shapes = solution.system, modes.shapes
    q = padded(solution, kick.state)[0]
    inputs, rest, n_q = system.inputs(solution.times[kick.state], FORCES), np.zeros(system.n), system.n_q
    at_rest = _by_design(solution, inputs, q, rest)
    stiffness, mass = [], []
    for shape in shapes.T:
        move = np.append(shape, np.zeros(system.n - n_q))
        far = MODE_AMPLITUDE / float((system.weights[: system.n_b] * np.abs(shape[: system.n_b])).max())
        there, back = (_by_design(solution, inputs, q + side * far * move, rest) for side in (1, -1))
        stiffness.append((there - back)[:n_q] / (2 * far))
        mass.append((_by_design(solution, inputs, q, far * move) - at_rest)[:n_q] / far)
    by_stiffness, by_mass = (np.einsum("qi,jqx->ijx", shapes, np.array(each)) for each in (stiffness, mass))
    pushed = np.einsum("qi,kqx->kix", modes.resisted, kick.changes[:, :n_q]) / modes.rates[:, None] ** 2
    return by_stiffness, by_mass, pushed + np.einsum("ijx,kj->kix", by_mass, modes.pushes)


def _by_design(solution: Solution, inputs: Inputs, q: np.ndarray, acc: np.ndarray) -> np.ndarray:
    """Partial derivatives of the residual (n, n_x)."""
    system = solution.system
    terms = system.evaluate(inputs, q, np.zeros(system.n), acc, design=True)
    found: np.ndarray = terms.I_x + terms.A_x
    return found
