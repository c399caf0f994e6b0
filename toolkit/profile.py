"""Time curves, with exact derivatives by time; they scale loads and lead drivers.

A curve's parameters may be complex (the complex step of the design derivatives); time is real.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from toolkit.description import Description, Number, Positive
from toolkit.errors import InputError


class Constant(Description):
    """f(t) = value.

    Attributes
    ----------
    value
        Value at all times.
    """

    type: Literal["constant"] = "constant"
    value: Number = 1.0

    def evaluate(self, time: np.ndarray) -> np.ndarray:
        """f, f', f'' at the times, shape (n_t, 3)."""
        return np.stack([np.full(len(time), self.value), 0 * time, 0 * time], axis=1)


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
    height: Number = 1.0
    start: Number = 0.0
    duration: Positive = 1.0

    def evaluate(self, time: np.ndarray) -> np.ndarray:
        """f, f', f'' at the times, shape (n_t, 3)."""
        u = (time - self.start) / self.duration
        inside = (u.real > 0) & (u.real < 1)
        u = np.where(inside, u, np.where(u.real >= 1, 1.0, 0.0))
        rates = [u**3 * (10 - 15 * u + 6 * u**2), 30 * u**2 * (1 - u) ** 2, 60 * u * (1 - u) * (1 - 2 * u)]
        return self.height * np.stack([rate / self.duration**k for k, rate in enumerate(rates)], axis=1)


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
    amplitude: Number = 1.0
    frequency: Positive
    phase: Number = 0.0

    def evaluate(self, time: np.ndarray) -> np.ndarray:
        """f, f', f'' at the times, shape (n_t, 3)."""
        omega = 2 * np.pi * self.frequency
        angle = omega * time + self.phase
        return self.amplitude * np.stack([np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle)], axis=1)


class Table(Description):
    """f(t) through given points: cubic spline (f'' continuous) or straight lines; constant outside.

    Straight lines have no second derivative at their corners and are refused as the curve of a driver. The cubic's slope is zero at
    both ends, so that it joins the constants outside without a jump in f'. Values can be design variables, times cannot.

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
    times: tuple[Number, ...] = Field(min_length=2)
    values: tuple[Number, ...]
    interpolation: Literal["cubic", "linear"] = "cubic"

    @model_validator(mode="after")
    def _ordered(self) -> Table:
        if len(self.times) != len(self.values):
            raise ValueError(f"{len(self.times)} times but {len(self.values)} values; give as many of each")
        if np.any(np.diff(self.times) <= 0):
            raise ValueError("times must increase from row to row")
        return self

    def evaluate(self, time: np.ndarray) -> np.ndarray:
        """f, f', f'' at the times, shape (n_t, 3).

        Raises
        ------
        InputError
            A time of the table is complex: a design variable.
        """
        if np.iscomplexobj(np.array(self.times)):
            raise InputError("the times of a table cannot be design variables; make its values design variables instead.")
        values = np.array(self.values)
        t = np.clip(time, self.times[0], self.times[-1])
        inside = (time > self.times[0]) & (time < self.times[-1])
        if self.interpolation == "linear":
            k = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(values) - 2)
            x = np.array(self.times)
            slope = (values[k + 1] - values[k]) / (x[k + 1] - x[k])
            return np.stack([values[k] + slope * (t - x[k]), slope * inside, 0 * t], axis=1)
        from scipy.interpolate import CubicSpline  # a quarter of a second, for tables alone

        spline = CubicSpline(self.times, values, bc_type="clamped")
        return np.stack([spline(t), spline(t, 1) * inside, spline(t, 2) * inside], axis=1)


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
