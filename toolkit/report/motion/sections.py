"""The pictures of a motion on the page: in the plane a view that the reader can hold, in space pictures and curves; and an animation."""

from __future__ import annotations

from pathlib import Path

from toolkit.render.pictures import render_solution
from toolkit.report import page
from toolkit.report.material import Material, Progress
from toolkit.report.motion.animation import animate
from toolkit.report.motion.viewer import viewer_data
from toolkit.report.page import Section
from toolkit.scene.space import PLANE, SPACE

_PIXELS = 1200
"""Width of a picture in space."""
_CAPTIONS = {
    "overview": "Instants whose pictures differ; faint: undeformed.",
    "curves": "Curves over time.",
    "animation": "The same as an animation (animation.gif).",
}


def motion_sections(material: Material, folder: Path, progress: Progress) -> list[Section]:
    """Draw them into the folder of the report; nothing of a planar equilibrium, whose figures show it."""
    return _SECTIONS[material.scene.space](material, folder, progress)


def _in_the_plane(material: Material, folder: Path, progress: Progress) -> list[Section]:
    if not material.moving:
        return []
    gif = animate(material, folder / "animation.gif", lambda done, total: progress("animation", done, total))
    data, stress = viewer_data(material), material.results.unit("stress")
    colors = f"from {-data['limit']:.3g} to {data['limit']:.3g} {stress}"
    hint = f"From blue to red: stress of the outer fibre {colors}. Grey: undeformed; dashes: target." if material.skins else ""
    shown = f"<figure>{page.viewer(data)}<figcaption>{hint}</figcaption></figure>"
    return [Section("motion", "Motion", page.pictures([shown, page.picture(gif, _CAPTIONS["animation"])]))]


def _in_space(material: Material, folder: Path, progress: Progress) -> list[Section]:
    files = {file.stem: file for file in render_solution(material.solution, folder, width=_PIXELS, animate=material.moving)}
    progress("animation", 1, 1)
    shown = [page.picture(files[name], caption) for name, caption in _CAPTIONS.items() if name in files]
    alone = [page.picture(file, "The scene.") for name, file in files.items() if name.startswith("step-") and len(files) == 1]
    return [Section("motion", "Motion" if material.moving else "Equilibrium", page.pictures(shown or alone))]


_SECTIONS = {PLANE: _in_the_plane, SPACE: _in_space}
