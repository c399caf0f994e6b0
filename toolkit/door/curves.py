"""Curves over time, which scale loads and lead drivers."""

from __future__ import annotations

from toolkit.description.profile import Constant, Sine, SmoothStep, Sum, Table

__all__ = [
    "Constant",
    "Sine",
    "SmoothStep",
    "Sum",
    "Table",
]
