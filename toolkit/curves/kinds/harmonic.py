"""A harmonic about a mean value."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from toolkit.curves.curve import Curve
from toolkit.description.description import Number, Positive
from toolkit.description.quantity import OF_OWNER, Quantity


class Harmonic(Curve):
    """f(t) = offset + amplitude cos(2 pi frequency t + phase); frequency in 1/time, phase in rad.

    With the phase zero it is at rest at t = 0; with offset = -amplitude it begins at zero too.

    Attributes
    ----------
    offset
        Mean value.
    amplitude
        Largest distance from it.
    frequency
        In 1/time.
    phase
        In rad.
    """

    kind = "harmonic"

    offset: Annotated[Number, OF_OWNER] = 0.0
    amplitude: Annotated[Number, OF_OWNER] = 1.0
    frequency: Annotated[Positive, Quantity("1/time")]
    phase: Annotated[Number, Quantity("angle")] = 0.0

    def rates(self, time: np.ndarray) -> tuple[Any, Any, Any]:
        """Offset, cosine and sine."""
        omega = 2 * np.pi * self.frequency
        angle = omega * time + self.phase
        cosine = self.amplitude * np.cos(angle)
        return self.offset + cosine, -self.amplitude * omega * np.sin(angle), -(omega**2) * cosine

    def periods(self) -> tuple[float, ...]:
        """One."""
        return (1 / float(np.real(self.frequency)),)
