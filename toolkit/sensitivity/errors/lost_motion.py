"""Motion of the vibrations that steps take out, by the linearised modes.

A force that grows by dg at once leaves in the mode i, of the angular frequency w and unit mass, beside what follows the load

    -dg (a_i / w^2) exp(i w t - zeta w t),    a_i the modal acceleration by the whole force,

and one that grows slowly the sum of these, with their phases. Of each the scheme keeps the part (z exp(-i w h))^n after n
steps, z being the largest eigenvalue of its amplification matrix at w h.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from toolkit.sensitivity.errors.excited_modes import ExcitedModes, excited_modes
from toolkit.sensitivity.errors.kicks import FORCES, Kick, padded
from toolkit.sensitivity.errors.lost_parts import lost_parts
from toolkit.system.solution import Solution

SLOW = 0.5
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
    modes = excited_modes(system, terms, kick.jumps, SLOW / float(np.diff(solution.times)[kick.state]))
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
