"""A cycloidal rise, as of cams."""

from __future__ import annotations

from toolkit.curves.shapes.rise import cycloid
from toolkit.curves.shapes.rising import Rise


class Cycloid(Rise):
    """f(t) = height (u - sin(2 pi u) / (2 pi)), u = (t - start) / duration on [0, 1], 0 before and the height after.

    f' and f'' are zero at both ends; the largest slope is twice the mean one, height / duration.
    """

    kind = "cycloid"
    shape = staticmethod(cycloid)
