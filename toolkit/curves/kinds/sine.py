"""A sine."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.curves.shapes.oscillation import Oscillation


class Sine(Oscillation):
    """f(t) = amplitude sin(2 pi frequency t + phase); frequency in 1/time, phase in rad."""

    kind = "sine"

    def rates(self, time: np.ndarray) -> tuple[Any, Any, Any]:
        """f, f', f'' at the times, from sine and cosine."""
        omega, cosine, sine = self.phasor(time)
        return sine, omega * cosine, -(omega**2) * sine
