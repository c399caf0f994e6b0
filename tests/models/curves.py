"""One list of all kinds of time curves; a new kind is one new line."""

from __future__ import annotations

from toolkit.components.curves.catalogue import Curve
from toolkit.components.curves.combined import Product, Sequence, Sum
from toolkit.components.curves.oscillation import Harmonic, Sine
from toolkit.components.curves.polynomial import Constant, Polynomial
from toolkit.components.curves.rise import Cycloid, Ramp, SmoothStep
from toolkit.components.curves.table import Table

ROWS, VALUES = (0.0, 0.5, 1.1, 2.0), (0.0, 1.0, -2.0, 0.5)
RISING = (0.1, 0.4, 1.7, 1.9)

CURVES: dict[str, Curve] = {
    "constant": Constant(value=3.0),
    "smooth-step": SmoothStep(height=2.0, start=0.25, duration=1.5),
    "cycloid": Cycloid(height=-1.4, start=0.2, duration=1.3),
    "linear ramp": Ramp(initial=0.4, final=-1.0, start=0.3, end=1.2, smoothness="linear"),
    "cubic ramp": Ramp(initial=0.4, final=-1.0, start=0.3, end=1.2, smoothness="cubic"),
    "quintic ramp": Ramp(initial=0.4, final=-1.0, start=0.3, end=1.2),
    "polynomial": Polynomial(coefficients=(0.3, -1.1, 0.7, 0.2), start=0.6),
    "sine": Sine(amplitude=2.0, frequency=0.7, phase=0.3),
    "harmonic": Harmonic(offset=-0.8, amplitude=1.2, frequency=0.6, phase=0.4),
    "cubic table": Table(times=ROWS, values=VALUES),
    "monotone table": Table(times=ROWS, values=RISING, interpolation="monotone"),
    "linear table": Table(times=ROWS, values=VALUES, interpolation="linear"),
    "sum": Sum(terms=(Constant(value=1.0), Sine(frequency=2.0), SmoothStep(duration=2.0))),
    "product": Product(
        curve=Sine(frequency=0.9, phase=0.2), factors=(Ramp(final=0.7, end=1.4), Polynomial(coefficients=(0.4, 0.3)))
    ),
    "sequence": Sequence(
        curves=(
            Cycloid(height=0.8, duration=0.6),
            Constant(),
            Ramp(initial=0.8, final=0.0, start=0.05, end=0.9),
            Harmonic(frequency=1.0),
        ),
        times=(0.62, 0.8, 1.75),
    ),
}
"""What it is -> a curve without symmetries, whose corners lie between 0 and 2."""
ROUGH = {"linear ramp", "linear table"}
"""Those without second derivative."""


def built_in_curves() -> set[str]:
    """Names of all kinds that the toolkit brings."""
    return {name for name, kind in Curve.kinds.items() if kind.__module__.startswith("toolkit.")}
