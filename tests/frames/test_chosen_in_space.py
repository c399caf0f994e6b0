"""Numbers of frames of beams in space: chosen by an error, judged by twice as many, and by the whole mechanism with all of them."""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import ffrf
from preprocessing import build, save
from tests.models.spatial_chains import WHERE, chain_scene, save_chain
from toolkit.analyses.sensitivity.certificate.whole_mechanism import compare_mechanism
from toolkit.command_line.cli import app
from toolkit.command_line.run_answer import deformation_record
from toolkit.foundation.errors import InputError
from toolkit.foundation.kinematics.orientation import matrix_of, quaternion_of
from toolkit.studies.tradeoff.axes import read_axes
from toolkit.validity.bodies.bent_surfaces import geometric_errors
from toolkit.validity.bodies.deformation import largest_displacement, largest_distance, node_places

ARC = np.linspace(0, np.pi / 4, 13)
BEND = 100 * np.column_stack([np.sin(ARC), 1 - np.cos(ARC), 0 * ARC])
"""The bend of Bathe and Bolourchi (1979), which a force of 600 brings out of its plane by half of its length."""
REST = f"""[loads]
pull = {{ type = "point-force", body = "beam", point = "tip", force = [0.0, 0.0, 600.0] }}
[design]
t = "bodies.beam.thickness_s"
force = "loads.pull.force.z"
[responses]
{WHERE}"""


@pytest.fixture(scope="module")
def bend(tmp_path_factory):
    """Of 12 elements."""
    folder = tmp_path_factory.mktemp("bend")
    save_chain(folder, BEND, 'kind = "rectangle", thickness = 1.0, width = 1.0', 1e7, 0.0)
    return folder


def scene_of(folder, frames, rest=REST, held='frame = "grounded"'):
    return chain_scene(folder, f"{held}, frames = {frames}", rest)


@pytest.fixture(scope="module")
def exact(bend):
    """With a frame to every element."""
    return ffrf.compile(scene_of(bend, 12), variables=["t", "force"]).statics(gradients=True)


def apart(one, other):
    """In parts of the largest displacement."""
    return largest_distance(node_places(one, "beam"), node_places(other, "beam")) / largest_displacement(other, "beam")


def test_the_number_that_is_chosen_reaches_the_error(bend, exact, tmp_path):
    run = ffrf.compile(scene_of(bend, '"auto", geometric_error = 0.02'), variables=["t"]).statics()
    said = run.verdict.measures["frames"]["beam"]
    assert said["tried"][:2] == [1, 4]
    assert 4 <= said["frames"] < 12
    true = apart(run.solution, exact.solution)
    assert true < said["estimated_error"] * 2 < 0.04  # the estimate is that of the error
    assert said["estimated_error"] < 4 * true
    note = next(each for each in run.verdict.warnings if each.code == "frames")
    assert f"beam has {said['frames']} floating frames" in note.text
    kept = ffrf.load(run.save(tmp_path / "run.h5"), models=bend)
    assert kept.verdict.measures["frames"]["beam"] == said
    np.testing.assert_array_equal(kept.solution.q, run.solution.q)


def test_places_are_those_of_points(bend, exact):
    """One frame and several ones: the last node is the tip, wherever the body stands."""
    for run in (exact, ffrf.compile(scene_of(bend, 1)).statics()):
        found = node_places(run.solution, "beam")[0, -1] - BEND[-1]
        np.testing.assert_allclose(found, [run.values[axis] for axis in "xyz"], atol=1e-9)  # of a displacement of 50
    turn = np.array([0.3, -0.5, 0.8])
    force = matrix_of(quaternion_of(turn)) @ [0.0, 0.0, 600.0]
    askew = scene_of(
        bend, 12, REST.replace("[0.0, 0.0, 600.0]", str(force.tolist())), f'frame = "grounded", orientation = {turn.tolist()}'
    )
    assert largest_displacement(ffrf.compile(askew).statics().solution, "beam") == pytest.approx(
        largest_displacement(exact.solution, "beam"), rel=1e-8
    )  # statics end at 1e-10 of the size


def test_a_body_that_flies_is_displaced_by_what_bends_it(bend):
    """Neither the place nor the turn of a frame is a displacement, of a body that no force bends."""
    flying = "angular_velocity = [0.0, 0.0, 0.002], velocity = [1.0, 2.0, 3.0]"
    rest = "[solver]\nend_time = 200.0\nstep = 20.0\n"
    run = ffrf.compile(scene_of(bend, 2, rest, flying)).simulate()
    assert np.ptp(node_places(run.solution, "beam"), axis=0).max() > 500
    assert largest_displacement(run.solution, "beam") < 0.01  # what the spin bends
    for turn in (0.0, 1.0):
        line, bow = np.linspace([0.0, 0, 0], [1.0, 0, 0], 5), np.array([0.0, 0.1, 0.15, 0.1, 0.0])
        bent = line + np.outer(bow, [0.0, np.cos(turn), np.sin(turn)])  # a line has no say in which plane it bends
        assert largest_distance(bent[None], (line + np.outer(bow, [0.0, 1.0, 0.0]))[None], moving=True) < 1e-12


def test_gradients_are_judged_by_twice_the_frames(bend, exact):
    """The estimated errors are those against a frame to every element, with their sign."""
    run = ffrf.compile(scene_of(bend, 3), variables=["t", "force"]).statics(gradients=True)
    said = run.verdict.measures["geometric_error"]
    assert said["how"] == "the same run with 6 frames instead of 3 in beam"
    for response, variable in (("z", "force"), ("z", "t"), ("y", "t")):
        true = exact.gradients[response][variable] - run.gradients[response][variable]
        assert said["gradients"][response][variable] == pytest.approx(true, rel=0.25), (response, variable)


def test_the_meter_of_a_cut_body_is_that_of_the_whole(bend, exact):
    """What the lines of all parts lose, in parts of what the whole is displaced: too large by a factor of two or so."""
    solution = ffrf.compile(scene_of(bend, 4)).statics().solution
    found = geometric_errors(solution)["beam"]
    assert found is not None
    told = deformation_record(solution, {"beam": found})["beam"]  # of statics and simulate
    assert told["largest_displacement"]["value"] == pytest.approx(largest_displacement(solution, "beam"))
    assert told["relative_to_displacement"] == found.relative
    assert 0.1 < told["largest_rotation"]["value"] < 0.4  # of 1 rad at the tip some quarter
    assert apart(solution, exact.solution) < found.relative < 3 * apart(solution, exact.solution) < 0.02


def test_the_mechanism_of_all_elements_judges_values_and_gradients(bend, exact):
    solution = ffrf.compile(scene_of(bend, 2)).statics().solution
    found = compare_mechanism(solution, ["t", "force"])
    assert found is not None
    assert found.corotational is not None
    assert found.elements == {"beam": 12}
    assert found.distances["beam"] == pytest.approx(apart(solution, exact.solution), rel=1e-9)
    for response, quotients in found.quotients.items():
        for variable, quotient in quotients.items():
            assert quotient == pytest.approx(exact.gradients[response][variable], rel=1e-6)  # truncation of the quotient


def test_the_commands_know_beams_in_space(bend):
    scene_of(bend, 1)
    done = CliRunner().invoke(app, ["check-deformation", str(bend / "scene.toml"), "--static", "--json", "--variables", "force"])
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert found["deformation"] == {}  # only the plane has elements that turn alone
    assert found["mechanism"]["distances"]["beam"] > 1
    assert any("nodes of beam are off by" in reason for reason in found["verdict"]["reasons"])
    row = found["mechanism"]["gradients"]["y"]["force"]
    assert abs(row["value"]) < 1e-9 * abs(row["corotational"])  # one frame knows of no shortening
    assert row["central_difference"] == pytest.approx(row["corotational"], rel=1e-6)
    labels = [each.label for each in read_axes(scene_of(bend, 1), "frames")["frames"]]
    assert labels == ["1", "2", "4", "8", "every"]


def test_a_chord_in_space_is_not_tried_with_one_frame(tmp_path):
    """Nobody has kept where its nodes are, so that the first number is two; the mechanism compares values alone."""
    save_chain(tmp_path, BEND[::3], 'kind = "rectangle", thickness = 1.0, width = 1.0', 1e7, 0.0)
    text = (tmp_path / "frame.toml").read_text().replace('clamp = ["N0"]\n', "")
    (tmp_path / "frame.toml").write_text(text + '[basis]\nkind = "full"\nchord = ["root", "tip"]\n')
    save(build(tmp_path / "frame.toml"), tmp_path / "beam.h5")
    held = '[joints]\nroot = { type = "rigid", bodies = ["beam", "ground"], point = "root" }\n'
    run = ffrf.compile(scene_of(tmp_path, '"auto", geometric_error = 0.1', held + REST, 'frame = "moving"')).statics()
    said = run.verdict.measures["frames"]["beam"]
    assert said["tried"] == [2, 4]
    one = ffrf.compile(scene_of(tmp_path, 1, held + REST, 'frame = "moving"')).statics()
    found = compare_mechanism(one.solution, [])
    assert found is not None
    assert found.corotational is not None
    assert found.distances == {}
    assert found.corotational.values["z"] == pytest.approx(run.values["z"], rel=1e-8)


def test_words_that_cannot_be_meant_are_refused(bend):
    for words, said in (
        ('"otto"', 'is a whole number from 1 up, "auto", or a list'),
        ("3, geometric_error = 0.1", "chooses a number for"),
    ):
        with pytest.raises(InputError, match=said):
            scene_of(bend, words)
    with pytest.raises(
        InputError, match=r"no number of frames reaches a geometric error of 0.0001. One to every element, 12 in all"
    ):
        ffrf.compile(scene_of(bend, '"auto", geometric_error = 1e-4')).statics()


def test_a_motion_goes_on_from_its_own_kept_run(bend, tmp_path):
    """With the number that was chosen for that run."""
    rest = REST + "[solver]\nend_time = 20.0\nstep = 1.0\n"
    first = ffrf.compile(scene_of(bend, '"auto", geometric_error = 0.1', rest)).simulate()
    number = first.verdict.measures["frames"]["beam"]["frames"]
    assert number > 1
    first.save(bend / "first.h5")
    late = ffrf.compile(scene_of(bend, '"auto"', rest.replace("20.0", "1.0") + 'start = "first.h5"\n')).simulate()
    assert late.verdict.measures["frames"]["beam"] == {"frames": number, "kept_run": "first.h5"}
    ends = node_places(late.solution, "beam")[0] - node_places(first.solution, "beam")[-1]
    assert np.abs(ends).max() < 1e-3  # of 80: what the first run has left open is closed
