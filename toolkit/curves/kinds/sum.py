"""A sum of curves."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import Field

from toolkit.curves.curve import Curve, Part
from toolkit.description.quantity import OF_OWNER


class Sum(Curve):
    """f(t) = sum of other curves.

    Attributes
    ----------
    terms
        The curves.
    """

    kind = "sum"

    terms: Annotated[tuple[Curve, ...], OF_OWNER] = Field(min_length=1)

    def rates(self, time: np.ndarray) -> tuple[Any, Any, Any]:
        """f, f', f'' at the times, the sums over all terms."""
        f, slope, curvature = (sum(each) for each in zip(*(term.rates(time) for term in self.terms), strict=True))
        return f, slope, curvature

    def corners(self) -> tuple[Any, ...]:
        """Times at which any term of the sum has a corner."""
        return tuple(corner for term in self.terms for corner in term.corners())

    def kink(self) -> str:
        """Sentence on the kink of the first term that has one, empty if none has."""
        return next(filter(None, (term.kink() for term in self.terms)), "")

    @property
    def is_constant(self) -> bool:
        """Whether all terms of the sum are constant."""
        return all(term.is_constant for term in self.terms)

    def periods(self) -> tuple[float, ...]:
        """Periods of the oscillations of all terms."""
        return tuple(period for term in self.terms for period in term.periods())

    def parts(self) -> tuple[Part, ...]:
        """Terms that the sum is made of."""
        return tuple(Part(f"terms.{n}", term) for n, term in enumerate(self.terms))
