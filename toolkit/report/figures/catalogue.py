"""All figures in the order of the report."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D

from toolkit.foundation.units import unit
from toolkit.joints.joint import Joint
from toolkit.loads.torque import Torque
from toolkit.render.curves import merged, told
from toolkit.render.plane.names import write_names
from toolkit.render.plane.parts import draw_line, draw_mechanism, draw_outlines, draw_sections, draw_symbols
from toolkit.render.plane.scene_picture import contour_keys
from toolkit.render.plane.window import open_windows, panel_height, window
from toolkit.render.readable_units import readable
from toolkit.render.sheet import NARROW, sheet, style
from toolkit.report.certificate_drawing import certificate_drawing
from toolkit.report.drawing import Drawing
from toolkit.report.figures.skin_error import mark_points, skin_error, targeted
from toolkit.report.figures.stress_motion import stress_motion
from toolkit.report.figures.stress_sensitivity import stress_sensitivity
from toolkit.report.material import Material
from toolkit.scene.space import PLANE, SPACE, Space
from toolkit.scene_file.gradient_units import per, variable_unit


def monitor_curves(material: Material) -> list[Drawing]:
    """Figure of energies, energy balance, and the largest constraint violation of any joint."""
    if not material.moving:
        return []
    found, times, energy = material.monitors, material.solution.times, unit(material.scene.units, "energy")
    curves = merged(told({"kinetic": found.energy.kinetic, "strain": found.energy.strain, "work": found.energy.work}))
    with sheet(7.2, 3, sharex=True) as (figure, axes):
        above, balance, below = axes[:, 0]
        factor, label = readable(max(float(np.abs(values).max()) for values in curves.values()), energy)
        for number, (name, values) in enumerate(curves.items()):
            above.plot(times, factor * values, label=name, **style(number))
        above.set_ylabel(f"energy in {label}")
        above.update_datalim([(times[0], 0.0)])  # beside zero a change is seen as large as it is
        above.autoscale_view()
        above.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3)
        factor, label = readable(float(np.abs(found.energy.defect).max()), energy)
        balance.plot(times, factor * found.energy.defect, **style(4))
        balance.set_ylabel(f"defect in {label}")
        balance.set_title("energy gained minus work of loads, drivers and dampers", loc="left")
        tolerance = material.scene.solver.drift_tolerance
        below.semilogy(times, np.where(found.drift > 0, found.drift, np.nan), **style(0))
        below.axhline(tolerance, color="black", linewidth=1, linestyle=":")
        below.annotate("limit of the run", (times[-1], tolerance), (0, -3), textcoords="offset points", ha="right", va="top")
        below.set_ylabel("relative drift")
        below.set_title("largest opening of a joint, relative to the model size", loc="left")
        below.set_xlabel(f"time in {unit(material.scene.units, 'time')}")
    caption = (
        "The defect of the energy balance is what the time scheme created (or took, negative), and the error of the sum over time steps. "
        "Drift is what the stabilisation leaves."
    )
    return [Drawing("monitors", "Energy and constraint drift", caption, figure)]


def mechanism(material: Material) -> list[Drawing]:
    """Figure of all bodies in one panel."""
    *ghosts, last = [material.moment(step) for step in material.telling]
    shades = [to_hex(shade) for shade in colormaps["Greys"](np.linspace(0.3, 0.55, max(len(ghosts), 1)))]
    corners = window(material.look.points)
    with sheet(panel_height(corners, NARROW) + 1.0) as (figure, axes):
        panel = axes[0, 0]
        if material.skins:
            end = Line2D([], [], color="black", linewidth=3.0, label="end")
            figure.legend(handles=[*contour_keys(material.look, last), end], loc="outside upper center", ncols=3)
        open_windows(figure, last, {panel: corners})
        for body in material.skins:
            draw_outlines(panel, last, body, material.look)
        for moment, shade in zip(ghosts, shades, strict=False):
            draw_sections(panel, moment, material.look.solids, edge=shade)
            draw_mechanism(panel, moment, color=shade, edge=shade, width=2.5, but=material.look.solids)
            for body in material.skins:
                draw_line(panel, moment, body, color=shade, linewidth=1.5)
        draw_sections(panel, last, material.look.solids, filled=True)
        draw_mechanism(panel, last, but=material.look.solids)
        for body in material.skins:
            draw_line(panel, last, body, color="black", linewidth=3.0)
        draw_symbols(panel, last)
        write_names(panel, last, bodies=True)
    caption = "The last position in full, earlier ones in grey; circles are joints."
    return [Drawing("mechanism", "Motion of the mechanism", caption, figure)]


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


def certificate(material: Material) -> list[Drawing]:
    """Digits on which exact methods agree, and the V of the differences."""
    return [certificate_drawing(material.certificate)] if material.certificate else []


Figure = Callable[[Material], list[Drawing]]
FIGURES: tuple[Figure, ...] = (
    stress_motion,
    load_curves,
    mechanism,
    skin_error,
    stress_sensitivity,
    error_sensitivity,
    certificate,
    monitor_curves,
)
"""Figures of scenes in the plane."""
FIGURES_IN: dict[Space, tuple[Figure, ...]] = {PLANE: FIGURES, SPACE: (load_curves, certificate, monitor_curves)}
"""Figures by space; those of scenes in space show no body, whose pictures come from `motion`."""
