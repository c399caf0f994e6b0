"""An oscillation about zero: base of kinds that differ in where they begin."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from toolkit.curves.curve import Curve
from toolkit.description.description import Number, Positive
from toolkit.description.quantity import OF_OWNER, Quantity


class Oscillation(Curve):
    """Base of curves of one frequency.

    Attributes
    ----------
    amplitude
        Largest distance from the mean value.
    frequency
        In 1/time.
    phase
        In rad.
    """

    amplitude: Annotated[Number, OF_OWNER] = 1.0
    frequency: Annotated[Positive, Quantity("1/time")]
    phase: Annotated[Number, Quantity("angle")] = 0.0

    def phasor(self, time: np.ndarray) -> tuple[Any, Any, Any]:
        """omega = 2 pi frequency, and amplitude cos and sin (omega t + phase)."""
        omega = 2 * np.pi * self.frequency
        angle = omega * time + self.phase
        return omega, self.amplitude * np.cos(angle), self.amplitude * np.sin(angle)

    def periods(self) -> tuple[float, ...]:
        """Period of the one oscillation, 1 / frequency."""
        return (1 / float(np.real(self.frequency)),)
