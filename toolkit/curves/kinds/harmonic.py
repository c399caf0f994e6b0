"""A harmonic about a mean value."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from toolkit.curves.shapes.oscillation import Oscillation
from toolkit.description.description import Number
from toolkit.description.quantity import OF_OWNER


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

    def rates(self, time: np.ndarray) -> tuple[Any, Any, Any]:
        """f, f', f'' at the times, from the offset, cosine and sine."""
        omega, cosine, sine = self.phasor(time)
        return self.offset + cosine, -omega * sine, -(omega**2) * cosine
