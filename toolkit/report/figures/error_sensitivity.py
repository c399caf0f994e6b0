"""Derivatives of the distance to the target by every variable, along the skin (paper, fig. 10)."""

from __future__ import annotations

from toolkit.foundation.units import unit
from toolkit.render.sheet import sheet, style
from toolkit.report.drawing import Drawing
from toolkit.report.figures.skin_error import mark_points, targeted
from toolkit.report.material import Material
from toolkit.scene_file.gradient_units import per, variable_unit


def error_sensitivity(material: Material) -> list[Drawing]:
    """One drawing per skin with a target, one panel per variable."""
    return [_one(material, body) for body in targeted(material)] if material.results.design else []


def _one(material: Material, body: str) -> Drawing:
    fields, length, names = material.results.bodies[body], unit(material.scene.units, "length"), material.results.design
    with sheet(0.7 + 1.55 * len(names), len(names), sharex=True) as (figure, axes):
        for x, (panel, name) in enumerate(zip(axes[:, 0], names, strict=True)):
            label = per(length, variable_unit(material.scene, material.results.variables[name]["path"]))
            panel.axhline(0, color="black", linewidth=0.8)
            panel.plot(fields.arc_length, fields.dshape_error[-1, :, x], marker="o", markersize=3, **style(x))
            panel.set_title(f"by {name}, in {label}", loc="left")
            panel.margins(y=0.3)
            panel.ticklabel_format(axis="y", scilimits=(-3, 3))
            mark_points(panel, material, body, names=x == 0)
        axes[-1, 0].set_xlabel(f"arc length in {length}")
    caption = (
        f"How the distance of each node of {body} to the target changes with each variable, at the end of the motion. A node that "
        "meets its target exactly has no derivative."
    )
    return Drawing(f"error_sensitivity_{body}", f"Sensitivity of the distance to the target of {body}", caption, figure)
