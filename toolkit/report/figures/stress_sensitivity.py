"""Derivatives of the stress by every variable: over the skin at the end, and along it over time (paper, fig. 9)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize

from toolkit.foundation.units import unit
from toolkit.render.plane.parts import draw_band
from toolkit.render.plane.scene_picture import color_bar
from toolkit.render.plane.skin_shape import drawn_model, fibre_values, skin_shape
from toolkit.render.plane.window import open_windows, panel_height, window
from toolkit.render.round_numbers import MINUS, round_up
from toolkit.render.sheet import NARROW, SIGNED, sheet
from toolkit.render.stress_told import round_off, told
from toolkit.report.drawing import Drawing
from toolkit.report.figures.stress_motion import stress
from toolkit.report.material import Material
from toolkit.scene_file.gradient_units import per, variable_unit

_FAR = 5.0
"""How many times as large as what three quarters of the instants reach a peak is that gets no colour of its own."""


def stress_sensitivity(material: Material) -> list[Drawing]:
    """One drawing per skin and variable."""
    return [_one(material, body, x, variable) for body in material.skins for x, variable in enumerate(material.results.design)]


def _one(material: Material, body: str, x: int, variable: str) -> Drawing:
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


def _over_time(axes: Axes, material: Material, body: str, outer: np.ndarray, colors) -> None:
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
