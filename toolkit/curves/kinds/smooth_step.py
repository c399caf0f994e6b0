"""A smooth step of a polynomial."""

from __future__ import annotations

from toolkit.curves.shapes.rise import quintic
from toolkit.curves.shapes.rising import Rise


class SmoothStep(Rise):
    """f(t) = height s(u), u = (t - start) / duration, s = u^3 (10 - 15 u + 6 u^2) on [0, 1], 0 before and 1 after."""

    kind = "smooth-step"
    shape = staticmethod(quintic)
