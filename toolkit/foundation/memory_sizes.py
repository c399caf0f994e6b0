"""Sizes of memory: as options give them, and in messages."""

from __future__ import annotations

GIGABYTE = 1e9


def in_gigabytes(count: float) -> str:
    """A number of bytes for messages."""
    size = count / GIGABYTE
    return f"{size:.0f} GB" if size >= 1 else f"{size:.2g} GB"
