"""The motion on the page: in the plane a view that the reader can hold, in space pictures, curves and an animation."""

from __future__ import annotations

from pathlib import Path
from typing import TypedDict

import numpy as np
from matplotlib import colormaps

from toolkit.foundation.units import unit
from toolkit.foundation.value_types import Record
from toolkit.render.pictures import render_solution
from toolkit.render.plane.configuration import POINTS, Configuration, skin_shape
from toolkit.render.plane.look import window
from toolkit.render.plane.parts import outlines
from toolkit.render.readable_units import TARGET, readable_stress
from toolkit.render.sheet import SIGNED, symmetric
from toolkit.report import page
from toolkit.report.material import Progress, ReportMaterial
from toolkit.report.page import PageSection
from toolkit.scene.space import PLANE, SPACE

EVERY = (POINTS - 1) // 4
"""Points of the middle line that are skipped: a quarter of an element is shorter than a pixel is wide."""


class ViewerData(TypedDict):
    """What the moving picture shows, as lists of numbers."""

    corners: list[list[float]]
    unit: dict[str, str]
    limit: float
    palette: list[list[int]]
    target: str
    targets: list[list[list[float]]]
    frames: list[Record]


def viewer_data(material: ReportMaterial) -> ViewerData:
    """Frames of the moving picture as lists of numbers, rounded to a ten-thousandth of the scene.

    Each frame: time; per skin its points x, y and the stress of its outer fibre; per meshed body its closed lines; rods and links as
    x, y, x, y.
    """
    moments = [material.moment(step) for step in material.shown]
    corners = window(material.look.points)
    limit = symmetric([body.stress for body in material.results.bodies.values()]).vmax if material.look.stress_limit else 1.0
    assert limit is not None
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


def _frame(moment: Configuration, material: ReportMaterial, digits: int) -> Record:
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


_PIXELS = 1200
"""Width of a picture in space."""
_CAPTIONS = {
    "overview": "Instants at which something happens.",
    "curves": "Curves over time.",
    "animation": "The same as an animation (animation.gif).",
}


def motion_sections(material: ReportMaterial, folder: Path, progress: Progress) -> list[PageSection]:
    """Sections with pictures of a motion, drawn into the report's folder; none of a planar equilibrium, whose figures show it."""
    return _SECTIONS[material.scene.space](material, folder, progress)


def _in_the_plane(material: ReportMaterial, folder: Path, progress: Progress) -> list[PageSection]:
    if not material.moving:
        return []
    data = viewer_data(material)
    hint = page.typeset(" ".join(_hints(material, data["limit"], bool(data["targets"]))))
    progress("animation", 1, 1)
    return [PageSection("motion", "Motion", f"<figure>{page.viewer(data)}<figcaption>{hint}</figcaption></figure>", full=False)]


def _hints(material: ReportMaterial, limit: float, target: bool) -> list[str]:
    """Explanation of the colours and lines of the view."""
    if not material.skins:
        return []
    factor, label = readable_stress(limit, material.scene.units)
    ends = f"{-factor * limit:.3g} to {factor * limit:.3g} {label}"
    colors = f"From blue to red: stress of the outer fibre, {ends}." if material.look.stress_limit else "There is no stress."
    return [colors, "Grey: at the start.", *["Dashes: target."] * target]


def _in_space(material: ReportMaterial, folder: Path, progress: Progress) -> list[PageSection]:
    files = {file.stem: file for file in render_solution(material.solution, folder, width=_PIXELS, animate=material.moving)}
    progress("animation", 1, 1)
    shown = [page.picture(files[name], caption) for name, caption in _CAPTIONS.items() if name in files]
    alone = [page.picture(file, "The scene.") for name, file in files.items() if name.startswith("step-") and len(files) == 1]
    return [
        PageSection(
            "motion", "Motion" if material.moving else "Equilibrium", page.pictures(shown or alone), full=False, long=True
        )
    ]


_SECTIONS = {PLANE: _in_the_plane, SPACE: _in_space}
