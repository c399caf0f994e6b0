"""The picture of a body: its undeformed surface with numbered places, and a list that names them."""

from __future__ import annotations

import textwrap
import warnings
from collections.abc import Sequence
from importlib.util import find_spec
from io import BytesIO
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import read_start, write_whole
from toolkit.foundation.units import unit
from toolkit.reduced_model.body_summary import body_summary, centre_and_inertia
from toolkit.reduced_model.composition import read_composition
from toolkit.reduced_model.model import Outline, ReducedModel
from toolkit.reduced_model.told_body import body_line, told_place

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from mpl_toolkits.mplot3d import Axes3D


MOST_OF_A_KIND = 12
"""Interface points, masses and groups that a picture marks; its list tells how many more there are."""
DIGIT, HEIGHT = 6.5, 13.0
"""Size in pixels, at 100 dots per inch, of a digit of a number and of its frame."""
BESIDE = 6.0
"""Pixels from a marked place to the frame of its number."""


class Mark(NamedTuple):
    """Marked place of a body."""

    name: str
    kind: str  # a key of `LOOKS`
    position: Sequence[float]
    nodes: int | None


class MarkLook(NamedTuple):
    """Appearance of a kind of places."""

    words: str
    marker: str
    color: str
    filled: bool
    size: float


LOOKS = {
    "point": MarkLook("interface point", "o", "#c0392b", True, 60.0),
    "clamp": MarkLook("clamp", "s", "#1b1b1b", True, 52.0),
    "mass": MarkLook("mass", "D", "#8e44ad", True, 46.0),
    "centre": MarkLook("centre of mass", "P", "#1e8449", True, 70.0),
    "group": MarkLook("group", "^", "#1f5fa8", False, 110.0),
}
"""Kind of a marked place -> how it looks; the last ones are drawn first."""


class Label(NamedTuple):
    """Numbers that stand at one place of the picture, in pixels."""

    numbers: list[int]
    place: tuple[float, float]

    @property
    def text(self) -> str:
        """Text of the numbers, for example "1, 3, 5-9"."""
        rows: list[list[int]] = []
        for number in self.numbers:
            rows = [*rows[:-1], [*rows[-1], number]] if rows and number == rows[-1][-1] + 1 else [*rows, [number]]
        return ", ".join(f"{row[0]}-{row[-1]}" if len(row) > 2 else ", ".join(map(str, row)) for row in rows)

    @property
    def width(self) -> float:
        """Width of the label's frame, in pixels."""
        return DIGIT * len(self.text) + HEIGHT

    def within(self, right: float) -> Label:
        """Label moved to the left where it would reach beyond a place."""
        return self._replace(place=(min(self.place[0], right - self.width), self.place[1]))

    def meets(self, other: Label) -> bool:
        """Whether the frames of two labels overlap."""
        (x, y), (u, v) = self.place, other.place
        return (x - u < other.width if x > u else u - x < self.width) and abs(y - v) < HEIGHT + 2


def marks_of(model: ReducedModel) -> tuple[list[Mark], list[str]]:
    """Marks in the order of their numbers, and words on how many more places of a kind there are than the list has room for."""
    kept = read_composition(model.composition, model.dimension)
    places = {name: np.real(point.position[0, :, 0]).tolist() for name, point in (model.interfaces or {}).items()}
    points = [Mark(name, "point", place, kept.interface_points.get(name)) for name, place in places.items()]
    clamp = [Mark("", "clamp", kept.clamp.position, kept.clamp.nodes)] if kept.clamp and kept.clamp.position is not None else []
    mass = unit(model.units, "mass")
    masses = [Mark(f"of {each.mass:.6g} {mass}", "mass", each.position, each.nodes) for each in kept.masses]
    centre = Mark("", "centre", centre_and_inertia(model)[0].tolist(), None)
    placed = ((name, each.position, each.nodes) for name, each in kept.groups.items())
    groups = [Mark(name, "group", position, nodes) for name, position, nodes in placed if position is not None]
    numbers = {
        "interface points": len(points),
        "masses": len(masses) + kept.not_listed.get("masses", 0),
        "groups": len(groups) + kept.not_listed.get("groups", 0),
    }
    marks = [*points[:MOST_OF_A_KIND], *clamp, *masses[:MOST_OF_A_KIND], centre, *groups[:MOST_OF_A_KIND]]
    return marks, [f"and {n - MOST_OF_A_KIND} more {words}" for words, n in numbers.items() if n > MOST_OF_A_KIND]


def labels_at(places: Sequence[tuple[float, float]], right: float) -> list[Label]:
    """The numbers of all marks at their places in pixels, none beyond `right`; those that would overlap share one frame."""
    found = [Label([k + 1], (x + BESIDE, y + BESIDE)).within(right) for k, (x, y) in enumerate(places)]
    while (pair := _overlapping(found)) is not None:
        first, second = pair
        joined = Label(sorted(found[first].numbers + found[second].numbers), found[first].place).within(right)
        found = [joined if k == first else each for k, each in enumerate(found) if k != second]
    return found


def _overlapping(labels: Sequence[Label]) -> tuple[int, int] | None:
    return next(((i, j) for i, j in combinations(range(len(labels)), 2) if labels[i].meets(labels[j])), None)


CURVE = 8
"""Straight parts of a curved edge."""


class PictureShape(NamedTuple):
    """Drawn parts of a body; all of them may be empty."""

    triangles: np.ndarray  # (n, 3, 3) corners of the surface in space
    lines: list[np.ndarray]  # (n_points, d) polylines: the outline in the plane, the fibres of beams
    nodes: np.ndarray  # (n, d) of beams in the plane


def body_shape(model: ReducedModel) -> PictureShape:
    """Undeformed surface or outline of a body."""
    none = PictureShape(np.zeros((0, 3, 3)), [], np.zeros((0, model.dimension)))
    if model.surface is not None:
        points = np.real(model.surface.position[:, :, 0])
        return none._replace(triangles=points[model.surface.triangles], lines=[*points[model.surface.lines]])
    if model.outline is not None:
        return none._replace(lines=_curves(model.outline))
    if model.mesh is not None:
        return none._replace(lines=[model.mesh.outline], nodes=model.mesh.nodes)
    return none


def _curves(outline: Outline) -> list[np.ndarray]:
    """The edges of a boundary; those with a middle node are parabolas."""
    points = np.real(outline.position[:, :, 0])
    first, middle, last = (points[outline.edges[:, k]][:, None] for k in range(3))
    straight = outline.edges[:, 0] == outline.edges[:, 1]
    middle = np.where(straight[:, None, None], (first + last) / 2, middle)
    t = np.linspace(0, 1, CURVE + 1)[None, :, None]
    return [*((1 - t) * (1 - 2 * t) * first + 4 * t * (1 - t) * middle + t * (2 * t - 1) * last)]


OWN = "ffrf-toolkit"
"""Software that the program's own pictures name, by which it knows what it may replace."""
DOTS, SIZE = 150, (11.0, 6.4)
"""Dots per inch, and inches, of a picture."""
LIST = 0.665
"""Place where the list begins, in parts of the width."""
ROOM_FOR_LIST = 385.0
"""Height of the list in points of type."""
FEW_TRIANGLES = 6000
"""Number of triangles up to which their edges are drawn."""
VIEW, LIGHT = (24.0, -58.0), (55.0, -85.0)
"""Elevation and azimuth, in degrees, of the eye and of the light."""
BODY = np.array([0.86, 0.89, 0.93])
"""Colour of a surface in full light: red, green, blue."""
THIN = 0.12
"""Least half-width of the frame along an axis, in parts of the largest, so that its numbers have room."""


def refuse_picture(path: Path, overwrite: bool) -> None:
    """Refuse, before anything long begins, a picture that could not be drawn or would replace a file that is none of the program's.

    Raises
    ------
    InputError
        matplotlib is not installed; or the name does not end in .png, or is that of a folder or of another file.
    """
    if find_spec("matplotlib") is None:
        raise InputError(
            "--picture needs matplotlib, which is not installed. Install it with: pip install 'ffrf-toolkit[render]'."
        )
    if path.suffix != ".png":
        raise InputError(f"--picture {str(path)!r} does not end in .png. Name a picture, for example --picture body.png.")
    if path.is_dir():
        raise InputError(f"--picture {str(path)!r} is a folder. Name a file in it.")
    if path.exists() and not overwrite and OWN.encode() not in read_start(path, 1000):
        raise InputError(
            f"--picture {str(path)!r} is there, and this program has not drawn it. Name another file, or replace it with --overwrite."
        )


def save_picture(model: ReducedModel, name: str, path: Path) -> None:
    """Draw a body into a PNG file.

    Parameters
    ----------
    name : what the body is called

    Raises
    ------
    InputError
        The file cannot be written.
    """
    content = BytesIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing", UserWarning)  # foreign names may have letters that the font lacks
        picture_of(model, name).savefig(content, format="png", dpi=DOTS, metadata={"Software": OWN})
    write_whole(path, content.getvalue())


def picture_of(model: ReducedModel, name: str) -> Figure:
    """Figure with body and marks on the left, their list on the right, and the body's one line above."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    summary, length = body_summary(model), unit(model.units, "length")
    figure, shape, (marks, others) = Figure(figsize=SIZE), body_shape(model), marks_of(model)
    FigureCanvasAgg(figure)
    axes = _in_plane(figure, shape) if model.dimension == 2 else _in_space(figure, shape)
    _frame(axes, shape, marks, length)
    for mark in reversed(marks):
        _draw_mark(axes, mark)
    _number(figure, axes, marks)
    if not len(shape.triangles) and not shape.lines:
        others.append("the model keeps no surface of this body")
    _list(figure, marks, [_words(mark, f"{told_place(mark.position, summary, 5)} {length}") for mark in marks], others)
    text = textwrap.shorten(body_line(name, summary), 420, placeholder=" …")
    figure.text(0.02, 0.975, textwrap.fill(text, 140), fontsize=10, va="top", parse_math=False)
    return figure


def _in_plane(figure: Figure, shape: PictureShape) -> Axes:
    """Axes with the lines and nodes of a body in the plane."""
    from matplotlib.collections import LineCollection

    axes = figure.add_axes((0.07, 0.09, 0.57, 0.76))
    axes.add_collection(LineCollection(shape.lines, colors="#444444", linewidths=1.2), autolim=False)
    axes.plot(*shape.nodes.T, ".", color="#888888", markersize=3)
    axes.set_aspect("equal")
    axes.grid(color="#e6e6e6", linewidth=0.6)
    axes.set_axisbelow(True)
    return axes


def _in_space(figure: Figure, shape: PictureShape) -> Axes3D:
    """Axes with the surface and lines of a body in space."""
    from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

    axes: Axes3D = figure.add_axes((0.02, 0.07, 0.62, 0.78), projection="3d")
    axes.computed_zorder = False  # marks stay in front of the surface
    axes.set_proj_type("ortho")
    axes.view_init(*VIEW)
    triangles, colors = _seen(shape.triangles)
    if len(triangles):
        edges = {"edgecolors": "#8a8f94", "linewidths": 0.3} if len(triangles) <= FEW_TRIANGLES else {"linewidths": 0}
        axes.add_collection3d(Poly3DCollection(triangles, facecolors=colors, zorder=1, **edges), autolim=False)
    if shape.lines:
        axes.add_collection3d(Line3DCollection(shape.lines, colors="#555555", linewidths=0.8, zorder=1), autolim=False)
    return axes


def _seen(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles whose outer side is seen, and their colours, lighter where they face the light."""
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True).clip(np.finfo(float).tiny)
    seen = normal @ _towards(*VIEW) > 0
    light = 0.62 + 0.38 * (normal[seen] @ _towards(*LIGHT)).clip(0)
    return triangles[seen], light[:, None] * BODY


def _towards(elevation: float, azimuth: float) -> np.ndarray:
    """Unit vector from the body to a place in the sky, by angles in degrees."""
    up, round_ = np.radians([elevation, azimuth])
    return np.array([np.cos(up) * np.cos(round_), np.cos(up) * np.sin(round_), np.sin(up)])


def _frame(axes: Axes | Axes3D, shape: PictureShape, marks: list[Mark], length: str) -> None:
    """Set axes with their unit of length, of one scale, around all that is drawn."""
    from matplotlib.ticker import MaxNLocator
    from mpl_toolkits.mplot3d import Axes3D

    dimension = shape.nodes.shape[1]
    points = np.vstack([shape.triangles.reshape(-1, dimension), *shape.lines, *([mark.position] for mark in marks)])
    low, high = points.min(axis=0), points.max(axis=0)
    largest = (high - low).max() or 1.0
    half = np.maximum(0.54 * (high - low), THIN * largest)
    for axis, middle, width in zip("xyz"[:dimension], (low + high) / 2, half, strict=True):
        getattr(axes, f"set_{axis}lim")(middle - width, middle + width)
        getattr(axes, f"set_{axis}label")(f"{axis} in {length}")
        ticks = MaxNLocator(nbins=max(2, round(6 * width / half.max())))  # fewer numbers along shorter axes
        getattr(axes, f"{axis}axis").set_major_locator(ticks)
        getattr(axes, f"{axis}axis").set_tick_params(labelsize=8)
    if isinstance(axes, Axes3D):
        axes.set_box_aspect(half, zoom=0.9)


def _draw_mark(axes: Axes | Axes3D, mark: Mark) -> None:
    look = LOOKS[mark.kind]
    face = look.color if look.filled else "none"
    style: dict[str, Any] = {"s": look.size, "marker": look.marker, "facecolors": face, "edgecolors": look.color}
    axes.scatter(*([x] for x in mark.position), linewidths=1.4, zorder=5, **style)


def _number(figure: Figure, axes: Axes | Axes3D, marks: list[Mark]) -> None:
    """Write a number beside every mark."""
    from mpl_toolkits.mplot3d import Axes3D
    from mpl_toolkits.mplot3d.proj3d import proj_transform

    figure.draw_without_rendering()
    flat = [mark.position for mark in marks]
    if isinstance(axes, Axes3D):
        flat = [proj_transform(*position, axes.get_proj())[:2] for position in flat]
    places = axes.transData.transform(flat)
    for label in labels_at([(float(x), float(y)) for x, y in places], LIST * figure.bbox.width):
        x, y = figure.transFigure.inverted().transform(label.place)
        figure.text(
            x, y, label.text, fontsize=8, bbox={"boxstyle": "round,pad=0.2", "fc": "white", "ec": "#777777", "lw": 0.6}, zorder=9
        )


def _list(figure: Figure, marks: list[Mark], words: list[str], others: list[str]) -> None:
    """Write the marks with their numbers and words, and other lines below."""
    from matplotlib.lines import Line2D

    none = Line2D([], [], linestyle="none")
    lines = [(_sign(mark), f"{number}  {text}") for number, (mark, text) in enumerate(zip(marks, words, strict=True), 1)]
    lines += [(none, text) for text in others]
    size = min(8.5, ROOM_FOR_LIST / (3.1 * len(lines)))
    legend = figure.legend(*zip(*lines, strict=True), loc="upper left", bbox_to_anchor=(LIST, 0.87), fontsize=size, frameon=False,
                  labelspacing=0.7, handletextpad=0.6, borderaxespad=0)  # fmt: skip
    for text in legend.get_texts():
        text.set_parse_math(False)  # names are foreign


def _sign(mark: Mark) -> Line2D:
    from matplotlib.lines import Line2D

    look = LOOKS[mark.kind]
    face = look.color if look.filled else "none"
    return Line2D([], [], linestyle="none", marker=look.marker, markersize=7, markerfacecolor=face, markeredgecolor=look.color)


def _words(mark: Mark, place: str) -> str:
    """Words of the list for a mark at a place, for example "interface point tip" and, below, "(4, 0.5, 0.25), 4 nodes"."""
    name = f"{LOOKS[mark.kind].words} {textwrap.shorten(mark.name, 40, placeholder='…')}".strip()
    nodes = "" if mark.nodes is None else f", {mark.nodes} node{'s' * (mark.nodes != 1)}"
    return f"{name}\n     {place}{nodes}"
