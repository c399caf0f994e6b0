"""How much of the vibrations that a force excites is lost: of every mode, a part of what the same force would excite at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.sensitivity.errors.numerical_damping import part_kept
from toolkit.solvers.transient.scheme import generalized_alpha
from toolkit.system.solution import Solution

GONE, LIVES = 0.6, np.exp(-1)
"""Part of an amplitude that steps leave, from which on runs with other steps tell the difference: at the end, or where damping has left so
much of it."""
SHAKES = 1e-3
"""Part of its variation from which on a curve excites what counts."""
LOOKED_FOR = np.geomspace(0.3, 30.0, 12)
"""Angular frequencies times step at which a curve is asked whether it does."""


class History(NamedTuple):
    """What a curve does over time: instants (k,), with both sides of every corner, and its numbers there (k,)."""

    times: np.ndarray
    values: np.ndarray


def lost_parts(solution: Solution, history: History | None, begin: float, rates: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """What is lost at all times, (n_t, m), complex, of modes with angular frequencies and damping ratios (m,).

    Every growth dg of the curve within a step leaves a vibration that is a part dg of what a sudden one would, with its phase, which is
    zero at the time `begin`; without a curve the force is there at once. Of modes that last, nothing counts.
    """
    options, times = solution.options or solution.system.scene.solver, solution.times
    lengths = np.diff(times)
    keeps = part_kept(generalized_alpha(options.scheme, options.rho_inf), rates, lengths)
    fades = np.exp(-np.outer(lengths, rates * np.minimum(damping, 1.0)))
    lives = np.cumprod(np.vstack([np.ones(len(rates)), fades[:-1]]), axis=0) > LIVES
    counting = np.where(lives, np.abs(keeps), 1.0).prod(axis=0) < GONE
    if history is None:
        there, kept = (np.vstack([np.ones(len(rates)), np.cumprod(each, axis=0)]) for each in (fades, fades * keeps))
        return (there - kept).astype(complex) * counting
    there = np.zeros((len(times), len(rates)), complex)
    kept = there.copy()
    for n, grown in enumerate(_grown(history, begin, times, rates)):
        there[n + 1] = grown + fades[n] * there[n]
        kept[n + 1] = grown + fades[n] * keeps[n] * kept[n]
    return (there - kept) * counting


def shakes(solution: Solution, history: History) -> bool:
    """Whether a curve excites what steps take out, whatever it acts on."""
    rates = LOOKED_FOR / float(np.diff(solution.times).max())
    lost = lost_parts(solution, history, float(solution.times[0]), rates, np.zeros(len(rates)))
    return bool(np.abs(lost).max(initial=0.0) > SHAKES * np.ptp(history.values) > 0)


def _grown(history: History, begin: float, times: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Fourier integrals of a curve's slope over every step, with the phase zero at `begin`, (n_t - 1, m)."""
    middle, length = (history.times[1:] + history.times[:-1]) / 2, np.diff(history.times)
    phases = np.outer(middle - begin, rates)
    growth = np.diff(history.values)[:, None] * np.sinc(np.outer(length, rates) / (2 * np.pi)) * np.exp(-1j * phases)
    step = np.minimum(np.searchsorted(times, middle), len(times) - 1) - 1
    found = np.zeros((len(times) - 1, len(rates)), complex)
    np.add.at(found, step, growth)
    return found
