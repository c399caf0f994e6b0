"""Lost part of the vibrations that a force excites, in every mode, relative to what the same force would excite at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.foundation.compiled.calls import call
from toolkit.foundation.kernel import kernel
from toolkit.sensitivity.errors.numerical_damping import part_kept
from toolkit.solvers.transient.scheme import generalized_alpha
from toolkit.system.solution import Solution

GONE, LIVES = 0.6, np.exp(-1)
"""Part of an amplitude that steps keep, from which on runs with other steps show the difference: at the end, or where damping has
left so much of it."""
EVEN = 1e-9
"""Part of a piece of a curve by which others may be longer and are as long: sixteen in a row turn a phase by no more."""
SHAKES = 1e-3
"""Lost amplitude, relative to the variation of a curve, above which the curve excites vibrations that count."""
LOOKED_FOR = np.geomspace(0.3, 30.0, 12)
"""Angular frequencies times step at which `shakes` examines a curve."""


class History(NamedTuple):
    """Values of a curve over time: instants (k,), with both sides of every corner, and its numbers there (k,)."""

    times: np.ndarray
    values: np.ndarray


class Pieces(NamedTuple):
    """Straight pieces of a curve in which it changes, after some instant.

    They have their middles, lengths and growth (k,), and the number of those before each step and before the end, (n_t,).
    """

    middle: np.ndarray
    length: np.ndarray
    growth: np.ndarray
    before: np.ndarray


def lost_parts(solution: Solution, history: History | None, begin: float, rates: np.ndarray, damping: np.ndarray) -> np.ndarray:
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


def _pieces(history: History | None, begin: float, times: np.ndarray) -> Pieces:
    """Straight pieces of a curve in which it changes; none without a curve."""
    if history is None:
        none = np.zeros(0)
        return Pieces(none, none, none, np.zeros(len(times), np.int64))
    growth = np.diff(history.values)
    middle, changes = (history.times[1:] + history.times[:-1]) / 2, growth != 0
    middle = middle[changes]
    before = np.searchsorted(middle, times, side="right")
    before[0], before[-1] = 0, len(middle)
    return Pieces(middle - begin, np.diff(history.times)[changes], growth[changes], before)


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
        if lasting >= GONE:
            continue
        x, y, kept_x, kept_y = at_once, 0.0, at_once, 0.0
        known, size, turn_x, turn_y, c, s = -1.0, 1.0, 1.0, 0.0, 1.0, 0.0
        for n in range(len(which)):
            grown_x, grown_y = 0.0, 0.0
            for k in range(before[n], before[n + 1]):
                alike = np.abs(length[k] - known) <= EVEN * length[k]
                if not alike:
                    known, half = length[k], rates[j] * length[k] / 2
                    size = np.sin(half) / half if half != 0 else 1.0
                    turn_x, turn_y = np.cos(2 * half), -np.sin(2 * half)
                if alike and k > before[n] and np.abs(middle[k] - middle[k - 1] - known) <= EVEN * known:
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


def shakes(solution: Solution, history: History) -> bool:
    """Whether a curve excites what steps take out, whatever it acts on."""
    rates = LOOKED_FOR / float(np.diff(solution.times).max())
    lost = lost_parts(solution, history, float(solution.times[0]), rates, np.zeros(len(rates)))
    return bool(np.abs(lost).max(initial=0.0) > SHAKES * np.ptp(history.values))
