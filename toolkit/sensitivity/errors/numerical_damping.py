"""What a scheme makes of a vibration, step by step: how much of it is left, and how far it is behind."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.solvers.transient.scheme import Scheme


def part_kept(scheme: Scheme, rates: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Part of the complex amplitude of modes (m,) that steps of some lengths (n,) keep, (n, m), its phase behind the true one."""
    phases = np.multiply.outer(lengths, rates)
    found: np.ndarray = root(scheme, phases) * np.exp(-1j * phases)
    return found


def amplification(scheme: Scheme, phase: Any) -> np.ndarray:
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


def root(scheme: Scheme, phase: Any) -> Any:
    """The eigenvalue of the amplification matrix that stays longest, with the phase of a step, by phases (...); no larger than one."""
    values = np.linalg.eigvals(amplification(scheme, phase)).astype(complex)
    forward = np.where(values.imag >= 0, np.abs(values), -1.0)
    found = np.take_along_axis(values, np.argmax(forward, axis=-1)[..., None], axis=-1)[..., 0]
    return found / np.maximum(np.abs(found), 1.0)


def error_after(scheme: Scheme, rate: float, step: float, time: float) -> float:
    """Error of a vibration of some angular frequency, by its phase and by what is damped away, after some time; 1 if all is wrong."""
    kept = root(scheme, rate * step) * np.exp(-1j * rate * step)
    return float(min(abs(kept ** (time / step) - 1), 1.0))
