"""Time curves, with exact derivatives by time; they scale loads and lead drivers.

A curve's parameters may be complex (the complex step of the design derivatives); time is real.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from toolkit.description.description import Description, Number, Positive
from toolkit.description.quantity import OF_OWNER, Quantity


class Constant(Description):
    """f(t) = value.

    Attributes
    ----------
    value
        Value at all times.
    """

    type: Literal["constant"] = "constant"
    value: Annotated[Number, OF_OWNER] = 1.0

    def evaluate(self, time: np.ndarray) -> np.ndarray:
        """f, f', f'' at the times, shape (n_t, 3)."""
        return np.stack([np.full(len(time), self.value), 0 * time, 0 * time], axis=1)

    def corners(self) -> tuple[Any, ...]:
        """None."""
        return ()


class SmoothStep(Description):
    """f(t) = height s(u), u = (t - start) / duration, s = u^3 (10 - 15 u + 6 u^2) on [0, 1], 0 before and 1 after.

    Attributes
    ----------
    height
        Value after the step.
    start
        Time at which it begins.
    duration
        Time that it takes.
    """

    type: Literal["smooth-step"] = "smooth-step"
    height: Annotated[Number, OF_OWNER] = 1.0
    start: Annotated[Number, Quantity("time")] = 0.0
    duration: Annotated[Positive, Quantity("time")] = 1.0

    def evaluate(self, time: np.ndarray) -> np.ndarray:
        """f, f', f'' at the times, shape (n_t, 3)."""
        u = (time - self.start) / self.duration
        inside = (u.real > 0) & (u.real < 1)
        u = np.where(inside, u, np.where(u.real >= 1, 1.0, 0.0))
        rates = [u**3 * (10 - 15 * u + 6 * u**2), 30 * u**2 * (1 - u) ** 2, 60 * u * (1 - u) * (1 - 2 * u)]
        return self.height * np.stack([rate / self.duration**k for k, rate in enumerate(rates)], axis=1)

    def corners(self) -> tuple[Any, ...]:
        """Times where the third derivative jumps."""
        return self.start, self.start + self.duration


class Sine(Description):
    """f(t) = amplitude sin(2 pi frequency t + phase); frequency in 1/time, phase in rad.

    Attributes
    ----------
    amplitude
        Largest value.
    frequency
        In 1/time.
    phase
        In rad.
    """

    type: Literal["sine"] = "sine"
    amplitude: Annotated[Number, OF_OWNER] = 1.0
    frequency: Annotated[Positive, Quantity("1/time")]
    phase: Annotated[Number, Quantity("angle")] = 0.0

    def evaluate(self, time: np.ndarray) -> np.ndarray:
        """f, f', f'' at the times, shape (n_t, 3)."""
        omega = 2 * np.pi * self.frequency
        angle = omega * time + self.phase
        return self.amplitude * np.stack([np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle)], axis=1)

    def corners(self) -> tuple[Any, ...]:
        """None."""
        return ()


class Table(Description):
    """f(t) through given points: cubic spline (f'' continuous) or straight lines; constant outside.

    Straight lines have no second derivative at their corners and are refused as the curve of a driver. The cubic's slope is zero at
    both ends, so that it joins the constants outside without a jump in f'. A derivative by a time of the table is the mean of both sides
    where a time step hits that corner exactly.

    Attributes
    ----------
    times
        Times of the points, increasing.
    values
        As many values.
    interpolation
        Between the points.
    """

    type: Literal["table"] = "table"
    times: Annotated[tuple[Number, ...], Quantity("time")] = Field(min_length=2)
    values: Annotated[tuple[Number, ...], OF_OWNER]
    interpolation: Literal["cubic", "linear"] = "cubic"

    @model_validator(mode="after")
    def _ordered(self) -> Table:
        if len(self.times) != len(self.values):
            raise ValueError(f"{len(self.times)} times but {len(self.values)} values; give as many of each")
        if np.any(np.diff(self.times) <= 0):
            raise ValueError("times must increase from row to row")
        return self

    def evaluate(self, time: np.ndarray) -> np.ndarray:
        """f, f', f'' at the times, shape (n_t, 3); f = f_k + d (m_k + d (b + d c)) with d = t - t_k between points k and k + 1.

        At a corner it is the mean of both sides, which only derivatives by the table's numbers can tell apart.
        """
        corners, values = np.array(self.times), np.array(self.values)
        width, slope = np.diff(corners), np.diff(values) / np.diff(corners)
        m = corner_slopes(width, slope) if self.interpolation == "cubic" else None
        b = np.zeros_like(slope) if m is None else (3 * slope - 2 * m[:-1] - m[1:]) / width
        c = np.zeros_like(slope) if m is None else (m[:-1] + m[1:] - 2 * slope) / width**2
        first = slope if m is None else m[:-1]
        inside = (time > corners[0].real) & (time < corners[-1].real)
        sides = []
        for place in (np.searchsorted(corners.real, time, side) for side in ("left", "right")):
            k = np.clip(place - 1, 0, len(width) - 1)
            d = np.where(place == len(corners), width[-1], np.where(place > 0, time - corners[k], 0))
            rates = [first[k] + d * (2 * b[k] + 3 * d * c[k]), 2 * b[k] + 6 * d * c[k]]
            sides.append([values[k] + d * (first[k] + d * (b[k] + d * c[k])), rates[0] * inside, rates[1] * inside])
        return (np.stack(sides[0], axis=1) + np.stack(sides[1], axis=1)) / 2

    def corners(self) -> tuple[Any, ...]:
        """Times of the points: the slope jumps at those of straight lines, the third derivative at those of a cubic."""
        return self.times


def corner_slopes(width: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Slopes m of the cubic spline at its corners, zero at both ends, (n,), from widths h and mean slopes s of its pieces, (n - 1,).

    f'' is continuous:  m_(k-1) / h_(k-1) + 2 (1 / h_(k-1) + 1 / h_k) m_k + m_(k+1) / h_k = 3 (s_(k-1) / h_(k-1) + s_k / h_k)
    """
    from scipy.linalg import solve_banded  # for tables alone

    m = np.zeros(len(width) + 1, np.result_type(width, slope))
    if len(m) > 2:
        bands = np.zeros((3, len(m) - 2), width.dtype)
        bands[0, 1:], bands[1], bands[2, :-1] = 1 / width[1:-1], 2 / width[:-1] + 2 / width[1:], 1 / width[1:-1]
        m[1:-1] = solve_banded((1, 1), bands, 3 * (slope[:-1] / width[:-1] + slope[1:] / width[1:]))
    return m


class Sum(Description):
    """f(t) = sum of other curves.

    Attributes
    ----------
    terms
        The curves.
    """

    type: Literal["sum"] = "sum"
    terms: tuple[Curve, ...] = Field(min_length=1)

    def evaluate(self, time: np.ndarray) -> np.ndarray:
        """f, f', f'' at the times, shape (n_t, 3)."""
        return np.sum([term.evaluate(time) for term in self.terms], axis=0)

    def corners(self) -> tuple[Any, ...]:
        """Those of all terms."""
        return tuple(corner for term in self.terms for corner in term.corners())


Curve = Annotated[Constant | SmoothStep | Sine | Table | Sum, Field(discriminator="type")]
Sum.model_rebuild()
CURVES: dict[str, type[Description]] = {
    kind.model_fields["type"].default: kind for kind in (Constant, SmoothStep, Sine, Table, Sum)
}
"""Every kind of curve by the name that a file gives it."""


def is_smooth(curve: Constant | SmoothStep | Sine | Table | Sum) -> bool:
    """Whether f'' exists everywhere, as a driver needs it."""
    if isinstance(curve, Sum):
        return all(is_smooth(term) for term in curve.terms)
    return not (isinstance(curve, Table) and curve.interpolation == "linear")
