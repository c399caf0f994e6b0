"""The numbers of the moving picture in the page: lines, rods and colours of every frame."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import colormaps

from toolkit.foundation.units import unit
from toolkit.render.colors import TARGET
from toolkit.render.plane.configuration import Configuration
from toolkit.render.plane.parts import outlines
from toolkit.render.plane.skin_shape import POINTS, skin_shape
from toolkit.render.plane.window import window
from toolkit.render.sheet import SIGNED, symmetric
from toolkit.report.material import Material

EVERY = (POINTS - 1) // 4
"""Points of the middle line that are skipped: a quarter of an element is shorter than a pixel is wide."""


def viewer_data(material: Material) -> dict[str, Any]:
    """Frames as lists of numbers, rounded to a ten-thousandth of the scene.

    Each frame: time; per skin its points x, y and the stress of its outer fibre; per meshed body its closed lines; rods and links as
    x, y, x, y.
    """
    moments = [material.moment(step) for step in material.shown]
    corners = window(material.look.points)
    limit = symmetric([body.stress for body in material.results.bodies.values()]).vmax if material.look.stress_limit else 1.0
    digits = max(0, 4 - int(np.floor(np.log10(material.scene.size))))
    palette = (255 * colormaps[SIGNED](np.linspace(0, 1, 33))[:, :3]).round().astype(int)
    contours = [(label, line) for body in material.skins for label, line, *_ in outlines(moments[-1], body, material.look)]
    return {
        "corners": corners.round(digits).tolist(),
        "unit": {quantity: unit(material.scene.units, quantity) for quantity in ("length", "time", "stress")},
        "limit": limit,
        "palette": palette.tolist(),
        "target": TARGET,
        "targets": [line.round(digits).tolist() for label, line in contours if label == "target"],
        "frames": [_frame(moment, material, digits) for moment in moments],
    }


def _frame(moment: Configuration, material: Material, digits: int) -> dict[str, Any]:
    found = [shape for body in material.skins if (shape := skin_shape(moment, body))]
    solids = material.look.solids
    links = [*map(moment.ends, moment.links()), *moment.wheels()]
    return {
        "time": float(f"{moment.time:.9g}"),
        "solids": [[line.round(digits).tolist() for line in moment.segments(body)] for body in solids],
        "skins": [
            {
                "points": shape.line[:, ::EVERY].round(digits).tolist(),
                "stress": np.nan_to_num(shape.stress[:, ::EVERY, 0]).round(3).tolist(),
            }
            for shape in found
        ],
        "rods": [ends.round(digits).tolist() for ends in [*moment.rods(solids), *links]],
    }
