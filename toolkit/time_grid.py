"""The times of a run."""

from __future__ import annotations

import numpy as np

from toolkit.errors import InputError
from toolkit.run_options import RunOptions

MOST_STEPS = 100_000_000


def time_grid(options: RunOptions) -> np.ndarray:
    """Equal steps from 0 to the end time, (n_t,); the end is hit exactly, so the step is at most the one that was asked for.

    Raises
    ------
    InputError
        The step is larger than the end time, or so small that the states cannot be kept.
    """
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
