"""Names in pictures of all models: none covers another, and each is nearest to its own point or joined to it by a line."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import LineCollection

from tests.models.pictures import rest
from toolkit.files.scene_reader import read_scene
from toolkit.render.label_places import Name, NamesOfMotion, body_places, panel_of, placed, sides
from toolkit.render.moment import names_by_place
from toolkit.render.plane.configuration import Configuration
from toolkit.render.plane.look import choose_look
from toolkit.render.plane.scene_picture import instant_figure, overview_figure
from toolkit.render.space.configuration import SpatialConfiguration
from toolkit.render.space.look import Camera, seen_points

SCENES = {file.parent.name: read_scene(file) for file in sorted((Path(__file__).parents[2] / "models").glob("*/scene.toml"))}
PLANAR = [name for name, scene in SCENES.items() if scene.dimension == 2]
SPATIAL = [name for name in SCENES if name not in PLANAR]
LETTER, PANEL = 20, np.array([550.0, 300.0])
"""Pixels of a panel of an overview in space, 1200 pixels wide."""


def swung(solution, angle):
    """The four-bar chain with its links at an angle from the ground: parallel ones, and couplers that only shift."""
    along = np.array([np.cos(angle), np.sin(angle)])
    for body in solution.system.scene.bodies:
        number, q = int(body[-1]), solution.q[0, solution.coordinates(body)]
        link = body.startswith("link")
        q[:2] = np.array([number, 0.0]) + along / 2 if link else np.array([number - 0.5, 0.0]) + along
        q[2] += (angle - np.pi / 2) * link
    return solution


def distance(box, point):
    """From a box, corners (2, 2), to a point."""
    return np.hypot(*np.maximum([box[0] - point, point - box[1]], 0).max(axis=0))


def mistaken(boxes, points, led):
    """Names whose box is not nearer to their own point than to any other's, and that no line leads to; points at one place are one."""
    found = []
    for name, box in boxes.items():
        own = distance(box, points[name])
        others = [distance(box, point) for point in points.values() if np.hypot(*(point - points[name])) > 2]
        if name not in led and own >= min(others, default=np.inf):
            found.append(name)
    return found


def overview(moment, look):
    """Two pictures beside each other, with smaller panels."""
    return overview_figure([moment] * 2, look)


@pytest.mark.parametrize("name", [*PLANAR, "four_bar_chain, flat"])
@pytest.mark.parametrize(
    "draw", [lambda moment, look: instant_figure(moment, look), lambda moment, look: overview_figure([moment] * 2, look)]
)
def test_names_of_points_and_bodies_are_nobody_elses_and_cover_no_other(name, draw):
    solution = rest(SCENES[name.removesuffix(", flat")], 0)
    if name.endswith("flat"):
        solution = swung(solution, np.pi - 0.1)
    moment = Configuration(solution, 0)
    axes = draw(moment, choose_look(solution, [0])).axes[0]
    boxes = {text.get_text(): text.get_window_extent().get_points() for text in axes.texts}
    assert set(SCENES[name.removesuffix(", flat")].bodies) <= boxes.keys()
    for one, other in combinations(boxes.values(), 2):
        assert np.any(one[1] <= other[0]) or np.any(other[1] <= one[0])
    places = {label: axes.transData.transform(place) for place, label in names_by_place(moment, 3e-3 * np.ptp(axes.get_xlim()))}
    (lines,) = (each for each in axes.collections if isinstance(each, LineCollection) and each.get_gid() == "leads")
    starts = [axes.transData.transform(line[0]) for line in lines.get_segments()]
    led = {label for label, place in places.items() if any(np.hypot(*(start - place)) < 1 for start in starts)}
    assert mistaken({label: boxes[label] for label in places}, places, led) == []


@pytest.mark.parametrize("name", SPATIAL)
def test_names_in_space_are_nobody_elses_and_cover_no_other(name):
    """Beside what is drawn of bodies and links, as the camera of an overview sees it."""
    moment = SpatialConfiguration(rest(SCENES[name], 0), 0)
    camera = Camera.framing(seen_points(moment), PANEL[0] / PANEL[1], 0.08, False)
    scale = PANEL[1] / camera.size[1]
    bodies = [(place, body) for body, place in body_places(moment, camera.seen).items() if body not in moment.named_points()]
    names = [
        Name(text, scale * camera.seen(place), LETTER * np.array([0.3 * len(text) + 0.1, 0.5]))
        for place, text in [*names_by_place(moment, 1e-3), *bodies]
    ]
    lines = [scale * camera.seen(line) for line in [*moment.rods(), *map(moment.ends, moment.links())]]
    panel = panel_of(names, lines, LETTER, PANEL)
    found = [each for each in placed(panel, sides([panel], LETTER)) if each is not None]
    boxes = {each.name.text: np.array([each.place - each.name.half, each.place + each.name.half]) for each in found}
    assert len(boxes) == len(names) > 0
    for one, other in combinations(boxes.values(), 2):
        assert np.any(one[1] <= other[0]) or np.any(other[1] <= one[0])
    assert mistaken(boxes, {each.text: each.point for each in names}, {each.name.text for each in found if each.led}) == []


def test_names_of_a_motion_keep_to_their_side_and_two_points_that_meet_keep_their_names():
    """A point on a circle round another: alone its name goes round with it, in the motion not; what meets at one moment keeps two names."""
    half = np.array([8.0, 5.0])
    panels = []
    for angle in np.linspace(0, 2 * np.pi, 7):
        end = np.array([100.0, 100.0]) + 60 * np.array([np.cos(angle), np.sin(angle)])
        names = [Name("O", np.array([100.0, 100.0]), half), Name("P", end, half)]
        panels.append(panel_of(names, [np.array([[100.0, 100.0], end])], 10.0, np.array([200.0, 200.0])))
    alone = {tuple(np.round(sides([panel], 10.0)[1].offset, 6)) for panel in panels}
    motion = NamesOfMotion(panels)
    for panel in panels:
        motion.sides(0, panel, lambda some: sides(some, 10.0))
    together = [motion.sides(0, panel, lambda some: sides(some, 10.0))[1] for panel in panels]
    assert len(alone) > 1
    assert len({(*side.offset, side.led) for side in together}) == 1

    solution = rest(SCENES["four_bar_chain"], 1)
    apart, joined = Configuration(solution, 0), Configuration(solution, 1)
    every = len(names_by_place(apart, 1e-3))
    solution.q[1] *= 0  # all bodies at one place
    assert len(names_by_place(joined, 10.0)) < every
    assert len(names_by_place(joined, 1e-3, (apart, joined))) == every
