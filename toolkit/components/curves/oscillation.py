"""Oscillations about zero or about a mean value: curves of one frequency."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from toolkit.components.curves.curve import Curve, Rates
from toolkit.description.description import OF_OWNER, Number, Positive, Quantity


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

    def phasor(self, time: np.ndarray) -> Rates:
        """omega = 2 pi frequency, and amplitude cos and sin (omega t + phase)."""
        omega = 2 * np.pi * self.frequency
        angle = omega * time + self.phase
        return omega, self.amplitude * np.cos(angle), self.amplitude * np.sin(angle)

    def periods(self) -> tuple[float, ...]:
        """Period of the one oscillation, 1 / frequency."""
        return (1 / float(np.real(self.frequency)),)


class Sine(Oscillation):
    """f(t) = amplitude sin(2 pi frequency t + phase); frequency in 1/time, phase in rad."""

    kind = "sine"

    def rates(self, time: np.ndarray) -> Rates:
        """f, f', f'' at the times, from sine and cosine."""
        omega, cosine, sine = self.phasor(time)
        return sine, omega * cosine, -(omega**2) * sine


class Harmonic(Oscillation):
    """f(t) = offset + amplitude cos(2 pi frequency t + phase); frequency in 1/time, phase in rad.

    With the phase zero it is at rest at t = 0; with offset = -amplitude it begins at zero too.

    Attributes
    ----------
    offset
        Mean value.
    """

    kind = "harmonic"

    offset: Annotated[Number, OF_OWNER] = 0.0

    def rates(self, time: np.ndarray) -> Rates:
        """f, f', f'' at the times, from the offset, cosine and sine."""
        omega, cosine, sine = self.phasor(time)
        return self.offset + cosine, -omega * sine, -(omega**2) * cosine
