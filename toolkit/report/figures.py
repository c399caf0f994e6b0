"""The figures of a report: each takes the material and gives the drawings that it has something to say for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import Normalize, to_hex
from matplotlib.lines import Line2D

from toolkit.components.joints.joint import Joint
from toolkit.components.loads.torque import Torque
from toolkit.description.description import InSpace
from toolkit.description.design import BodyPoint
from toolkit.files.gradient_units import per, variable_unit
from toolkit.foundation.units import unit
from toolkit.render.plane.configuration import drawn_model, fibre_values, skin_shape
from toolkit.render.plane.look import open_windows, panel_height, window
from toolkit.render.plane.parts import draw_band, draw_line, draw_mechanism, draw_outlines, draw_sections, draw_symbols
from toolkit.render.plane.scene_picture import color_bar, contour_keys, overview_figure, write_names
from toolkit.render.readable_units import MINUS, UNDEFORMED, readable, round_off, round_up, told
from toolkit.render.sheet import COLORS, NARROW, SIGNED, merged, sheet, style
from toolkit.render.sheet import told as told_apart
from toolkit.report.drawing import Drawing, certificate_drawing
from toolkit.report.material import ReportMaterial
from toolkit.scene.space import PLANE, SPACE, Space
from toolkit.system.solution import flexible_body

_FAR = 5.0
"""How many times as large as what three quarters of the instants reach a peak is that gets no colour of its own."""
MOST_DOTS = 100
"""Steps that are marked one by one."""


def monitor_curves(material: ReportMaterial) -> list[Drawing]:
    """Figure of energies, energy balance, and the largest constraint violation of any joint."""
    if not material.moving:
        return []
    found, times, energy = material.monitors, material.solution.times, unit(material.scene.units, "energy")
    curves = merged(told_apart({"kinetic": found.energy.kinetic, "strain": found.energy.strain, "work": found.energy.work}))
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


def mechanism(material: ReportMaterial) -> list[Drawing]:
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
                draw_line(panel, moment, body, shade, 1.5)
        draw_sections(panel, last, material.look.solids, filled=True)
        draw_mechanism(panel, last, but=material.look.solids)
        for body in material.skins:
            draw_line(panel, last, body, "black", 3.0)
        draw_symbols(panel, last)
        write_names(panel, last, bodies=True)
    caption = "The last position in full, earlier ones in grey; circles are joints."
    return [Drawing("mechanism", "Motion of the mechanism", caption, figure)]


def load_curves(material: ReportMaterial) -> list[Drawing]:
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


def _scale(part: InSpace, units: str) -> tuple[float, str]:
    if isinstance(part, Torque):
        return float(part.torque), f"torque in {unit(units, 'torque')}"
    if isinstance(part, Joint):
        row = part.constraint(None)[-1]  # which a curve is subtracted from
        return 1.0, f"{row.name} in {unit(units, row.quantity)}"
    return 1.0, "factor"


def stress_motion(material: ReportMaterial) -> list[Drawing]:
    """Skins at some instants, coloured by the stress of their outer and inner fibre, and meshed bodies by theirs."""
    if not material.look.stress_limit:
        return []
    moments = [material.moment(step) for step in material.telling]
    bands = "Outer half of the band: outer fibre; inner half: inner fibre. " if material.skins else ""
    caption = f"{bands}Red is tension, blue compression."
    figure = overview_figure(moments, material.look, NARROW, columns=1)
    return [Drawing("stress_motion", "Stress during the motion", caption, figure)]


def stress(material: ReportMaterial) -> str:
    """Label of the unit of stress."""
    return unit(material.scene.units, "stress")


def targeted(material: ReportMaterial) -> list[str]:
    """Names of the skins that have a target."""
    return [name for name in material.skins if material.results.bodies[name].shape_error.shape[1]]


def skin_error(material: ReportMaterial) -> list[Drawing]:
    """One drawing per skin with a target: shapes above, error below."""
    return [_shapes(material, body) for body in targeted(material)]


def _shapes(material: ReportMaterial, body: str) -> Drawing:
    fields, length = material.results.bodies[body], unit(material.scene.units, "length")
    error = fields.shape_error[-1]
    rms = (error**2).mean() ** 0.5
    last = material.moment(-1)
    corners = window(material.look.points)
    height = panel_height(corners, NARROW)
    with sheet(height + 3.4, 2, height_ratios=(height, 2.2)) as (figure, axes):
        shapes, along = axes[:, 0]
        shapes.set_title("shapes at the end", loc="left")
        along.plot(fields.arc_length, error, "o-", color=COLORS[0], markersize=3.5)
        along.axhline(rms, color=COLORS[1], linestyle="--")
        along.set_ylim(bottom=0, top=1.25 * error.max() or 1.0)
        along.set_xlabel(f"arc length in {length}")
        along.set_ylabel(f"distance in {length}")
        told = f"distance to the target, largest {error.max():.4g} {length}\nroot mean square (dashes) {rms:.4g} {length}"
        along.set_title(told, loc="left")
        mark_points(along, material, body)
        open_windows(figure, last, {shapes: corners})
        draw_outlines(shapes, last, body, material.look)
        draw_line(shapes, last, body, "black", 3.0, "deformed")
        shapes.legend(loc="center right")
    caption = f"Distance of the nodes of {body} to the target, at the end of the motion."
    return Drawing(f"skin_error_{body}", f"Shape of {body} and distance to the target", caption, figure)


def mark_points(axes: Axes, material: ReportMaterial, body: str, names: bool = True) -> None:
    """Vertical lines at the arc lengths where joints and loads grip a skin."""
    interfaces = material.scene.model(flexible_body(material.scene, body).model).interfaces or {}
    for name, point in material.scene.points.items():
        if isinstance(point, BodyPoint) and point.body == body and point.interface in interfaces:
            place = float(interfaces[point.interface].arc_length if point.arc_length is None else point.arc_length)
            axes.axvline(place, color=UNDEFORMED, linewidth=0.8)
            if names:
                spot: Any = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points", "ha": "right", "va": "top"}
                axes.annotate(name, (place, 1.0), (-3, -3), fontsize=9, **spot)


def stress_sensitivity(material: ReportMaterial) -> list[Drawing]:
    """One drawing per skin and variable."""
    return [
        _derivatives(material, body, x, variable) for body in material.skins for x, variable in enumerate(material.results.design)
    ]


def _derivatives(material: ReportMaterial, body: str, x: int, variable: str) -> Drawing:
    path, moment = material.results.variables[variable]["path"], material.moment(-1)
    label = per(stress(material), variable_unit(material.scene, path))
    derivative = material.results.bodies[body].dstress[:, :, x]
    fibres = np.array([fibre_values(drawn_model(moment, body), row) for row in derivative])  # (n_t, n_e, POINTS, 2)
    value = abs(material.results.variables[variable]["value"]) or 1.0
    limit, beyond = color_range(fibres, round_off(material.scene, body) / value)
    fibres, limit = (fibres, limit) if limit else (np.zeros_like(fibres), 1.0)
    colors = Normalize(-limit, limit)
    corners = window(material.look.points)
    heights = [panel_height(corners, NARROW), 2.0][: 1 + material.moving]
    with sheet(sum(heights) + 1.6, len(heights), height_ratios=heights) as (figure, axes):
        above = axes[0, 0]
        peak = fibres[-1].ravel()[np.nanargmax(np.abs(fibres[-1]))]
        words = f"largest {f'{peak:.4g}'.replace('-', MINUS)} {label}" if peak else "no influence"
        above.set_title(f"at the end; {words}", loc="left")
        if material.moving:
            _over_time(axes[1, 0], material, body, fibres[..., 0], colors)
        color_bar(figure, list(axes[:, 0]), colors, f"d stress / d {variable} in {label}", beyond)
        open_windows(figure, moment, {above: corners})
        draw_band(above, moment, body, fibres[-1], colors, material.look.thickness[body])
    caption = f"How the stress of {body} changes with {variable} ({path})."
    if beyond:
        caption += f" A short peak beyond the colours reaches {float(f'{beyond:.3g}'):g} {label}."
    return Drawing(f"stress_sensitivity_{body}_{variable}", f"Sensitivity of the stress to {variable}", caption, figure)


def color_range(fibres: np.ndarray, noise: float) -> tuple[float, float]:
    """Limit of the colours, and the largest magnitude if that is far beyond it, otherwise zero.

    Where a motion snaps through, derivatives have a peak that would leave all else without a colour: then they reach as far as three
    quarters of the instants and the end do.
    """
    each = np.array([told(instant, noise) for instant in fibres])
    usual = max(float(np.quantile(each, 0.75)), each[-1])
    return (round_up(usual), each.max()) if each.max() > _FAR * usual > 0 else (round_up(each.max()), 0.0)


def _over_time(axes: Axes, material: ReportMaterial, body: str, outer: np.ndarray, colors) -> None:
    """Outer fibre: along the skin to the right, time upwards; two points of every element are enough, for it is linear there."""
    shape, units = skin_shape(material.moment(0), body), material.scene.units
    assert shape is not None
    lengths = np.linalg.norm(np.diff(shape.line, axis=1), axis=2).sum(axis=1)
    places = np.append(0.0, np.cumsum(lengths))
    means = (outer[:, :, 0] + outer[:, :, -1]) / 2
    times = material.solution.times
    edges = np.concatenate([times[:1], (times[1:] + times[:-1]) / 2, times[-1:]])
    axes.pcolormesh(places, edges, means, cmap=SIGNED, norm=colors, rasterized=True)
    axes.grid(False)
    axes.set_xlabel(f"arc length in {unit(units, 'length')}")
    axes.set_ylabel(f"time in {unit(units, 'time')}")
    axes.set_title("outer fibre, mean of each element", loc="left")


def error_sensitivity(material: ReportMaterial) -> list[Drawing]:
    """One drawing per skin with a target, one panel per variable."""
    return [_changes(material, body) for body in targeted(material)] if material.results.design else []


def _changes(material: ReportMaterial, body: str) -> Drawing:
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


def certificate(material: ReportMaterial) -> list[Drawing]:
    """Digits on which exact methods agree, and the V of the differences."""
    return [certificate_drawing(material.certificate)] if material.certificate else []


Figure = Callable[[ReportMaterial], list[Drawing]]
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
