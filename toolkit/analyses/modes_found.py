"""Frequencies and shapes of modes, and what speaks against them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.foundation.verdict import Verdict


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
