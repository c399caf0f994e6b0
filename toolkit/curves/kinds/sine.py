"""A sine."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from toolkit.curves.curve import Curve
from toolkit.description.description import Number, Positive
from toolkit.description.quantity import OF_OWNER, Quantity


class Sine(Curve):
    """f(t) = amplitude sin(2 pi frequency t + phase); frequency in 1/time, phase in rad.

    Attributes
    ----------
    amplitude
        Largest value.
    frequency
        In 1/time.
    phase
        In rad.
    """

    kind = "sine"

    amplitude: Annotated[Number, OF_OWNER] = 1.0
    frequency: Annotated[Positive, Quantity("1/time")]
    phase: Annotated[Number, Quantity("angle")] = 0.0

    def rates(self, time: np.ndarray) -> tuple[Any, Any, Any]:
        """Sine and cosine."""
        omega = 2 * np.pi * self.frequency
        angle = omega * time + self.phase
        sine = self.amplitude * np.sin(angle)
        return sine, self.amplitude * omega * np.cos(angle), -(omega**2) * sine

    def periods(self) -> tuple[float, ...]:
        """One."""
        return (1 / float(np.real(self.frequency)),)
