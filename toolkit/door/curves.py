"""Every kind of time curve: in the plane and in space the same."""

from __future__ import annotations

from toolkit.curves.kinds.constant import Constant
from toolkit.curves.kinds.cycloid import Cycloid
from toolkit.curves.kinds.harmonic import Harmonic
from toolkit.curves.kinds.polynomial import Polynomial
from toolkit.curves.kinds.product import Product
from toolkit.curves.kinds.ramp import Ramp
from toolkit.curves.kinds.sequence import Sequence
from toolkit.curves.kinds.sine import Sine
from toolkit.curves.kinds.smooth_step import SmoothStep
from toolkit.curves.kinds.sum import Sum
from toolkit.curves.kinds.table import Table

__all__ = [
    "Constant",
    "Cycloid",
    "Harmonic",
    "Polynomial",
    "Product",
    "Ramp",
    "Sequence",
    "Sine",
    "SmoothStep",
    "Sum",
    "Table",
]
