"""Curves of loads and drivers over time (paper, fig. 6)."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.foundation.units import unit
from toolkit.joints.joint import Joint
from toolkit.loads.planar.torque import Torque
from toolkit.render.sheet import sheet, style
from toolkit.report.drawing import Drawing
from toolkit.report.material import Material

MOST_DOTS = 100
"""Steps that are marked one by one."""


def load_curves(material: Material) -> list[Drawing]:
    """Every load and driver that follows a curve; planar torques as torques, other loads as the factor that the curve is."""
    scene = material.scene
    curved = {name: each for name, each in [*scene.loads.items(), *scene.joints.items()] if hasattr(each, "curve")}
    if not curved or not material.moving:
        return []
    times = np.linspace(material.solution.times[0], material.solution.times[-1], 401)
    with sheet(0.6 + 2.2 * len(curved), len(curved), sharex=True) as (figure, axes):
        for number, (panel, (name, part)) in enumerate(zip(axes[:, 0], curved.items(), strict=True)):
            scale, label = _scale(part, scene.units)
            panel.plot(times, scale * part.curve.evaluate(times)[:, 0], **style(number))
            steps = material.solution.times
            if len(steps) <= MOST_DOTS:
                panel.plot(steps, scale * part.curve.evaluate(steps)[:, 0], ".", color="black", markersize=4, label="time steps")
                panel.legend(loc="lower right")
            panel.set_ylabel(f"{name}: {label}")
        axes[-1, 0].set_xlabel(f"time in {unit(scene.units, 'time')}")
    return [Drawing("load_curves", "Loads over time", "What drives the motion.", figure)]


def _scale(part: Any, units: str) -> tuple[float, str]:
    if isinstance(part, Torque):
        return float(part.torque), f"torque in {unit(units, 'torque')}"
    if isinstance(part, Joint):
        row = part.constraint(None)[-1]  # which a curve is subtracted from
        return 1.0, f"{row.name} in {unit(units, row.quantity)}"
    return 1.0, "factor"
