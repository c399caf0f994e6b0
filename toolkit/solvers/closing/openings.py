"""Gaps of rows of joints, in the units in which they measure, for messages."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.units import unit
from toolkit.system.system import System


def opening(system: System, row: int, violation: float) -> float:
    """Gap of a constraint, a length or an angle, where it is violated by so much.

    The constraint is given by its number among all unknowns.
    """
    name, within = joint_of(system, row)
    return (
        violation if name is None else float(system.scene.joints[name].opening(system.scene, within, float(np.real(violation))))
    )


def joint_of(system: System, row: int) -> tuple[str | None, int]:
    """Joint that a constraint belongs to, and which of its rows it is; None for the length of a quaternion."""
    for name, first in system.numbering.row.items():
        if first <= row < first + len(system.scene.joints[name].rows):
            return name, row - first
    return None, 0


def label(system: System, row: int) -> str:
    """Unit in which a constraint is open: that of lengths, or rad."""
    name, within = joint_of(system, row)
    if name is None:
        return ""
    return unit(system.scene.units, system.scene.joints[name].rows[within][1])


def told(system: System, row: int, violation: float) -> str:
    """Text of the gap of a constraint, with its unit."""
    return f"{opening(system, row, violation):.3g} {label(system, row)}".rstrip()
