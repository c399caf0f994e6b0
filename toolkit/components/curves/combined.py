"""Curves that are made of other curves: sums, products, and curves one after the other."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from toolkit.components.curves.curve import Curve, CurvePart, Rates
from toolkit.description.description import OF_OWNER, Number, Quantity, Scalar


class Sum(Curve):
    """f(t) = sum of other curves.

    Attributes
    ----------
    terms
        The curves.
    """

    kind = "sum"

    terms: Annotated[tuple[Curve, ...], OF_OWNER] = Field(min_length=1)

    def rates(self, time: np.ndarray) -> Rates:
        """f, f', f'' at the times, the sums over all terms."""
        f, slope, curvature = (sum(each) for each in zip(*(term.rates(time) for term in self.terms), strict=True))
        return f, slope, curvature

    def corners(self) -> tuple[Scalar, ...]:
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

    def parts(self) -> tuple[CurvePart, ...]:
        """Terms that the sum is made of."""
        return tuple(CurvePart(f"terms.{n}", term) for n, term in enumerate(self.terms))


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

    def rates(self, time: np.ndarray) -> Rates:
        """f, f', f'' at the times by the product rule, f'' = g'' h + 2 g' h' + g h''."""
        g, g_1, g_2 = self.curve.rates(time)
        for factor in self.factors:
            h, h_1, h_2 = factor.rates(time)
            g, g_1, g_2 = g * h, g_1 * h + g * h_1, g_2 * h + 2 * g_1 * h_1 + g * h_2
        return g, g_1, g_2

    def corners(self) -> tuple[Scalar, ...]:
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

    def parts(self) -> tuple[CurvePart, ...]:
        """Curve and factors that the product is made of."""
        return CurvePart("curve", self.curve), *(CurvePart(f"factors.{n}", factor) for n, factor in enumerate(self.factors))


JOINED_SLOPE_TOLERANCE = 1e-9
"""Part of the largest slope by which two curves may differ where one follows the other: that is round-off of what a person writes."""


DEEPEST_SEQUENCE = 3
"""Sequences that may stand in each other: each takes four times as long as the one inside."""


class Sequence(Curve):
    """f(t) = f_k(t - t_k) + d_k from t_k on, until the next takes over: curves one after the other, each with a time of its own.

    Each goes on from the value that the one before has reached: d_k makes f continuous, so that a constant is a rest, and a step down
    leads back. The first counts from the beginning, with t_0 = 0 and d_0 = 0, the last without end. Where the slopes of two do not meet
    there is no second derivative, which a driver refuses. A derivative by a t_k is the mean of both sides where a time step, or a corner
    of the curve that ends there, hits it exactly.

    Attributes
    ----------
    curves
        The curves in their order.
    times
        When each but the first takes over, increasing: one less than there are curves.
    """

    kind = "sequence"

    curves: Annotated[tuple[Curve, ...], OF_OWNER] = Field(min_length=2)
    times: Annotated[tuple[Number, ...], Quantity("time")]

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if len(self.times) != len(self.curves) - 1:
            raise ValueError(
                f"{len(self.curves)} curves but {len(self.times)} times; give one time less than curves, when each but the first takes over"
            )
        if np.any(np.diff(np.real(self.times)) <= 0):
            raise ValueError("times must increase from curve to curve")
        if _depth(self) > DEEPEST_SEQUENCE:
            raise ValueError(
                f"sequences stand in each other more than {DEEPEST_SEQUENCE} deep; write one with all its curves one after the other"
            )
        return self

    def rates(self, time: np.ndarray) -> Rates:
        """f, f', f'' at the times, each from the curve whose turn it is."""
        turn = np.searchsorted(np.real(self.times), np.real(time), "right")
        turns = [np.flatnonzero(turn == k) for k in range(len(self.curves))]
        found = [
            curve.evaluate(time[mine] - start) + np.array([level, 0, 0])
            for curve, mine, start, level in zip(self.curves, turns, (0.0, *self.times), self._levels(), strict=True)
        ]
        f, slope, curvature = np.concatenate(found)[np.argsort(np.concatenate(turns))].T
        return f, slope, curvature

    def _levels(self) -> list[Scalar]:
        """Levels d_k that make every curve go on from the value before it."""
        levels: list[Scalar] = [0.0]
        starts = (0.0, *self.times)
        for k, (before, after) in enumerate(zip(self.curves[:-1], self.curves[1:], strict=True)):
            reached = before.evaluate(np.array([self.times[k] - starts[k]]))[0, 0]
            levels.append(levels[k] + reached - after.evaluate(np.array([0.0]))[0, 0])
        return levels

    def corners(self) -> tuple[Scalar, ...]:
        """Times at which curves take over, and the corners of each curve in its turn."""
        inner = (part.shift + corner for part in self.parts() for corner in _within(part))
        return tuple(sorted((*self.times, *inner), key=np.real))

    def kink(self) -> str:
        """Sentence on the first kink of a curve, or else on a jump of the slope between two curves; empty without either."""
        for curve in self.curves:
            if words := curve.kink():
                return words
        times = np.real(np.array(self.times))
        left, right = (np.real(self.evaluate(np.nextafter(times, side))[:, 1]) for side in (-np.inf, np.inf))
        spans = np.linspace(min(0.0, times[0]), times[-1] + np.ptp(np.append(times, 0.0)), 401)
        largest = np.abs(np.concatenate([left, right, np.real(self.evaluate(spans)[:, 1])])).max()
        left, right = (np.where(np.abs(each) > JOINED_SLOPE_TOLERANCE * largest, each, 0.0) for each in (left, right))
        for k in np.flatnonzero(np.abs(right - left) > JOINED_SLOPE_TOLERANCE * largest):
            return (
                f"a sequence has none where the slope jumps, from {left[k]:g} to {right[k]:g} at t = {times[k]:g}, where its curve "
                f"{k + 1} takes over from curve {k}: let both have the same slope there, such as none"
            )
        return ""

    @property
    def is_constant(self) -> bool:
        """Whether all curves of the sequence are constant."""
        return all(curve.is_constant for curve in self.curves)

    def periods(self) -> tuple[float, ...]:
        """Periods of the oscillations of all curves."""
        return tuple(period for curve in self.curves for period in curve.periods())

    def parts(self) -> tuple[CurvePart, ...]:
        """Curves of the sequence, each with its turn."""
        bounds = (-np.inf, *(float(np.real(time)) for time in self.times), np.inf)
        starts = (0.0, *self.times)
        return tuple(CurvePart(f"curves.{k}", curve, starts[k], bounds[k], bounds[k + 1]) for k, curve in enumerate(self.curves))


def _depth(curve: Curve) -> int:
    """Number of sequences that stand in each other."""
    return isinstance(curve, Sequence) + max((_depth(part.curve) for part in curve.parts()), default=0)


def _within(part: CurvePart) -> list[Scalar]:
    """Corners of a curve within its turn, in its own time."""
    return [corner for corner in part.curve.corners() if part.begin < np.real(part.shift + corner) < part.end]
