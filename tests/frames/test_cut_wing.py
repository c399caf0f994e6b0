"""The reference wing with several frames: what one frame leaves out of its values, and what it makes of its gradients."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ffrf
from preprocessing import build
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.conversion import converted_model
from toolkit.reduced_model.file import load, save
from toolkit.render.plane.configuration import Configuration, skin_shape
from toolkit.responses.shape_error import cut_positions
from toolkit.scene.scene import Scene

WING = Path(__file__).parents[2] / "models" / "morphing_wing"
VARIABLES = ["t_w", "M_t", "x_A", "y_A", "bodies.skin.chord"]


def wing(frames: Any, folder: Path = WING, **more: Any) -> Scene:
    scene = ffrf.read_scene(WING / "scene.toml", {f"bodies.skin.{key}": str(value) for key, value in more.items()})
    cut = scene.bodies["skin"].model_copy(update={"frames": frames})
    return scene.model_copy(update={"bodies": {**scene.bodies, "skin": cut}, "directory": folder})


@pytest.fixture(scope="module")
def runs() -> dict[int, Any]:
    """Equilibria with gradients by frames; 30 are one to every element, which then turns as a corotational one."""
    return {n: ffrf.compile(wing(n), variables=VARIABLES).statics(gradients=True) for n in (1, 4, 15, 30)}


def test_values_and_gradients_converge_to_those_of_elements_that_turn(runs):
    """4 frames give the shape error to 1 %, 15 to 0.1 %; the error falls with the square of their number."""
    true = runs[30]
    for response in ("shape_rmse", "drive_angle", "max_stress_true"):
        one, few, many = (abs(runs[n].values[response] / true.values[response] - 1) for n in (1, 4, 15))
        assert one > 0.01
        assert few < 0.01
        assert many < 0.001
    for name, tolerance in (("t_w", 0.03), ("M_t", 0.03)):
        slopes = {n: run.gradients["shape_rmse"][name] for n, run in runs.items()}
        assert abs(slopes[1] / slopes[30] - 1) > 0.4  # one frame is off by nearly half
        assert abs(slopes[4] / slopes[30] - 1) < tolerance
        assert abs(slopes[15] / slopes[30] - 1) < tolerance / 10


def test_one_frame_has_the_wrong_sign_of_the_gradient_by_the_linkage(runs):
    """d RMS / d x_A and d RMS / d y_A: an optimiser would walk the wrong way."""
    for name in ("x_A", "y_A"):
        assert runs[1].gradients["shape_rmse"][name] > 0.03
        assert all(runs[n].gradients["shape_rmse"][name] < -0.03 for n in (4, 15, 30))


def test_the_number_of_frames_agrees_with_parts_tied_to_one_end(runs):
    """Of other bodies, with frames at their first nodes and joints between: 30 of them, one to an element, measured apart."""
    tied = {"drive_angle": 0.496148, "shape_rmse": 0.2959}
    for response, value in tied.items():
        assert runs[30].values[response] == pytest.approx(value, rel=5e-4)  # what is left of one element tied to its end


def test_gradients_by_the_geometry_are_those_of_models_built_afresh(runs, tmp_path):
    """By the chord of the airfoil, which moves every node, against central differences of new meshes."""
    step, found = 550.0 * 1e-4, []
    for sign in (1, -1):
        save(build(WING / "skin.toml", values={"chord": 550.0 + sign * step}), tmp_path / "skin.h5")
        found.append(ffrf.compile(wing(4, tmp_path)).statics().values)
    for response, slopes in runs[4].gradients.items():
        difference = (found[0][response] - found[1][response]) / (2 * step)
        assert slopes["bodies.skin.chord"] == pytest.approx(
            difference, rel=2e-5
        )  # the step's square, and statics to 1e-10 over it


def test_the_tangent_of_the_geometry_is_followed_as_far_as_parts_keep_their_stiffness(runs):
    """It differs from the exact gradient by what is of second order; beyond, the model is refused before anything is solved."""
    tangent = {"extrapolation": '"first-order"'}
    changes = []
    for step in (2e-4, 1e-4):
        near = ffrf.compile(wing(4, chord=550.0 * (1 + step), **tangent)).statics().values["drive_angle"]
        linear = runs[4].values["drive_angle"] + runs[4].gradients["drive_angle"]["bodies.skin.chord"] * 550.0 * step
        changes.append(near - linear)
    assert changes[0] == pytest.approx(4 * changes[1], rel=0.05)
    with pytest.raises(InputError, match=r"following the tangent in chord, the stiffness .* is no longer positive definite"):
        ffrf.compile(wing(2, chord=1.05 * 550.0, **tangent)).statics()


def test_reduced_parts_of_the_wing_bend_as_all_coordinates_do(runs):
    """Its loads act at points that are kept, so that no mode is missed; shapes between are of the design, which a complex step judges: by
    the thickness, which their curvature makes them depend on, and the chord."""
    scene = wing(4)
    skin = scene.bodies["skin"].model_copy(update={"modes_per_frame": 0})
    model = ffrf.compile(
        scene.model_copy(update={"bodies": {**scene.bodies, "skin": skin}}), variables=["t_w", "bodies.skin.chord"]
    )
    few, judge = (model.statics(gradients=method) for method in ("direct", "complex-step"))
    assert few.solution.q.shape[1] < runs[4].solution.q.shape[1] / 1.5
    for response, value in runs[4].values.items():
        assert few.values[response] == pytest.approx(value, rel=1e-8), response  # statics end at 1e-10 of the size
        for name, slope in judge.gradients[response].items():
            assert few.gradients[response][name] == pytest.approx(slope, rel=1e-9), (response, name)
            if response not in ("shape_max_error", "max_stress"):  # a smooth maximum weighs the round-off of places
                assert slope == pytest.approx(runs[4].gradients[response][name], rel=1e-6), (response, name)


def test_parts_are_the_same_in_other_units(runs, tmp_path):
    """Lengths in m: the file's elements are converted with it."""
    save(converted_model(load(WING / "skin.h5"), "m-kg-s"), tmp_path / "skin.h5")
    elements, other = load(WING / "skin.h5").elements, load(tmp_path / "skin.h5").elements
    assert elements is not None
    assert other is not None
    u = np.tile([1.0, 2.0, 0.3], 2)
    energy = [each @ u @ u for each in elements.stiffness]
    v = np.tile([1e-3, 2e-3, 0.3], 2)
    np.testing.assert_allclose([each @ v @ v for each in other.stiffness], np.array(energy) * 1e-3, rtol=1e-12)  # N mm in J
    np.testing.assert_allclose(other.mass, 1e3 * elements.mass, rtol=1e-13)  # t in kg


def test_the_verdict_names_a_number_of_frames_that_it_trusts(runs):
    """One frame leaves more than 5 % of the displacement out; with the number that the warning names, nothing speaks against the run."""
    doubt = next(each for each in runs[1].verdict.warnings if each.code == "large-deformation")
    number = int(doubt.text.partition("frames = ")[2].split()[0])
    assert number == 2
    assert ffrf.compile(wing(number)).statics().verdict.trusted


def test_pictures_show_the_parts_where_their_nodes_are(runs):
    """The ends of the elements as drawn, and the nodes that the shape error looks at, on a line without steps."""
    solution = runs[4].solution
    shape = skin_shape(Configuration(solution, 0), "skin")
    assert shape is not None
    places, _ = cut_positions(solution.system.scene, "skin", solution.q[0, solution.coordinates("skin")])
    np.testing.assert_allclose(shape.line[:, 0], places[:-1], atol=1e-9)  # mm: round-off of two ways to the same place
    np.testing.assert_allclose(shape.line[:, -1], places[1:], atol=1e-6)  # at a cut the tie closes to 1e-10 of the size


def test_the_verdict_says_which_gradients_one_frame_falsifies(runs):
    """By a run with more frames, whose estimates are those of the errors that are seen against a frame to every element."""
    doubts = {
        n: next((each.text for each in run.verdict.warnings if each.code == "geometric-gradients"), "") for n, run in runs.items()
    }
    signs = doubts[1].partition(" is in doubt")[0]
    assert "shape_rmse by x_A" in signs
    assert "shape_rmse by y_A" in signs
    assert "t_w" not in signs  # of the right sign, though it is off by half
    assert "bodies.skin.frames = 4" in doubts[1]
    assert "shape_rmse by x_A" not in doubts[4].partition(" is in doubt")[0]
    assert "gradients are off by up to" in doubts[4]
    assert not runs[4].verdict.trusted
    assert "off by up to 6% (shape_rmse by bodies.skin.chord)" in doubts[15]  # a small one: a tenth of what one frame makes of it
    assert not doubts[30]
    listed = runs[1].verdict.measures["geometric_error"]["signs_in_doubt"]
    assert {"response": "shape_rmse", "variable": "x_A"} in listed
    assert "geometric_error" not in runs[30].verdict.measures  # there are no more frames to compare with
    for n in (1, 4, 15):
        found = runs[n].verdict.measures["geometric_error"]["gradients"]["shape_rmse"]
        for name in ("t_w", "x_A"):
            true = runs[30].gradients["shape_rmse"][name] - runs[n].gradients["shape_rmse"][name]
            assert 0.5 < found[name] / true < 2.0, (n, name)  # the next terms of the error, and parts of unequal length
