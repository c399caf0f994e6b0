"""Pictures: what is drawn has the numbers of the solution and covers nothing; a machine that cannot draw gets a message, not a crash."""

import re
import subprocess
import sys
from dataclasses import replace
from io import BytesIO
from itertools import combinations, pairwise
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from imageio_ffmpeg import count_frames_and_secs, get_ffmpeg_exe
from matplotlib.collections import LineCollection, PolyCollection, TriMesh
from matplotlib.colors import to_rgba
from PIL import Image
from scipy.spatial import cKDTree

import toolkit.render.packages as probe
from tests.models.cases import CASES, write_models
from tests.models.pictures import distinct_colors, image, rest
from tests.models.scenes import hanging_skin
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.rigid_joint import RigidJoint
from toolkit.components.loads.gravity import Gravity
from toolkit.description.design import Point
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError, ToolkitError
from toolkit.foundation.files.safe_files import OWN, list_own
from toolkit.reduced_model.file import load, save
from toolkit.render.animation import gif, telling_steps
from toolkit.render.label_places import Name, Panel, body_places, placed, sides
from toolkit.render.moment import names_by_place
from toolkit.render.packages import RenderError, drawing, drawing_environment
from toolkit.render.pictures import chosen_steps, render_solution
from toolkit.render.plane.configuration import Configuration, skin_shape, solid_shape
from toolkit.render.plane.look import choose_look, window
from toolkit.render.plane.parts import clamps, outlines, symbols
from toolkit.render.plane.scene_picture import (
    curves_figure,
    drawn_lines,
    instant_figure,
    instant_windows,
    meanings,
    overview_figure,
    shape_errors,
)
from toolkit.render.readable_units import ROD, TARGET, UNDEFORMED, View, even, readable, round_up, stress_range, tick_step
from toolkit.render.sheet import NARROW, WIDE, merged, motion_panels, told, write_figure
from toolkit.responses.shape_error import ShapeRMS
from toolkit.responses.stress import MaxStress, stress_field, stress_operator
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene

SCENE = Path(__file__).parents[2] / "models" / "morphing_wing" / "scene.toml"
WIDTH = 700


@pytest.fixture(scope="module")
def wing():
    """The wing in made-up states, which need no solver: the skin grows towards its target, the rods stay where they are."""
    solution = rest(read_scene(SCENE), 4)
    model = solution.system.scene.model("skin.h5", "shape")
    where = solution.coordinates("skin")
    position = model.shape.position.reshape(-1, model.n_f + 1)
    elastic = np.linalg.lstsq(position[:, 1:], model.shape.target.ravel() - position[:, 0], rcond=None)[0]
    solution.q[:, where] = 0.9 * solution.times[:, None] * elastic
    return solution


def pendulum(steps=0):
    """A scene without flexible bodies."""
    scene = Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "P": Point(x=1.0, y=0.0)},
        bodies={"rod": Rod(between=("O", "P"), area=1e-4, density=1e3)},
        joints={name: Revolute(bodies=("rod", "ground"), point="O") for name in ("pivot", "twin|name")},
        loads={"gravity": Gravity(acceleration=(0.0, -9.81))},
    )
    return rest(scene, steps)


@pytest.fixture(autouse=True)
def no_opengl(monkeypatch):
    """Nothing planar may ask for OpenGL."""
    monkeypatch.setattr("toolkit.render.pictures.drawing_environment", None)
    monkeypatch.setattr("toolkit.render.pictures.drawing", None)


def test_every_instant_the_overview_and_the_curves_are_written(wing, tmp_path):
    files = render_solution(wing, tmp_path / "new", instants=[0.5, 1.0], width=WIDTH)
    assert [file.name for file in files] == ["step-2.png", "step-4.png", "overview.png", "curves.png"]
    assert sorted([*files, tmp_path / "new" / OWN]) == sorted((tmp_path / "new").iterdir())  # no temporary file is left
    for file in files:
        pixels = image(file)
        assert pixels.shape[1] == WIDTH
        assert distinct_colors(pixels) > 100  # a colour bar and smoothed lines; an empty sheet has one
    assert not np.array_equal(image(files[0]), image(files[1]))
    render_solution(wing, tmp_path / "new", instants=[1.0], width=WIDTH)  # of the earlier pictures none is left
    assert {file.name for file in (tmp_path / "new").glob("*.png")} == {"step-4.png", "curves.png"}
    (tmp_path / "new" / "step-2.png").write_text("mine")
    with pytest.raises(InputError, match=r"step-2\.png' is there, and ffrf has not written it"):
        render_solution(wing, tmp_path / "new", instants=[1.0], width=WIDTH)


def test_a_scene_without_flexible_bodies_is_drawn_in_one_picture(tmp_path):
    files = render_solution(pendulum(), tmp_path, width=WIDTH)
    assert [file.name for file in files] == ["step-0.png"]
    assert distinct_colors(image(files[0])) > 20  # smoothed lines on white


@pytest.mark.parametrize("kind", ["svg", "pdf"])
def test_a_picture_is_the_same_file_whenever_it_is_drawn_and_has_no_pixels(wing, tmp_path, kind, monkeypatch):
    files = []
    for folder, epoch in ((tmp_path / "one", "0"), (tmp_path / "two", "1000000000")):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)  # which dates in files follow
        files.append(render_solution(wing, folder, [1.0], WIDTH, View(format=kind)))
    assert [file.name for file in files[0]] == [f"step-4.{kind}", f"curves.{kind}"]
    assert [file.read_bytes() for file in files[0]] == [file.read_bytes() for file in files[1]]
    if kind == "svg":
        tags = {element.tag.rpartition("}")[2] for element in ElementTree.parse(files[0][0]).iter()}
        assert "path" in tags
        picture = [element for element in ElementTree.parse(files[0][0]).iter() if element.tag.endswith("image")]
        assert len(picture) == 1  # the ramp of the colour bar


def test_an_interrupted_picture_leaves_the_old_one(wing, tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    (tmp_path / "step-4.png").write_bytes(b"old")
    list_own(tmp_path, ["step-4.png"])  # a picture that was drawn before
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", interrupted)
    with pytest.raises(KeyboardInterrupt):
        render_solution(wing, tmp_path, instants=[1.0], width=WIDTH)
    assert {file.name for file in tmp_path.iterdir()} == {"step-4.png", OWN}
    assert (tmp_path / "step-4.png").read_bytes() == b"old"


@pytest.fixture(scope="module")
def figures(wing):
    """Name -> figure and the moments that its axes show."""
    last, look = Configuration(wing, 4), choose_look(wing, [1, 2, 3, 4])
    some = [Configuration(wing, step) for step in (1, 2, 4)]
    chain = Configuration(read_four_bars(), 0)
    return {
        "instant": (instant_figure(last, look), [last, last]),
        "overview": (overview_figure(some, look), some),
        "narrow overview": (overview_figure(some, look, NARROW, columns=1), some),
        "narrow instant": (instant_figure(last, replace(look, detail=None), NARROW), [last]),
        "rods": (instant_figure(chain, choose_look(chain.solution, [0])), [chain]),
    }


def read_four_bars():
    return rest(read_scene(SCENE.parents[1] / "four_bar_chain" / "scene.toml"), 0)


KINDS = ["instant", "overview", "narrow overview", "narrow instant", "rods"]


def panels(figures, kind):
    """Axes of scenes, each with its moment."""
    figure, moments = figures[kind]
    return list(zip(figure.axes, moments, strict=False))


def of_class(axes, kind, **wanted):
    """Collections of a class in axes; those with a grid of colours or an identifier, if that is asked for."""
    found = [each for each in axes.collections if type(each) is kind]
    return [each for each in found if all(getattr(each, f"get_{key}")() == value for key, value in wanted.items())]


@pytest.mark.parametrize("kind", KINDS)
def test_x_and_y_have_one_scale_and_everything_is_inside(figures, kind):
    for k, (axes, moment) in enumerate(panels(figures, kind)):
        (x, _), (_, y) = np.diff(axes.transData.transform([[0, 0], [1, 0], [1, 1]]), axis=0)
        assert x == pytest.approx(y, rel=1e-6)  # a millionth of a pixel in a thousand
        if kind != "instant" or k == 0:  # the detail shows a part
            corners = np.transpose([axes.get_xlim(), axes.get_ylim()])
            places = [*moment.named_points().values(), *(line for body in moment.scene.bodies for line in moment.segments(body))]
            assert np.all((np.vstack(places) > corners[0]) & (np.vstack(places) < corners[1]))


@pytest.mark.parametrize("kind", KINDS[:4])
def test_drawn_stress_has_the_range_and_the_colours_of_the_response(wing, figures, kind):
    for axes, moment in panels(figures, kind):
        (band,) = [each for each in of_class(axes, PolyCollection) if each.get_array() is not None]
        drawn, stress = band.get_array(), stress_field(wing, "skin")[0][moment.step]
        np.testing.assert_allclose([drawn.min(), drawn.max()], [stress.min(), stress.max()], rtol=1e-12)  # interpolation
        np.testing.assert_allclose(stress_range(wing, "skin")[moment.step], [stress.min(), stress.max()], rtol=1e-12)
        assert band.norm.vmin == -band.norm.vmax
        assert stress.max() <= band.norm.vmax
        bar = next(each for each in axes.get_figure().axes if "stress in MPa" in each.get_xlabel())
        assert bar.get_xlim() == (band.norm.vmin, band.norm.vmax)
    assert MaxStress(body="skin", when="end").value(wing) == pytest.approx(stress.max(), rel=1e-12)


def test_every_stress_point_is_drawn_in_its_colour_at_its_place(wing, figures):
    """At the ends of the elements, where stress is evaluated; pieces of the outer fibre come first."""
    moment, (axes, _) = Configuration(wing, 4), panels(figures, "overview")[2]
    (band,) = [each for each in of_class(axes, PolyCollection) if each.get_array() is not None]
    shape = skin_shape(moment, "skin")
    pieces = np.array([path.vertices[:4] for path in band.get_paths()]).reshape(*shape.stress.shape, 4, 2)
    np.testing.assert_array_equal(band.get_array().reshape(shape.stress.shape), shape.stress)
    np.testing.assert_allclose(pieces[:, 0, :, 3], np.repeat(shape.line[:, :1], 2, axis=1), atol=1e-12)  # the middle line starts
    thick = np.linalg.norm(pieces[:, :, 0, 0] - pieces[:, :, 0, 3], axis=-1)
    assert np.all(np.einsum("ek,ek->e", pieces[:, 0, 0, 0] - pieces[:, 0, 0, 3], shape.outward[:, 0]) > 0)
    assert np.ptp(thick) < 0.02 * thick.max()  # chords of a curved line


def test_bands_for_paraview_have_the_range_of_the_response(wing):
    pytest.importorskip("pyvista")
    from toolkit.render.paraview import skin_mesh

    drawn = skin_mesh(skin_shape(Configuration(wing, 4), "skin"), 1.5, "stress").point_data["stress"]
    stress = stress_field(wing, "skin")[0][-1]
    np.testing.assert_allclose([drawn.min(), drawn.max()], [stress.min(), stress.max()], rtol=1e-12)  # interpolation


@pytest.mark.parametrize("kind", KINDS)
def test_rods_outlines_and_symbols_are_drawn_where_the_solution_has_them(figures, kind):
    for axes, moment in panels(figures, kind):
        (rods,) = [each for each in of_class(axes, LineCollection) if len(each.get_colors()) == 2]
        wanted = [ends for body in moment.scene.bodies for ends in moment.segments(body)]
        assert [to_rgba(ROD) in map(tuple, rods.get_colors()), len(rods.get_segments())] == [True, 2 * len(wanted)]
        for drawn, ends in zip(rods.get_segments()[::2], wanted, strict=True):
            np.testing.assert_array_equal(drawn, ends)
        lines = {to_rgba(line.get_color()): line.get_xydata() for line in axes.lines}
        mesh = moment.scene.model("skin.h5", "mesh").mesh if moment.flexible() else None
        contours = {} if mesh is None else {to_rgba(UNDEFORMED): mesh.outline, to_rgba(TARGET): mesh.target_outline}
        assert lines.keys() == contours.keys()
        for color, points in contours.items():
            np.testing.assert_array_equal(lines[color], points)  # the skin is clamped: its frame does not move
        for symbol in symbols(moment):
            drawn = [each for each in axes.collections if each.get_gid() == symbol.kind]
            offsets = np.array([each.get_offsets().ravel() for each in drawn])
            assert np.any(np.all(offsets == symbol.point, axis=1))


@pytest.mark.parametrize("kind", KINDS)
def test_names_stand_beside_their_points_and_cover_neither_lines_nor_each_other_nor_leave_the_panel(figures, kind):
    for k, (axes, moment) in enumerate(panels(figures, kind)):
        texts = {text.get_text(): text.get_window_extent() for text in axes.texts}
        if kind != "instant" or k == 0:
            assert set(moment.named_points()) <= texts.keys()
            assert ("skin clamped" in texts) == bool(moment.flexible())
        points = np.vstack([dense(line) for line in drawn_lines(axes)])
        (leads,) = (each.get_segments() for each in axes.collections if each.get_gid() == "leads")
        for name, box in texts.items():
            assert not np.any((points > box.min).all(axis=1) & (points < box.max).all(axis=1)), name
            assert axes.bbox.x0 <= box.x0
            assert box.x1 <= axes.bbox.x1
            assert axes.bbox.y0 <= box.y0
            assert box.y1 <= axes.bbox.y1
            if name in moment.named_points():
                point = axes.transData.transform(moment.named_points()[name])
                beside = np.hypot(*np.maximum([box.min - point, point - box.max], 0).max(axis=0)) < 30  # of 100 pixels per inch
                assert beside or any(np.allclose(axes.transData.transform(lead[0]), point) for lead in leads), name
        assert not any(one.overlaps(other) for one, other in combinations(texts.values(), 2))


def dense(line):
    """Points of a polyline at most two pixels apart."""
    pieces = pairwise(line)
    return np.vstack([line, *(np.linspace(a, b, 2 + int(np.hypot(*(b - a)) / 2)) for a, b in pieces)])


@pytest.mark.parametrize("kind", KINDS)
def test_titles_ticks_labels_colour_bar_and_legend_overlap_nowhere_and_are_on_the_sheet(figures, kind):
    figure, _ = figures[kind]
    figure.draw_without_rendering()  # which puts labels where the file has them
    texts = [text for axes in figure.axes for text in (axes.xaxis.label, axes.yaxis.label, axes.title, axes._left_title)]
    texts += [text for axes in figure.axes for axis in (axes.xaxis, axes.yaxis) for text in visible_numbers(axis)]
    texts += [text for legend in figure.legends for text in legend.get_texts()]
    boxes = [(text.get_text(), text.get_window_extent()) for text in texts if text.get_text() and text.get_visible()]
    assert len(boxes) > 10
    for (one, box), (other, beside) in combinations(boxes, 2):
        assert not box.overlaps(beside), f"{one!r} covers {other!r}"
    for text, box in boxes:
        assert np.all(box.min >= 0), text
        assert np.all(box.max <= figure.bbox.max), text


def visible_numbers(axis):
    low, high = sorted(axis.get_view_interval())
    return [tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high and tick.label1.get_visible()]


def test_the_lowest_panels_of_an_overview_have_numbers_even_where_the_last_row_is_not_full(figures):
    numbered = [bool(axes.get_xlabel()) and bool(visible_numbers(axes.xaxis)) for axes in figures["overview"][0].axes[:3]]
    assert numbered == [False, True, True]


def test_the_frame_in_the_main_panel_is_what_the_detail_shows(figures):
    main, detail = figures["instant"][0].axes[:2]
    (frame,) = main.patches
    assert frame.get_bbox().x0 == pytest.approx(detail.get_xlim()[0])
    assert frame.get_bbox().y1 == pytest.approx(detail.get_ylim()[1])
    assert np.all(np.transpose([main.get_xlim(), main.get_ylim()])[0] < frame.get_bbox().min)


def test_drawn_line_passes_through_the_nodes(wing):
    model = wing.system.scene.model("skin.h5", "mesh")
    elastic = wing.q[4, wing.coordinates("skin")]
    nodes = (model.mesh.recovery @ np.append(1.0, elastic)).reshape(-1, 3)[:, :2]
    line = skin_shape(Configuration(wing, 4), "skin").line
    np.testing.assert_allclose(line[:, 0], nodes[:-1], atol=1e-10)  # mm, round-off of coordinates of 100 mm
    np.testing.assert_allclose(line[:, -1], nodes[1:], atol=1e-10)


def test_drawn_line_stays_an_arc_under_a_rigid_rotation_of_the_nodes():
    """A small rotation by eps moves every point of the line by eps times its distance; the elements represent it exactly."""
    from toolkit.reduced_model.model import Mesh
    from toolkit.render.plane.configuration import _displacement

    nodes = np.array([[0.0, 0.0], [2.0, 1.0], [3.0, 3.0]])
    mesh = Mesh(nodes, np.array([[0, 1], [1, 2]]), np.zeros((9, 1)), nodes, nodes)
    nodal = 1e-3 * np.column_stack([-nodes[:, 1], nodes[:, 0], np.ones(3)])
    moved, turned = _displacement(mesh, nodal)
    ratio = np.linspace(0, 1, moved.shape[1])[:, None]
    straight = nodes[:-1, None] * (1 - ratio) + nodes[1:, None] * ratio
    np.testing.assert_allclose(moved, 1e-3 * np.stack([-straight[..., 1], straight[..., 0]], axis=2), atol=1e-15)  # round-off
    np.testing.assert_allclose(turned, 1e-3, rtol=1e-12)


def test_outer_fibre_lies_outside(wing):
    shape = skin_shape(Configuration(wing, 0), "skin")
    nose = np.unravel_index(np.argmin(shape.line[..., 0]), shape.line.shape[:2])
    assert shape.outward[nose][0] < -0.99  # the outside of the foremost point is ahead
    np.testing.assert_allclose(np.linalg.norm(shape.outward, axis=2), 1, rtol=1e-12)


def test_curve_of_the_shape_error_ends_at_the_response(wing):
    rms = np.sqrt((shape_errors(wing, "skin")[-1] ** 2).mean())
    assert rms == pytest.approx(ShapeRMS(body="skin").value(wing), rel=1e-12)  # the same sum in another order


def test_points_of_a_turned_rod_turn_about_its_centre():
    solution = pendulum()
    solution.q[0] = [0.0, 0.5, np.pi / 2]
    moment = Configuration(solution, 0)
    np.testing.assert_allclose(moment.segments("rod"), [[[0, 0], [0, 1]]], atol=1e-15)  # round-off of cos(pi / 2)


def test_labels_are_names_of_points_once_each_whatever_their_joints_are_called(wing):
    assert [name for _, name in names_by_place(Configuration(pendulum(), 0), 1e-6)] == ["O", "P"]
    assert [name for _, name in names_by_place(Configuration(wing, 4), 1e-6)] == ["A", "B", "C", "D", "E", "G"]


def test_points_at_one_place_share_a_label(wing):
    moment = Configuration(wing, 4)
    assert sorted(moment.named_points()) == list("ABCDEG")
    assert [name for _, name in names_by_place(moment, 1e3)] == ["A, B, C, D, E, G"]


def of_kind(moment, kind):
    return [symbol for symbol in symbols(moment) if symbol.kind == kind]


def test_only_a_revolute_on_the_ground_has_a_triangle(wing):
    (support,) = of_kind(Configuration(wing, 4), "support")
    np.testing.assert_allclose(support.point, [72.5, 1.3], rtol=1e-12)  # A, round-off


def bent(scene):
    """A scene with the meshed bracket, turned and bent in made-up states."""
    solution = rest(scene, 2)
    where = solution.coordinates("rod")
    solution.q[:, where.start + 2] = solution.times / solution.times[-1]
    solution.q[:, where.start + 3] = 1e-2 * solution.times / solution.times[-1]
    return solution


@pytest.fixture(scope="module")
def bracket():
    """The meshed bracket."""
    return bent(read_scene(SCENE.parents[1] / "bracket" / "scene.toml"))


@pytest.fixture
def bare(bracket, monkeypatch):
    """The bracket of a model file that does not tell the stress inside."""
    monkeypatch.setattr("toolkit.render.plane.configuration._inside", lambda *_: None)
    return bracket


def test_a_mass_that_is_fixed_to_a_point_is_drawn():
    scene = pendulum().system.scene
    mass = Rigid(mass=1.0, inertia=1.0, center="P")
    joints = {**scene.joints, "glue": RigidJoint(bodies=("rod", "mass"), point="P")}
    solution = rest(scene.model_copy(update={"bodies": {**scene.bodies, "mass": mass}, "joints": joints}), 0)
    (square,) = of_kind(Configuration(solution, 0), "mass")
    np.testing.assert_allclose(square.point, [1.0, 0.0], atol=1e-15)
    assert "mass" in {
        each.get_gid() for each in instant_figure(Configuration(solution, 0), choose_look(solution, [0])).axes[0].collections
    }


def test_a_meshed_body_is_drawn_with_the_stress_inside(bracket):
    """At a free edge in plane stress von Mises' stress is the one along the edge; the error of this mesh is 2 % of the largest."""
    look, moment = choose_look(bracket, [2]), Configuration(bracket, 2)
    shape = solid_shape(moment, "rod")
    inside, middles = shape.inside, shape.edges[:, 2]
    distance, here = cKDTree(inside.points).query(middles)
    assert distance.max() < 1e-9  # round-off of some 100 mm: nodes of the boundary are among those of the inside
    holes = [np.linalg.norm(middles - moment.position("rod", point), axis=1) for point in ("T", "P")]
    free = np.minimum(*holes) > 22  # mm; the edges of the holes are held, and have stress across them
    largest = np.abs(inside.stress).max()
    assert free.sum() > 50
    assert np.abs(shape.stress - inside.stress[here])[free].max() < 0.05 * largest
    figure = instant_figure(moment, look)
    (panel, *_) = figure.axes
    (shades,) = [each for each in panel.collections if isinstance(each, TriMesh)]
    np.testing.assert_array_equal(shades.get_array(), inside.stress)
    assert look.stress_limit >= largest > 0
    assert not [each for each in panel.collections if isinstance(each, LineCollection) and each.get_array() is not None]
    assert [each.get_label() for each in meanings([window(look.points)], look, moment)] == [
        "meshed bodies: von Mises stress, negative in compression"
    ]


def test_names_do_not_cover_the_edge_of_a_meshed_body(bracket):
    moments = [Configuration(bracket, step) for step in (0, 2)]
    for panel, moment in zip(overview_figure(moments, choose_look(bracket, [0, 2])).axes, moments, strict=False):
        edge = np.vstack([dense(panel.transData.transform(line)) for line in solid_shape(moment, "rod").edges])
        for text in panel.texts:
            box = text.get_window_extent()
            assert not np.any((edge > box.min).all(axis=1) & (edge < box.max).all(axis=1)), text.get_text()


def test_stress_inside_follows_the_modulus_and_is_not_drawn_along_a_tangent(bracket):
    scene, known = bracket.system.scene, solid_shape(Configuration(bracket, 2), "rod").inside.components
    path = "bodies.rod.youngs_modulus"
    twice = bent(scene.with_number(path, 2 * scene.number(path)))
    np.testing.assert_allclose(solid_shape(Configuration(twice, 2), "rod").inside.components, 2 * known, rtol=1e-14)
    rod = scene.bodies["rod"].model_copy(update={"extrapolation": "first-order", "poisson_ratio": 0.34})
    other = bent(scene.model_copy(update={"bodies": {**scene.bodies, "rod": rod}}))
    assert solid_shape(Configuration(other, 2), "rod").inside is None


def test_a_meshed_body_is_drawn_with_its_stress_along_its_boundary_where_no_other_is_known(bare):
    bracket = bare
    look, moment = choose_look(bracket, [2]), Configuration(bracket, 2)
    shape = solid_shape(moment, "rod")
    known = np.real(stress_operator(bracket.system.scene, "rod")[:, 0]) @ moment.elastic("rod")
    np.testing.assert_array_equal(shape.stress, known)
    assert look.stress_limit >= np.abs(known).max() > 0
    model = bracket.system.scene.model("body.h5", "outline")
    middles = moment.place("rod", model.outline.position[model.outline.edges[:, 1]] @ np.append(1.0, moment.elastic("rod")))
    np.testing.assert_allclose(shape.edges[:, 2], middles, atol=1e-12)  # round-off of some 100 mm
    figure = instant_figure(moment, look)
    (panel, *_) = figure.axes
    colored = [each for each in panel.collections if isinstance(each, LineCollection) and each.get_array() is not None]
    np.testing.assert_array_equal(colored[0].get_array(), known)
    assert "stress" in panel.get_title("left")
    assert [each.get_label() for each in meanings([window(look.points)], look, moment)] == [
        "stress along the boundary of meshed bodies"
    ]


def test_a_meshed_body_without_stress_is_drawn_without_colours(bare, monkeypatch):
    bracket = bare
    monkeypatch.setattr("toolkit.render.plane.configuration.stress_components", lambda *_: np.zeros((7, 1)))
    look, moment = choose_look(bracket, [2]), Configuration(bracket, 2)
    assert np.isnan(solid_shape(moment, "rod").stress).all()
    assert look.stress_limit == 0
    assert instant_figure(moment, look).axes[0].patches


def test_a_film_has_the_frames_and_the_width_that_were_asked_for(tmp_path, monkeypatch):
    files = render_solution(pendulum(3), tmp_path, width=WIDTH, animate=True, film=True)
    assert [file.name for file in files[-2:]] == ["animation.gif", "animation.mp4"]
    with Image.open(files[-2]) as moving:
        assert (moving.width, moving.n_frames) == (WIDTH, 4)
    told = subprocess.run([get_ffmpeg_exe(), "-i", files[-1]], capture_output=True, text=True, check=False).stderr
    assert re.search(rf"Video: h264.* {WIDTH}x\d+", told)
    assert count_frames_and_secs(str(files[-1])) == (6, 6.0)  # one per second, and the last one stands still for 1.5 s
    monkeypatch.setattr("toolkit.render.packages.find_spec", lambda name: None if name == "imageio_ffmpeg" else name)
    with pytest.raises(RenderError, match=r"ffrf-toolkit\[film\]"):
        render_solution(pendulum(3), tmp_path, film=True)


def test_a_moving_picture_has_colours_that_its_last_frame_lacks():
    paper = Image.new("RGB", (40, 30), "white")
    painted = paper.copy()
    painted.paste((210, 105, 30), (10, 10, 30, 20))
    with Image.open(BytesIO(gif([paper, painted, paper]))) as moving:
        moving.seek(1)
        shown = np.array([moving.convert("RGB").getpixel(place) for place in ((0, 0), (20, 15))])
    np.testing.assert_allclose(shown, [[255, 255, 255], [210, 105, 30]], atol=2)  # 255 colours of an octree


def test_the_symbol_of_a_slider_follows_its_point_and_shows_whether_it_turns(wing):
    (start,), (end,) = (of_kind(Configuration(wing, step), "grounded slider") for step in (0, 4))
    assert end.point[0] - start.point[0] > 1.0  # mm; G moves along the axis
    np.testing.assert_array_equal(end.point, Configuration(wing, 4).position("skin", "G"))
    assert not any(np.array_equal(pin.point, end.point) for pin in of_kind(Configuration(wing, 4), "pin"))  # rotation is locked


def test_the_grounded_frame_is_clamped_where_nothing_moves(wing):
    (clamp,) = of_kind(Configuration(wing, 4), "clamp")
    np.testing.assert_array_equal(clamp.point, wing.system.scene.model("skin.h5", "mesh").mesh.nodes[0])  # F


def test_a_cut_skin_is_clamped_where_the_whole_one_is(wing):
    cut = rest(read_scene(SCENE, {"bodies.skin.frames": "2"}), 0)
    ((body, points),) = clamps(Configuration(cut, 0)).items()
    assert body == "skin"
    np.testing.assert_allclose(points, clamps(Configuration(wing, 0))["skin"], rtol=1e-12)  # round-off
    assert len(of_kind(Configuration(cut, 0), "clamp")) == 1


def test_a_named_point_without_a_joint_is_a_dot_and_a_body_is_named_between_its_points():
    moment = Configuration(rest(read_scene(SCENE.parents[1] / "slider_crank" / "scene.toml"), 0), 0)
    (end,) = of_kind(moment, "point")
    np.testing.assert_allclose(end.point, moment.named_points()["W"], rtol=1e-12)  # round-off
    places = moment.named_points()
    np.testing.assert_allclose(body_places(moment)["crank"], (places["O"] + places["H"]) / 2, atol=1e-15)  # H is half-way to T
    np.testing.assert_allclose(body_places(Configuration(pendulum(), 0))["rod"], [0.5, 0.0], atol=1e-15)


def test_a_body_is_named_where_it_is_far_from_others():
    """Rods of 3 and 2 m that leave a pin at an angle of 15 degrees: each is named near its end, the long one beyond that of the other.

    When the other is gone it is named in its middle, but for a motion in which it keeps one place.
    """
    ends = {"O": (0.0, 0.0), "long": (3.0, 0.0), "short": (2 * np.cos(np.pi / 12), 2 * np.sin(np.pi / 12))}
    bodies = {name: Rod(between=("O", name), area=1e-4, density=1.0) for name in ("long", "short")}
    joints = {name: Revolute(bodies=(name, "ground"), point="O") for name in bodies}
    points = {name: Point(x=float(x), y=float(y)) for name, (x, y) in ends.items()}
    scene = Scene(units="m-kg-s", points=points, bodies=bodies, joints=joints, solver={"end_time": 1.0, "step": 0.1})
    solution = rest(scene, 1)
    solution.q[1, solution.coordinates("short")] += 10.0
    near, far = (Configuration(solution, step) for step in range(2))
    np.testing.assert_allclose(body_places(far)["long"], [1.5, 0.0], atol=1e-12)
    np.testing.assert_allclose(body_places(far, motion=(near, far))["long"], [2.4, 0.0], atol=1e-12)
    found = body_places(near)
    np.testing.assert_allclose(found["long"], [2.4, 0.0], atol=1e-12)
    np.testing.assert_allclose(found["short"], np.array(ends["short"]) * 0.8, rtol=1e-12)


def test_a_spring_is_a_zigzag_between_its_points():
    solution = rest(read_scene(SCENE.parents[1] / "slider_crank" / "scene.toml"), 0)
    drawn = instant_figure(moment := Configuration(solution, 0), choose_look(solution, [0])).axes[0].collections
    ((path,),) = [each.get_paths() for each in drawn if each.get_gid() == "springs"]
    ends = np.array([moment.named_points()[name] for name in ("H", "M")])
    np.testing.assert_allclose(path.vertices[[0, -1]], ends, atol=1e-12)
    off = path.vertices[:, 1] - ends[0, 1]  # the spring lies along x
    assert off.max() == pytest.approx(-off.min())
    assert 0 < off.max() < 0.1 * np.ptp(ends[:, 0])
    assert np.all(np.diff(path.vertices[:, 0]) > 0)


def test_an_undeformed_line_is_drawn_where_a_body_leaves_it(wing):
    assert choose_look(wing, [0, 4]).left == ("skin",)
    look = choose_look(wing, [0])
    assert look.left == ()
    assert [label for label, *_ in outlines(Configuration(wing, 0), "skin", look)] == ["target"]


def test_the_thickness_of_a_frame_is_that_of_its_sections():
    scene = read_scene(SCENE.parents[1] / "flexible_crank" / "scene.toml")
    assert choose_look(rest(scene, 0), [0]).thickness == {"crank": scene.number("bodies.crank.thickness_bar")}


def test_a_slider_on_a_moving_body_turns_with_it():
    solution = rest(hanging_skin(), 0)
    solution.q[0, solution.coordinates("arm").start + 2] = np.pi / 2
    (slider,) = of_kind(Configuration(solution, 0), "slider")
    np.testing.assert_allclose(slider.direction, np.array([-0.3, 1.0]) / np.hypot(1.0, 0.3), atol=1e-15)  # round-off of cos
    np.testing.assert_array_equal(slider.point, [-30.0, 10.0])  # where the block is, not where the arm has turned to
    rail = slider.lines(1.0)[1]
    assert np.diff(rail, axis=0)[0] @ slider.direction == pytest.approx(np.linalg.norm(np.diff(rail, axis=0)))


def test_a_scene_with_a_moving_frame_is_drawn(tmp_path):
    files = render_solution(rest(hanging_skin(), 1), tmp_path, [0.0, 1.0], width=WIDTH)
    assert [file.name for file in files] == ["step-0.png", "step-1.png", "overview.png", "curves.png"]


def test_a_flexible_body_without_a_mesh_is_a_line_through_its_interface_points(tmp_path):
    write_models(tmp_path)
    save(replace(load(tmp_path / "beam.h5"), mesh=None), tmp_path / "beam.h5")
    solution = rest(CASES[0].scene(tmp_path), 0)
    (chain,) = Configuration(solution, 0).segments("skin")
    place = solution.system.scene.position
    np.testing.assert_allclose(chain[0], place("S"), rtol=1e-12)  # round-off of two rotations
    assert chain.shape == (2, 2)
    assert distinct_colors(image(render_solution(solution, tmp_path, width=WIDTH)[0])) > 20  # smoothed lines on white


def test_the_legend_tells_where_the_skin_is_thicker_than_it_is(wing):
    moment, look = Configuration(wing, 4), choose_look(wing, [4])
    wide, near = (np.array([[0.0, 0.0], size]) for size in ((200.0, 100.0), (40.0, 20.0)))

    def words(*windows):
        return [entry.get_label() for entry in meanings(windows, look, moment)]

    assert words(wide)[:2] == ["undeformed", "target"]
    assert "thickness 2.1-fold" in words(wide)[2]  # 1.5 mm would be less than a hundredth of 200 mm, and 1.6 hundredths are seen
    assert "thickness 2.1-fold, in the detail to scale" in words(wide, near)[2]
    assert words(near)[2].endswith("thickness to scale")
    assert "thickness not to scale" in [*meanings([wide], replace(look, thickness={"skin": 0.0}), moment)][2].get_label()


def test_numbers_of_one_quantity_have_the_same_decimals():
    assert [even(value, 0.6) for value in (-13.13, 13.0, -0.01, 56.78)] == ["-13.1", "13.0", "0.0", "56.8"]
    assert [even(value, 1.4e-3) for value in (3.4412, 0.33)] == ["3.441", "0.330"]
    assert [even(-1.31e7, 6e5), even(1.31e-7, 1e-9)] == ["-1.31e+07", "1.31e-07"]  # Pa, m


def test_where_nothing_turns_curves_show_how_far_points_have_moved():
    scene = read_scene(SCENE.parents[1] / "pendulum" / "scene.toml", {"solver.end_time": "0.05"})
    solution = simulate(compile_scene(scene))
    (panel,) = curves_figure(solution).axes
    (line,) = panel.lines
    fall = 9.81 * 0.05**2 / 2  # from the horizontal, where the rod does not hold it yet
    assert (panel.get_ylabel(), line.get_label()) == ("motion of points in m", "P")
    assert line.get_ydata()[-1] == pytest.approx(
        fall, rel=fall
    )  # an arc: it bends by as much of the fall as that is of the radius


def test_a_point_that_moves_by_round_off_has_no_curve():
    def at(way):
        points = {"P": np.array([way, 0.0]), "Q": np.array([1.0 + 1e-16 * way, 0.0]), "R": np.array([2.0, 1e-10 * way])}
        return SimpleNamespace(
            named_points=lambda: points, solution=SimpleNamespace(system=SimpleNamespace(scene=SimpleNamespace(size=2.0)))
        )

    ((_, _, curves),) = motion_panels(at(0.0).named_points(), [at(0.0), at(1.0)])
    assert list(curves) == ["P"]


def test_curves_that_coincide_share_a_name():
    curves = {"a": np.array([0.0, 1.0]), "b": np.array([0.0, 0.5]), "c": np.array([1e-12, 1.0])}
    assert list(merged(curves)) == ["a, c", "b"]
    assert list(merged({"still": np.zeros(2), "too": np.zeros(2)})) == ["still, too"]


def test_a_curve_that_the_line_of_zero_hides_is_none():
    curves = {"a": np.array([0.0, 1.0]), "b": np.array([0.0, 9e-4]), "c": np.array([0.0, -2e-3])}
    assert list(told(curves)) == ["a", "c"]
    assert list(told({"still": np.zeros(2), "too": np.zeros(2)})) == ["still", "too"]


def test_the_main_window_holds_the_detail_and_all_points(wing):
    look = choose_look(wing, [1, 2, 3, 4])
    (low, high), detail = instant_windows(look)
    for points in (look.points, detail):
        assert np.all((points > low) & (points < high))


def test_labels_keep_clear_of_lines_and_of_each_other():
    wall = np.column_stack([np.full(200, 100.0), np.linspace(0, 200, 200)])
    half = np.array([10.0, 5.0])
    names = [Name("one", np.array([100.0, 100.0]), half), Name("two", np.array([100.0, 110.0]), half)]
    panel = Panel(names, wall, np.array([200.0, 200.0]))
    places = np.array([each.place for each in placed(panel, sides([panel], 10.0))])
    assert np.all(np.abs(places[:, 0] - 100) > half[0])
    assert np.any(np.abs(places[0] - places[1]) > 2 * half)


def test_a_window_holds_all_points_with_a_margin_and_is_never_a_slit():
    points = np.array([[0.0, 0.0], [2.0, 1.0]])
    low, high = window(points)
    assert np.all((points > low) & (points < high))
    for line in (np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([[0.0, 0.0], [0.0, 1.0]]), np.zeros((1, 2))):
        assert np.all(np.ptp(window(line), axis=0) >= 0.2)


def test_ticks_and_limits_of_colours_are_round_numbers():
    assert [tick_step(least) for least in (0.9, 1.1, 13.0, 0.03)] == pytest.approx([1, 2, 20, 0.05])
    assert [round_up(value) for value in (0.0, 56.8, 1.1e-3)] == pytest.approx([0, 60, 1.2e-3])


def test_importing_the_pictures_imports_no_drawing_and_a_planar_scene_is_drawn_where_vtk_cannot_be_imported(tmp_path):
    code = (
        "import sys\n"
        "from toolkit.render.pictures import refuse_what_cannot_be_drawn, render_solution\n"
        "print({'pyvista', 'vtkmodules', 'matplotlib'} & sys.modules.keys())\n"
        "sys.modules['pyvista'] = sys.modules['vtkmodules'] = None\n"
        "from tests.models.pictures import rest\n"
        "from toolkit.render.readable_units import View\n"
        "from toolkit.files.scene_reader import read_scene\n"
        "solution = rest(read_scene('models/pendulum/scene.toml'), 1)\n"
        "refuse_what_cannot_be_drawn(solution.system.scene, View())\n"
        f"print(len(render_solution(solution, {str(tmp_path)!r}, animate=True)))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=SCENE.parents[2], capture_output=True, text=True, check=False)
    assert done.stdout == "set()\n3\n", done.stderr  # a pendulum at rest needs no second picture
    assert {file.suffix for file in tmp_path.iterdir() if file.name != OWN} == {".png", ".gif"}


def test_a_picture_is_as_wide_as_asked_for(figures, tmp_path):
    write_figure(figures["rods"][0], tmp_path / "rods.png", 1234 / WIDE)
    assert image(tmp_path / "rods.png").shape[1] == 1234


def test_a_dollar_in_a_name_starts_no_formula(tmp_path):
    """`$^$` would be one that cannot be drawn."""
    points = {"O$^$": Point(x=0.0, y=0.0), "P": Point(x=1.0, y=0.0)}
    scene = Scene(units="m-kg-s", points=points, bodies={"rod$^$": Rod(between=("O$^$", "P"), area=1e-4, density=1e3)})
    files = render_solution(rest(scene, 1), tmp_path, width=WIDTH)
    assert [file.name for file in files][-1] == "curves.png"


def nowhere(_step: int) -> np.ndarray:
    """Nothing is drawn."""
    return np.zeros((0, 2))


MOTIONS = {
    "steady": lambda part: [3 * part, 0],
    "at rest after a tenth": lambda part: [min(10 * part, 1), 0],
    "eight turns, of which pictures evenly spread show one angle": lambda part: [
        np.cos(16 * np.pi * part),
        np.sin(16 * np.pi * part),
    ],
}


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_pictures_of_a_motion_differ_and_end_with_it(motion):
    steps = telling_steps(4, lambda step: np.array([[0.0, 0.0], motion(step / 1000)]), np.zeros(1001))
    assert (len(steps), steps[-1]) == (4, 1000)
    assert (steps[0] == 0) == (motion(0.0) != pytest.approx(motion(1.0)))  # a start that looks like the end is not drawn
    places = np.array([motion(step / 1000) for step in steps])
    apart = np.linalg.norm(places[:, None] - places, axis=2)[np.triu_indices(4, 1)]
    assert apart.min() > 0.2 * np.ptp(places, axis=0).max()  # four of a line at best a third, of a circle 0.7


def test_the_peak_of_the_stress_and_the_farthest_place_are_drawn_wherever_they_are():
    """A point that swings out and back, and a stress of one step alone, which none of the instants that are compared is."""
    stress = np.zeros(1001)
    stress[371] = 7.0
    steps = telling_steps(4, lambda step: np.array([[0.0, 0.0], [np.sin(np.pi * step / 1000), 0.0]]), stress)
    assert {371, 496, 1000} <= set(steps)  # of the 120 steps that are compared 496 is the next to the middle
    assert 371 in telling_steps(2, lambda _: np.ones((2, 2)), stress)


@pytest.mark.parametrize("shaking", [0.0, 1e-15])
def test_a_scene_that_rests_is_drawn_at_its_end(shaking):
    assert telling_steps(4, lambda step: np.ones((2, 2)) + shaking * (-1) ** step, np.zeros(11)) == [10]


def test_what_stands_in_the_window_is_the_whole_motion(wing):
    only_start = choose_look(wing, [0])
    assert np.ptp(only_start.points, axis=0) == pytest.approx(np.ptp(choose_look(wing, [0, 2, 4]).points, axis=0))


@pytest.mark.parametrize(
    ("number", "label", "written"),
    [
        (9.74e6, "Pa", (9.74, "MPa")),
        (56.8, "MPa", (56.8, "MPa")),
        (2.1e5, "MPa", (210, "GPa")),
        (3.3e-4, "m", (0.33, "mm")),
        (0.33, "mm", (0.33, "mm")),
        (0.5, "Pa", (0.5, "Pa")),
        (1e-5, "mm", (1e-5, "mm")),
        (7e6, "N mm", (7, "kN m")),
        (0.0, "Pa", (0.0, "Pa")),
        (1e7, "rad/s", (1e7, "rad/s")),
    ],
)
def test_numbers_in_pictures_are_short(number, label, written):
    factor, shown = readable(number, label)
    assert (factor * number, shown) == (pytest.approx(written[0], rel=1e-12), written[1])


def test_instants_are_the_nearest_steps_each_once(wing):
    assert chosen_steps(wing, nowhere, [1.0, 0.24, 0.26]) == [1, 4]
    assert chosen_steps(pendulum(), nowhere, None) == [0]


def test_an_instant_outside_the_solution_is_refused(wing):
    with pytest.raises(InputError, match=r"t = 1\.5: the solution runs from 0 to 1"):
        chosen_steps(wing, nowhere, [1.5])


@pytest.fixture
def no_screen(monkeypatch):
    """A Linux machine without a screen, whatever this one is, on which nothing has been drawn yet."""
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(probe, "_DRAWN", {})
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv(probe.VARIABLE, raising=False)


def missing(monkeypatch):
    """Let the trial look for libraries that do not exist; the rest of it is real."""
    monkeypatch.setattr(probe, "LIBRARIES", {"vtkEGLRenderWindow": "libEGL-absent.so.1"})


def test_missing_library_is_an_error_that_names_the_debian_packages(no_screen, monkeypatch):
    missing(monkeypatch)
    with pytest.raises(RenderError, match="libEGL-absent") as caught:
        drawing_environment()
    assert "apt-get install libegl1 libgl1-mesa-dri" in str(caught.value)
    assert isinstance(caught.value, ToolkitError)


def test_crash_of_the_trial_is_an_error_and_not_a_crash(no_screen, monkeypatch):
    monkeypatch.setattr(probe, "_TRIAL", "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)")
    with pytest.raises(RenderError, match=r"crashed with signal 11.*libegl1 libgl1-mesa-dri"):
        drawing_environment()


def test_empty_trial_picture_is_an_error(no_screen, monkeypatch):
    monkeypatch.setattr(probe, "_TRIAL", "import sys; sys.exit('the picture is empty')")
    with pytest.raises(RenderError, match="the picture is empty"):
        drawing_environment()


def test_endless_trial_is_an_error(no_screen, monkeypatch):
    monkeypatch.setattr(probe, "_TRIAL", "import time; time.sleep(60)")
    monkeypatch.setattr(probe, "_PATIENCE", 0.1)
    with pytest.raises(RenderError, match=r"no picture after 0\.1 s"):
        drawing_environment()


def test_missing_packages_are_errors_that_name_the_extra(monkeypatch, wing, tmp_path):
    monkeypatch.setattr("toolkit.render.packages.find_spec", lambda name: None)
    with pytest.raises(RenderError, match=r"pip install 'ffrf-toolkit\[render\]'"):
        drawing_environment()
    with pytest.raises(RenderError, match="pictures need matplotlib"):
        render_solution(wing, tmp_path / "pictures", width=WIDTH)
    assert not (tmp_path / "pictures").exists()


@pytest.mark.parametrize("display", [None, ":7"])
def test_trial_runs_in_a_subprocess_and_prefers_the_screen(no_screen, monkeypatch, display):
    seen = []

    def run(command, **options):
        seen.append((command, options["env"].get(probe.VARIABLE)))
        return subprocess.CompletedProcess(command, 0, "", "")

    monkeypatch.setattr(probe.subprocess, "run", run)
    if display:
        monkeypatch.setenv("DISPLAY", display)
    window = None if display else "vtkEGLRenderWindow"
    with drawing():
        assert probe.os.environ.get(probe.VARIABLE) == window
    assert probe.VARIABLE not in probe.os.environ  # the choice is for this task only
    assert [(command[0], chosen) for command, chosen in seen] == [(sys.executable, window)]


def test_first_window_that_works_is_taken(no_screen, monkeypatch):
    monkeypatch.setattr(probe, "_trial", lambda tried: None if "OSOpenGL" in tried[probe.VARIABLE] else "no")
    assert drawing_environment() == {probe.VARIABLE: "vtkOSOpenGLRenderWindow"}
    monkeypatch.setattr(probe, "_trial", None)
    assert drawing_environment() == {probe.VARIABLE: "vtkOSOpenGLRenderWindow"}  # what has worked is not tried again


@pytest.mark.parametrize(("values", "span"), [(1e-15, 0.05), (2.0, 0.3), (0.0, 0.05)])
def test_round_off_is_no_scale_of_a_curve(values, span):
    """A body that rests, or is held at an angle, but for the last digits of its rotation."""
    solution = pendulum(4)
    solution.q[:, 2] = values * (1 + 1e-15 * (-1.0) ** np.arange(5))
    (panel,) = curves_figure(solution).axes
    assert np.diff(panel.get_ylim())[0] > span
    if values < 1:
        assert not np.any(panel.lines[0].get_ydata())
