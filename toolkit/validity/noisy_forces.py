"""Joint forces that jump to and fro from step to step, while the motion still looks right."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from toolkit.run_options import RunOptions
from toolkit.solution import Solution
from toolkit.validity.verdict import Caution

NOISY = 0.03
"""Noise of a joint's force, a part of its largest one, above which forces are not to be trusted."""
SMALL = 1e-3
"""Forces of a joint below this part of the largest in the scene count as that."""
IN_A_ROW = 4
"""So many states in a row have to alternate: a load that jumps does it twice."""


def force_noise(solution: Solution) -> dict[str, Any]:
    """Amplitude that joint forces have at the shortest wave that steps can hold, of two steps.

        d_n = lam_n - (h_+ lam_(n-1) + h_- lam_(n+1)) / (h_- + h_+),   amplitude = min |d_n| / 2 of four neighbours with alternating signs

    Index 3 makes it where bodies turn too far in a step (see `toolkit.option_checks.DAMPED`), and round-off in tiny steps; a vibration
    that steps do not resolve looks the same.

    Parameters
    ----------
    solution : Solution
        Of `simulate`, with all its states.

    Returns
    -------
    noise : dict
        "size", a part of the largest force of the same joint, "where", the direction and the joint, and "time"; empty without joints.
    """
    system, first = solution.system, solution.system.n_q
    lengths, forces = np.diff(solution.times), {}
    for name, row in system.numbering.row.items():
        rows = slice(row, row + len(system.scene.joints[name].row_names))
        forces[row] = solution.multipliers[:, rows.start - first : rows.stop - first] / system.weights[rows]
    if not forces or len(lengths) <= IN_A_ROW:
        return {}
    largest, worst = max(np.abs(force).max() for force in forces.values()), {"size": 0.0, "where": "", "time": 0.0}
    for row, force in forces.items():
        noise, own = _amplitudes(force, lengths), max(np.abs(force).max(), SMALL * largest)
        step, column = np.unravel_index(int(np.argmax(noise)), noise.shape)
        if noise[step, column] > worst["size"] * own:
            where, time = system.numbering.names[row + int(column)], float(solution.times[step + 1])
            worst = {"size": float(noise[step, column] / own), "where": where, "time": time}
    return worst


def _amplitudes(force: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Amplitude from each inner state and the next three, (n_t - 5, rows), of forces (n_t, rows) after steps (n_t - 1,)."""
    before, after = lengths[:-1, None], lengths[1:, None]
    off = force[1:-1] - (after * force[:-2] + before * force[2:]) / (before + after)
    signs = np.where(np.arange(len(off)) % 2, -1.0, 1.0)[:, None]
    four = np.stack([(signs * off)[k : len(off) - IN_A_ROW + 1 + k] for k in range(IN_A_ROW)])
    return np.maximum(four.min(axis=0), (-four).min(axis=0)).clip(min=0) / 2


def noisy_forces(options: RunOptions, noise: Mapping[str, Any]) -> Iterator[Caution]:
    """Joint forces that alternate; the noise as `force_noise` gives it."""
    if not noise or noise["size"] <= NOISY:
        return
    better = f'solver.rho_inf (now {options.rho_inf:g}, 0.5 damps them), or solver.formulation = "ggl"'
    yield Caution(
        "noisy-forces",
        f"joint forces jump from step to step: {noise['where']} by {noise['size']:.1%} of that joint's largest force at t = "
        f"{noise['time']:g} (limit {NOISY:.0%}). Try a smaller solver.step, a smaller {better}.",
    )
