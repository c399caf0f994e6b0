"""Rises from one level to another: the shapes s(u) of u = (t - start) / duration, from 0 to 1, with s' and s''."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

Shape = Callable[[np.ndarray], tuple[Any, Any, Any]]


def linear(u: np.ndarray) -> tuple[Any, Any, Any]:
    """s = u: the slope jumps at both ends."""
    return u, 1.0, 0.0


def cubic(u: np.ndarray) -> tuple[Any, Any, Any]:
    """s = u^2 (3 - 2 u): the slope is zero at both ends."""
    return u**2 * (3 - 2 * u), 6 * u * (1 - u), 6 - 12 * u


def quintic(u: np.ndarray) -> tuple[Any, Any, Any]:
    """s = u^3 (10 - 15 u + 6 u^2): s' and s'' are zero at both ends."""
    return u**3 * (10 - 15 * u + 6 * u**2), 30 * u**2 * (1 - u) ** 2, 60 * u * (1 - u) * (1 - 2 * u)


def cycloid(u: np.ndarray) -> tuple[Any, Any, Any]:
    """s = u - sin(2 pi u) / (2 pi): s' and s'' are zero at both ends."""
    angle = 2 * np.pi * u
    return u - np.sin(angle) / (2 * np.pi), 1 - np.cos(angle), 2 * np.pi * np.sin(angle)


def risen(time: np.ndarray, start: Any, duration: Any, shape: Shape) -> tuple[Any, Any, Any]:
    """s, and its derivatives by time: 0 before the start, 1 after the duration."""
    begin, end = np.real(start), np.real(start + duration)
    inside = (np.real(time) > begin) & (np.real(time) < end)
    u = np.where(inside, (time - start) / duration, np.where(np.real(time) >= end, 1.0, 0.0))
    s, slope, curvature = shape(u)
    return s, inside * slope / duration, inside * curvature / duration**2
