"""Pictures: what is drawn has the numbers of the solution, and a machine without OpenGL gets a message instead of a crash."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import toolkit.render.probe as probe
from tests.cases import CASES, write_models
from tests.pictures import distinct_colors, image, rest, skip_where_nothing_draws
from tests.scenes import hanging_skin
from toolkit.bodies.planar.rigid import Rod
from toolkit.description.point import Point
from toolkit.foundation.errors import InputError, ToolkitError
from toolkit.joints.planar.revolute import Revolute
from toolkit.loads.planar.gravity import Gravity
from toolkit.reduced_model.file import load, save
from toolkit.render.moment import names_by_place
from toolkit.render.panel import Panel, Window, multiples, tick_step
from toolkit.render.pictures import chosen_steps, render_solution
from toolkit.render.plane.configuration import Configuration
from toolkit.render.plane.curves import merged, shape_errors, stress_range
from toolkit.render.plane.labels import label_places
from toolkit.render.plane.look import choose_look
from toolkit.render.plane.scene_picture import even, instant_windows, meanings
from toolkit.render.plane.skin_mesh import skin_mesh
from toolkit.render.plane.skin_shape import skin_shape
from toolkit.render.plane.symbols import symbols
from toolkit.render.probe import RenderError, drawing, drawing_environment
from toolkit.responses.shape_error import ShapeRMS
from toolkit.responses.stress.stress import MaxStress, stress_field
from toolkit.scene.scene import Scene
from toolkit.scene_file.reader import read_scene

SCENE = Path(__file__).parents[1] / "models" / "morphing_wing" / "scene.toml"
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


@pytest.fixture(scope="module")
def opengl():
    skip_where_nothing_draws()


def test_every_instant_the_overview_and_the_curves_are_written(opengl, wing, tmp_path):
    files = render_solution(wing, tmp_path / "new", instants=[0.5, 1.0], width=WIDTH)
    assert [file.name for file in files] == ["step-2.png", "step-4.png", "overview.png", "curves.png"]
    assert sorted(files) == sorted((tmp_path / "new").iterdir())  # no temporary file is left
    for file in files:
        pixels = image(file)
        assert pixels.shape[1] == WIDTH
        assert distinct_colors(pixels) > 100  # a colour bar and smoothed lines; an empty sheet has one
    assert not np.array_equal(image(files[0]), image(files[1]))


def test_a_scene_without_flexible_bodies_is_drawn_in_one_picture(opengl, tmp_path):
    files = render_solution(pendulum(), tmp_path, width=WIDTH)
    assert [file.name for file in files] == ["step-0.png"]
    assert distinct_colors(image(files[0])) > 20  # a shaded tube on white


def test_an_interrupted_picture_leaves_the_old_one(opengl, wing, tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    (tmp_path / "step-4.png").write_bytes(b"old")
    import toolkit.render.plane.scene_picture

    monkeypatch.setattr(toolkit.render.plane.scene_picture, "draw_instant", interrupted)
    with pytest.raises(KeyboardInterrupt):
        render_solution(wing, tmp_path, instants=[1.0], width=WIDTH)
    assert [file.read_bytes() for file in tmp_path.iterdir()] == [b"old"]


def test_drawn_stress_has_the_range_of_the_response(wing):

    moment = Configuration(wing, 4)
    drawn = skin_mesh(skin_shape(moment, "skin"), 1.5, "stress", 0.0).point_data["stress"]
    largest = MaxStress(body="skin", when="end").value(wing)
    smallest = stress_field(wing, "skin")[0][-1].min()
    np.testing.assert_allclose([drawn.min(), drawn.max()], [smallest, largest], rtol=1e-12)  # round-off of the interpolation
    np.testing.assert_allclose(stress_range(wing, "skin")[4], [smallest, largest], rtol=1e-12)
    assert largest <= choose_look(wing, [4]).stress_limit < 2 * max(largest, -smallest)


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
    from toolkit.render.plane.skin_shape import _displacement

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


def test_the_symbol_of_a_slider_follows_its_point_and_shows_whether_it_turns(wing):
    (start,), (end,) = (of_kind(Configuration(wing, step), "grounded slider") for step in (0, 4))
    assert end.point[0] - start.point[0] > 1.0  # mm; G moves along the axis
    np.testing.assert_array_equal(end.point, Configuration(wing, 4).position("skin", "G"))
    assert not any(np.array_equal(pin.point, end.point) for pin in of_kind(Configuration(wing, 4), "pin"))  # rotation is locked


def test_the_grounded_frame_is_clamped_where_nothing_moves(wing):
    (clamp,) = of_kind(Configuration(wing, 4), "clamp")
    np.testing.assert_array_equal(clamp.point, wing.system.scene.model("skin.h5", "mesh").mesh.nodes[0])  # F


def test_a_slider_on_a_moving_body_turns_with_it():
    solution = rest(hanging_skin(), 0)
    solution.q[0, solution.coordinates("arm").start + 2] = np.pi / 2
    (slider,) = of_kind(Configuration(solution, 0), "slider")
    np.testing.assert_allclose(slider.direction, np.array([-0.3, 1.0]) / np.hypot(1.0, 0.3), atol=1e-15)  # round-off of cos
    np.testing.assert_array_equal(slider.point, [-30.0, 10.0])  # where the block is, not where the arm has turned to
    rail = slider.lines(1.0)[1]
    assert np.diff(rail, axis=0)[0] @ slider.direction == pytest.approx(np.linalg.norm(np.diff(rail, axis=0)))


def test_a_scene_with_a_moving_frame_is_drawn(opengl, tmp_path):
    files = render_solution(rest(hanging_skin(), 1), tmp_path, width=WIDTH)
    assert [file.name for file in files] == ["step-0.png", "step-1.png", "overview.png", "curves.png"]


def test_a_flexible_body_without_a_mesh_is_a_line_through_its_interface_points(opengl, tmp_path):
    write_models(tmp_path)
    save(replace(load(tmp_path / "beam.h5"), mesh=None), tmp_path / "beam.h5")
    solution = rest(CASES[0].scene(tmp_path), 0)
    (chain,) = Configuration(solution, 0).segments("skin")
    place = solution.system.scene.position
    np.testing.assert_allclose(chain[0], place("S"), rtol=1e-12)  # round-off of two rotations
    assert chain.shape == (2, 2)
    assert distinct_colors(image(render_solution(solution, tmp_path, width=WIDTH)[0])) > 20  # shaded tubes on white


def test_the_legend_tells_where_the_skin_is_thicker_than_it_is(wing):
    moment, look = Configuration(wing, 4), choose_look(wing, [4])
    wide, near = (Panel(None, 1, (0, 0, 800, 400), 20, Window(np.zeros(2), np.array(size))) for size in ((200, 100), (40, 20)))

    def words(*panels):
        return [text for text, _ in meanings(panels, look, moment) if "thickness" in text]

    assert words(wide) == ["thickness not to scale"]  # 1.5 mm would be 6 pixels
    assert words(wide, near) == ["thickness to scale in the detail only"]
    assert words(near) == []  # 30 pixels


def test_numbers_of_one_quantity_have_the_same_decimals():
    assert [even(value, 0.6) for value in (-13.13, 13.0, -0.01, 56.78)] == ["-13.1", "13.0", "0.0", "56.8"]
    assert [even(value, 1.4e-3) for value in (3.4412, 0.33)] == ["3.441", "0.330"]
    assert [even(-1.31e7, 6e5), even(1.31e-7, 1e-9)] == ["-1.31e+07", "1.31e-07"]  # Pa, m


def test_curves_that_coincide_share_a_name():
    curves = {"a": np.array([0.0, 1.0]), "b": np.array([0.0, 0.5]), "c": np.array([1e-12, 1.0])}
    assert list(merged(curves)) == ["a, c", "b"]
    assert list(merged({"still": np.zeros(2), "too": np.zeros(2)})) == ["still, too"]


def test_the_frame_of_the_detail_lies_inside_the_main_panel(wing):
    look = choose_look(wing, [1, 2, 3, 4])
    main, detail = instant_windows(look, 1.6, 0.9)
    assert np.all(main.contains(detail.outline))
    assert np.all(main.contains(look.points))


def test_labels_keep_clear_of_lines_and_of_each_other():
    wall = np.column_stack([np.full(200, 100.0), np.linspace(0, 200, 200)])
    points = np.array([[100.0, 100.0], [100.0, 110.0]])
    places = label_places(points, ["one", "two"], wall, 10.0, np.array([200.0, 200.0]))
    half_width = 10.0  # (0.3 * 3 + 0.1) letters of 10 pixels
    assert np.all(np.abs(places[:, 0] - 100) > half_width)
    assert np.any(np.abs(places[0] - places[1]) > [2 * half_width, 10.0])


def test_window_holds_all_points_at_the_wanted_aspect():
    window = Window.around(np.array([[0.0, 0.0], [2.0, 1.0]]), 1.0, 0.1)
    assert np.all(window.contains(np.array([[0.0, 0.0], [2.0, 1.0]])))
    assert window.size[0] == pytest.approx(window.size[1])
    assert window.size[0] == pytest.approx(2.4)


def test_ticks_are_round_numbers():
    assert [tick_step(least) for least in (0.9, 1.1, 13.0, 0.03)] == pytest.approx([1, 2, 20, 0.05])
    np.testing.assert_array_equal(multiples(-3.0, 10.0, 5.0), [0.0, 5.0])


def test_instants_are_the_nearest_steps_each_once(wing):
    assert chosen_steps(wing, None) == [1, 2, 3, 4]
    assert chosen_steps(wing, [1.0, 0.24, 0.26]) == [1, 4]
    assert chosen_steps(pendulum(), None) == [0]


def test_an_instant_outside_the_solution_is_refused(wing):
    with pytest.raises(InputError, match=r"t = 1\.5: the solution runs from 0 to 1"):
        chosen_steps(wing, [1.5])


@pytest.fixture
def no_screen(monkeypatch):
    """A Linux machine without a screen, whatever this one is."""
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv(probe.VARIABLE, raising=False)


def missing(monkeypatch):
    """Let the trial look for libraries that do not exist; the rest of it is real."""
    monkeypatch.setattr(probe, "LIBRARIES", {"vtkEGLRenderWindow": "libEGL-absent.so.1"})


def test_missing_library_is_an_error_that_names_the_debian_packages(no_screen, monkeypatch, wing, tmp_path):
    missing(monkeypatch)
    with pytest.raises(RenderError, match="libEGL-absent") as caught:
        render_solution(wing, tmp_path / "pictures", width=WIDTH)
    assert "apt-get install libegl1 libgl1-mesa-dri" in str(caught.value)
    assert isinstance(caught.value, ToolkitError)
    assert not (tmp_path / "pictures").exists()


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


def test_missing_pyvista_is_an_error_that_names_the_extra(monkeypatch):
    monkeypatch.setattr(probe, "find_spec", lambda name: None)
    with pytest.raises(RenderError, match=r"pip install 'ffrf-toolkit\[render\]'"):
        drawing_environment()


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


def test_importing_the_pictures_does_not_import_pyvista():
    command = "import sys, toolkit.render.pictures; sys.exit('pyvista' in sys.modules or 'matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", command], cwd=SCENE.parents[2], check=False).returncode == 0
