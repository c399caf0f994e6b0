"""The motion on the page: in the plane a view that the reader can hold, in space pictures, curves and an animation."""

from __future__ import annotations

from pathlib import Path

from toolkit.render.pictures import render_solution
from toolkit.render.readable_units import readable_stress
from toolkit.report import page
from toolkit.report.material import Material, Progress
from toolkit.report.motion.viewer import viewer_data
from toolkit.report.page import Section
from toolkit.scene.space import PLANE, SPACE

_PIXELS = 1200
"""Width of a picture in space."""
_CAPTIONS = {
    "overview": "Instants at which something happens.",
    "curves": "Curves over time.",
    "animation": "The same as an animation (animation.gif).",
}


def motion_sections(material: Material, folder: Path, progress: Progress) -> list[Section]:
    """Draw them into the folder of the report; nothing of a planar equilibrium, whose figures show it."""
    return _SECTIONS[material.scene.space](material, folder, progress)


def _in_the_plane(material: Material, folder: Path, progress: Progress) -> list[Section]:
    if not material.moving:
        return []
    data = viewer_data(material)
    hint = page.typeset(" ".join(_hints(material, data["limit"], bool(data["targets"]))))
    progress("animation", 1, 1)
    return [Section("motion", "Motion", f"<figure>{page.viewer(data)}<figcaption>{hint}</figcaption></figure>", full=False)]


def _hints(material: Material, limit: float, target: bool) -> list[str]:
    """What colours and lines of the view mean."""
    if not material.skins:
        return []
    factor, label = readable_stress(limit, material.scene.units)
    ends = f"{-factor * limit:.3g} to {factor * limit:.3g} {label}"
    colors = f"From blue to red: stress of the outer fibre, {ends}." if material.look.stress_limit else "There is no stress."
    return [colors, "Grey: at the start.", *["Dashes: target."] * target]


def _in_space(material: Material, folder: Path, progress: Progress) -> list[Section]:
    files = {file.stem: file for file in render_solution(material.solution, folder, width=_PIXELS, animate=material.moving)}
    progress("animation", 1, 1)
    shown = [page.picture(files[name], caption) for name, caption in _CAPTIONS.items() if name in files]
    alone = [page.picture(file, "The scene.") for name, file in files.items() if name.startswith("step-") and len(files) == 1]
    return [
        Section("motion", "Motion" if material.moving else "Equilibrium", page.pictures(shown or alone), full=False, long=True)
    ]


_SECTIONS = {PLANE: _in_the_plane, SPACE: _in_space}
