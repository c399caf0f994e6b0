"""Rises from one level to another: the shapes s(u) of u = (t - start) / duration, from 0 to 1, with s' and s'', and curves of them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import model_validator

from toolkit.components.curves.curve import Curve, Rates
from toolkit.description.description import OF_OWNER, Number, Positive, Quantity, Scalar

Shape = Callable[[np.ndarray], Rates]


def linear(u: np.ndarray) -> Rates:
    """s = u: the slope jumps at both ends."""
    return u, 1.0, 0.0


def cubic(u: np.ndarray) -> Rates:
    """s = u^2 (3 - 2 u): the slope is zero at both ends."""
    return u**2 * (3 - 2 * u), 6 * u * (1 - u), 6 - 12 * u


def quintic(u: np.ndarray) -> Rates:
    """s = u^3 (10 - 15 u + 6 u^2): s' and s'' are zero at both ends."""
    return u**3 * (10 - 15 * u + 6 * u**2), 30 * u**2 * (1 - u) ** 2, 60 * u * (1 - u) * (1 - 2 * u)


def cycloid(u: np.ndarray) -> Rates:
    """s = u - sin(2 pi u) / (2 pi): s' and s'' are zero at both ends."""
    angle = 2 * np.pi * u
    return u - np.sin(angle) / (2 * np.pi), 1 - np.cos(angle), 2 * np.pi * np.sin(angle)


def risen(time: np.ndarray, start: Scalar, duration: Scalar, shape: Shape) -> Rates:
    """s, and its derivatives by time: 0 before the start, 1 after the duration."""
    begin, end = np.real(start), np.real(start + duration)
    inside = (np.real(time) > begin) & (np.real(time) < end)
    u = np.where(inside, (time - start) / duration, np.where(np.real(time) >= end, 1.0, 0.0))
    s, slope, curvature = shape(u)
    return s, inside * slope / duration, inside * curvature / duration**2


class Rise(Curve):
    """f(t) = height s(u), u = (t - start) / duration on [0, 1], 0 before and the height after.

    Attributes
    ----------
    height
        Value after the rise.
    start
        Time at which it begins.
    duration
        Time that it takes.
    """

    height: Annotated[Number, OF_OWNER] = 1.0
    start: Annotated[Number, Quantity("time")] = 0.0
    duration: Annotated[Positive, Quantity("time")] = 1.0

    @staticmethod
    @abstractmethod
    def shape(u: np.ndarray) -> Rates:
        """Shape s of the rise with s', s'' at u, one of the formulas of `rise`."""

    def rates(self, time: np.ndarray) -> Rates:
        """f, f', f'' at the times: the height times s and its derivatives by time."""
        s, slope, curvature = risen(time, self.start, self.duration, self.shape)
        return self.height * s, self.height * slope, self.height * curvature

    def corners(self) -> tuple[Scalar, ...]:
        """Times of the start and the end of the rise, where a derivative jumps."""
        return self.start, self.start + self.duration


class SmoothStep(Rise):
    """f(t) = height s(u), u = (t - start) / duration, s = u^3 (10 - 15 u + 6 u^2) on [0, 1], 0 before and 1 after."""

    kind = "smooth-step"
    shape = staticmethod(quintic)


class Cycloid(Rise):
    """f(t) = height (u - sin(2 pi u) / (2 pi)), u = (t - start) / duration on [0, 1], 0 before and the height after.

    f' and f'' are zero at both ends; the largest slope is twice the mean one, height / duration.
    """

    kind = "cycloid"
    shape = staticmethod(cycloid)


_SHAPES: dict[str, Shape] = {"linear": linear, "cubic": cubic, "quintic": quintic}


class Ramp(Curve):
    """f(t) = initial + (final - initial) s(u), u = (t - start) / (end - start) on [0, 1]; constant before and after.

    s = u (linear: the slope jumps at both ends, which a driver refuses), u^2 (3 - 2 u) (cubic: f'' jumps there), or
    u^3 (10 - 15 u + 6 u^2) (quintic: f'' is continuous). A derivative by the start or the end is the mean of both sides where a time step
    hits it exactly.

    Attributes
    ----------
    initial
        Value before the ramp.
    final
        Value after it.
    start
        Time at which it begins.
    end
        Time at which it ends.
    smoothness
        Between both.
    """

    kind = "ramp"

    initial: Annotated[Number, OF_OWNER] = 0.0
    final: Annotated[Number, OF_OWNER] = 1.0
    start: Annotated[Number, Quantity("time")] = 0.0
    end: Annotated[Number, Quantity("time")] = 1.0
    smoothness: Literal["linear", "cubic", "quintic"] = "quintic"

    @model_validator(mode="after")
    def _forwards(self) -> Self:
        if not np.real(self.end) > np.real(self.start):
            raise ValueError(
                f"end = {np.real(self.end):g} is not after start = {np.real(self.start):g}; times of a ramp increase, its values may fall"
            )
        return self

    def rates(self, time: np.ndarray) -> Rates:
        """f, f', f'' at the times of the ramp from the initial to the final value."""
        s, slope, curvature = risen(time, self.start, self.end - self.start, _SHAPES[self.smoothness])
        height = self.final - self.initial
        return self.initial + height * s, height * slope, height * curvature

    def corners(self) -> tuple[Scalar, ...]:
        """Start and end of the ramp: the slope jumps there, or the second or third derivative."""
        return self.start, self.end

    def kink(self) -> str:
        """Sentence on the kinks of a linear ramp, empty for smoother ones."""
        return "a linear ramp has none at its ends: use smoothness = 'cubic' or 'quintic'" if self.smoothness == "linear" else ""
