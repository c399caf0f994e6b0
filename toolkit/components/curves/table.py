"""A table of values, with cubics or straight lines between its rows."""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from toolkit.components.curves.curve import Curve, Rates
from toolkit.description.description import OF_OWNER, Number, Quantity, Scalar


def cubic_slopes(width: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Slopes m of the cubic spline at its corners, (n,), from widths h and mean slopes s of its pieces, (n - 1,).

    f'' is continuous:  m_(k-1) / h_(k-1) + 2 (1 / h_(k-1) + 1 / h_k) m_k + m_(k+1) / h_k = 3 (s_(k-1) / h_(k-1) + s_k / h_k)
    """
    from scipy.linalg import solve_banded  # for tables alone

    m = np.zeros(len(width) + 1, np.result_type(width, slope))
    if len(m) > 2:
        bands = np.zeros((3, len(m) - 2), width.dtype)
        bands[0, 1:], bands[1], bands[2, :-1] = 1 / width[1:-1], 2 / width[:-1] + 2 / width[1:], 1 / width[1:-1]
        m[1:-1] = solve_banded((1, 1), bands, 3 * (slope[:-1] / width[:-1] + slope[1:] / width[1:]))
    return m


def monotone_slopes(width: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Slopes m of Fritsch and Butland, with which the cubics rise where the rows rise and turn at rows only; arguments as `cubic_slopes`.

        (w_1 + w_2) / m_k = w_1 / s_(k-1) + w_2 / s_k,     w_1 = 2 h_k + h_(k-1),  w_2 = h_k + 2 h_(k-1),
        m_k = 0 where s changes its sign

    Where s becomes zero, m has a kink: its derivative there is the mean of both sides.
    """
    m = np.zeros(len(width) + 1, np.result_type(width, slope))
    before, after = slope[:-1], slope[1:]
    w_1, w_2 = 2 * width[1:] + width[:-1], width[1:] + 2 * width[:-1]
    below = w_1 * after + w_2 * before
    turning, flat = before.real * after.real < 0, (before.real == 0) & (after.real == 0)
    share = np.where(turning | flat, 0.0, np.where(before.real * after.real == 0, 0.5, 1.0))
    m[1:-1] = share * (w_1 + w_2) * before * after / np.where(turning | flat, 1.0, below)
    return m


class Table(Curve):
    """f(t) through given points: cubic spline (f'' continuous), monotone cubics (f' continuous, never beyond the values beside), or
    straight lines; constant outside.

    Straight lines have no second derivative at their corners and are refused as the curve of a driver. Of both cubics the slope is zero at
    both ends, so that they join the constants outside without a jump in f'. A derivative by a time of the table is the mean of both sides
    where a time step hits that corner exactly; so is that of monotone cubics by values that are equal to their neighbours.

    Attributes
    ----------
    times
        Times of the points, increasing.
    values
        As many values.
    interpolation
        Between the points.
    """

    kind = "table"

    times: Annotated[tuple[Number, ...], Quantity("time")] = Field(min_length=2)
    values: Annotated[tuple[Number, ...], OF_OWNER]
    interpolation: Literal["cubic", "monotone", "linear"] = "cubic"

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if len(self.times) != len(self.values):
            raise ValueError(f"{len(self.times)} times but {len(self.values)} values; give as many of each")
        if np.any(np.diff(self.times) <= 0):
            raise ValueError("times must increase from row to row")
        return self

    def rates(self, time: np.ndarray) -> Rates:
        """f = f_k + d (m_k + d (b + d c)) with d = t - t_k between points k and k + 1."""
        corners, values = np.array(self.times), np.array(self.values)
        width, slope = np.diff(corners), np.diff(values) / np.diff(corners)
        first, b, c = self._cubics(width, slope)
        place = np.searchsorted(corners.real, np.real(time), "right")
        inside, k = (place > 0) & (place < len(corners)), np.clip(place - 1, 0, len(width) - 1)
        d = np.where(inside, time - corners[k], 0)
        f = values[k] + d * (first[k] + d * (b[k] + d * c[k]))
        f = np.where(place == len(corners), values[-1], f)
        return f, inside * (first[k] + d * (2 * b[k] + 3 * d * c[k])), inside * (2 * b[k] + 6 * d * c[k])

    def _cubics(self, width: np.ndarray, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Slope, and coefficients of the second and third power, at the beginning of each piece."""
        if self.interpolation == "linear":
            return slope, np.zeros_like(slope), np.zeros_like(slope)
        m = (cubic_slopes if self.interpolation == "cubic" else monotone_slopes)(width, slope)
        return m[:-1], (3 * slope - 2 * m[:-1] - m[1:]) / width, (m[:-1] + m[1:] - 2 * slope) / width**2

    def corners(self) -> tuple[Scalar, ...]:
        """Times of the points: the slope jumps at those of straight lines, a higher derivative at those of cubics."""
        return self.times

    def kink(self) -> str:
        """Sentence on the kinks of a table of straight lines, empty for cubics."""
        straight = self.interpolation == "linear"
        return "a table of straight lines has none at its rows: use interpolation = 'cubic' or 'monotone'" if straight else ""
