"""A product of curves."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import Field

from toolkit.curves.curve import Curve, Part
from toolkit.description.quantity import OF_OWNER, Quantity


class Product(Curve):
    """f(t) = g(t) h_1(t) h_2(t) ...: a curve, and factors without unit, as of a vibration that is switched on.

    Attributes
    ----------
    curve
        g, in the unit that the values of the whole have.
    factors
        h_1, h_2, ...: curves whose values are pure numbers.
    """

    kind = "product"

    curve: Annotated[Curve, OF_OWNER]
    factors: Annotated[tuple[Curve, ...], Quantity("none")] = Field(min_length=1)

    def rates(self, time: np.ndarray) -> tuple[Any, Any, Any]:
        """f, f', f'' at the times by the product rule, f'' = g'' h + 2 g' h' + g h''."""
        g, g_1, g_2 = self.curve.rates(time)
        for factor in self.factors:
            h, h_1, h_2 = factor.rates(time)
            g, g_1, g_2 = g * h, g_1 * h + g * h_1, g_2 * h + 2 * g_1 * h_1 + g * h_2
        return g, g_1, g_2

    def corners(self) -> tuple[Any, ...]:
        """Times at which any factor of the product has a corner."""
        return tuple(corner for part in self.parts() for corner in part.curve.corners())

    def kink(self) -> str:
        """Sentence on the kink of the first factor that has one, empty if none has."""
        return next(filter(None, (part.curve.kink() for part in self.parts())), "")

    @property
    def is_constant(self) -> bool:
        """Whether all factors of the product are constant."""
        return all(part.curve.is_constant for part in self.parts())

    def periods(self) -> tuple[float, ...]:
        """Periods of the oscillations of all factors."""
        return tuple(period for part in self.parts() for period in part.curve.periods())

    def parts(self) -> tuple[Part, ...]:
        """Curve and factors that the product is made of."""
        return Part("curve", self.curve), *(Part(f"factors.{n}", factor) for n, factor in enumerate(self.factors))
