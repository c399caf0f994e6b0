"""The times of a run."""

from __future__ import annotations

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError

MOST_STEPS = 100_000_000
EQUAL = 1e-9
"""Relative difference of step lengths that is round-off of the times."""


def time_grid(options: RunOptions) -> np.ndarray:
    """Given times, or equal steps from 0 to the end time, (n_t,).

    The end is hit exactly, so equal steps are at most as long as the one that was asked for. A run with error control chooses its times
    as it goes; this is the coarsest that it could choose.

    Raises
    ------
    InputError
        The step is larger than the end time, or so small that the states cannot be kept.
    """
    if options.times is not None:
        return np.array(options.times, float)
    steps = np.ceil(options.end_time / options.step * (1 - 1e-9))
    if options.step > options.end_time * (1 + 1e-9):
        raise InputError(
            f"solver.step = {options.step:g} is larger than solver.end_time = {options.end_time:g}. "
            "Choose a step that resolves the motion, for example a twentieth of the load's rise time."
        )
    if steps > MOST_STEPS:
        raise InputError(
            f"solver.step = {options.step:g} makes {steps:.3g} steps until solver.end_time = {options.end_time:g}, more than can be "
            f"kept ({MOST_STEPS:g}). Choose a larger step or a shorter time."
        )
    return np.linspace(0.0, options.end_time, int(steps) + 1)


def step_lengths(times: np.ndarray) -> np.ndarray:
    """Lengths of all steps, (n_t - 1,); exactly the same ones if they differ by round-off only."""
    lengths = np.diff(times)
    return np.full_like(lengths, lengths[0]) if np.all(np.abs(lengths - lengths[0]) <= EQUAL * lengths[0]) else lengths
