"""Numbers of frames that are chosen by the error that a scene asks for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ffrf
from preprocessing.reduction.basis import BasisChoice
from tests.frames.test_cut_bodies import EI, SECTION, STRAIGHT, cantilever, in_space, without_elements
from tests.frames.test_cut_wing import WING, wing
from tests.models.beam_models import save_beam
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.command_line.commands.inspection import describe_scene
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.studies.tradeoff.axes import read_axes
from toolkit.studies.tradeoff.frame_axes import framed
from toolkit.studies.tradeoff.setting import Setting
from toolkit.studies.tradeoff.setting_run import Case
from toolkit.studies.tradeoff.tradeoff import changes
from toolkit.validity.bodies.deformation import LIMIT, deformations, largest_displacement, largest_distance, node_places


def automatic(scene: Scene, body: str, **keys: object) -> Scene:
    changed = scene.bodies[body].model_copy(update={"frames": "auto", **keys})
    return scene.model_copy(update={"bodies": {**scene.bodies, body: changed}})


@pytest.mark.parametrize(("wanted", "analysis"), [(1e-2, "transient"), (1e-3, "static")])
def test_the_number_that_is_chosen_reaches_the_error(wanted, analysis, tmp_path):
    """As it is seen against a frame to every element; other numbers keep the frames, and so does a file of results."""
    model = ffrf.compile(automatic(wing(1), "skin", geometric_error=wanted), variables=["t_w"])
    run = model.run(analysis)
    said = run.verdict.measures["frames"]["skin"]
    assert said["tried"][0] == 1
    assert 1 < said["frames"] in said["tried"]
    exact = solve(prepare(wing(30)), analysis)
    true = largest_distance(node_places(run.solution, "skin"), node_places(exact, "skin")) / largest_displacement(exact, "skin")
    assert true < said["estimated_error"] * 2 < 2 * wanted
    assert true > said["estimated_error"] / 2  # the estimate is that of the error, and not a bound far above it
    note = next(each for each in run.verdict.warnings if each.code == "frames")
    assert not note.doubt
    assert f"skin has {said['frames']} floating frames" in note.text
    other = model.run(analysis, {"t_w": 1.6})
    assert len(other.solution.q[0]) == len(run.solution.q[0])
    kept = ffrf.load(run.save(tmp_path / "run.h5"), models=WING)
    assert kept.solution.q.shape == run.solution.q.shape
    assert kept.verdict.measures["frames"]["skin"]["frames"] == said["frames"]


HELD = """units = "m-kg-s"
[points]
middle = { body = "beam", interface = "middle" }
end = { body = "beam", interface = "end" }
[bodies]
beam = { type = "flexible", model = "beam.h5", frame = "grounded", frames = FRAMES }
[joints]
end = { type = "rigid", bodies = ["beam", "ground"], point = "end" }
[loads]
LOAD
"""
FORCE = 'push = { type = "point-force", body = "beam", point = "middle", force = [0.0, 3.0] }'
WEIGHT = 'weight = { type = "gravity", acceleration = [0.0, -50.0] }'


@pytest.mark.parametrize(("load", "wanted"), [(WEIGHT, 0.01), (FORCE, 0.03)])
def test_the_error_is_reached_between_fixed_ends(tmp_path, load, wanted):
    """Tension stiffens the beam, and runs with few frames lie closer together than to the truth: with 2 and 4 under a force in the middle
    to round-off, by symmetry."""
    nodes = np.column_stack([np.linspace(0, 1, 33), np.zeros(33)])
    save_beam(tmp_path / "beam.h5", nodes, SECTION, {"middle": 0.5, "end": 1.0})

    def solved(frames: object) -> Any:
        (tmp_path / "scene.toml").write_text(HELD.replace("FRAMES", str(frames)).replace("LOAD", load))
        return ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml")).statics()

    exact, run = solved(32).solution, solved(f'"auto", geometric_error = {wanted}')
    said = run.verdict.measures["frames"]["beam"]
    true = largest_distance(node_places(run.solution, "beam"), node_places(exact, "beam")) / largest_displacement(exact, "beam")
    assert true < wanted
    assert 0.6 * true < said["estimated_error"] < wanted


@pytest.mark.parametrize("frames", [2, 4])
def test_the_meter_of_a_cut_body_estimates_the_error_of_the_whole(frames, tmp_path):
    """It divides by what the whole is displaced, and adds up what the parts lose: of a strongly bent beam twice too much at most."""
    force = in_space((0.0, 4 * EI))
    exact = solve(prepare(cantilever(tmp_path, STRAIGHT, len(STRAIGHT) - 1, force)), "static")
    solution = solve(prepare(cantilever(tmp_path, STRAIGHT, frames, force)), "static")
    found, size = deformations(solution)["beam"], largest_displacement(exact, "beam")
    assert found is not None
    true = largest_distance(node_places(solution, "beam"), node_places(exact, "beam")) / size
    assert 0.02 * (2 / frames) ** 2 < true < found.relative < 2.2 * true
    assert found.displacement == pytest.approx(size, rel=0.05)
    assert found.size == pytest.approx(np.ptp(STRAIGHT, axis=0).max())  # undeformed


def test_one_frame_stays_where_it_is_enough():
    model = ffrf.compile(automatic(wing(1), "skin"))
    run = model.statics({"M_t": 4200.0})  # the number is that of the scene as it is written
    assert run.verdict.measures["frames"]["skin"]["frames"] == 4
    assert describe_scene(run.solution.system.scene)["bodies"]["skin"] == "flexible"
    weak = automatic(wing(1), "skin").with_number("loads.drive.torque", 42.0)
    said = ffrf.compile(weak).statics().verdict.measures["frames"]["skin"]
    assert said["frames"] == 1
    assert said["tried"] == [1, 2]
    assert said["estimated_error"] < 1e-2


def test_gradients_take_as_many_frames_as_they_need():
    """Their errors are those that a frame to every element shows, to a factor of two; values alone take the fewer that they need."""
    variables = ["t_w", "M_t", "x_A", "points.A.y"]
    model = ffrf.compile(automatic(wing(1), "skin"), variables=variables)
    plain, run = model.statics(), model.statics(gradients=True)
    said = run.verdict.measures["frames"]["skin"]
    few, enough = said["for_gradients"][0], said["for_gradients"][-1]
    assert few["frames"] == plain.verdict.measures["frames"]["skin"]["frames"] < said["frames"] == enough["frames"]
    assert few["estimated_error"] > LIMIT >= enough["estimated_error"]
    assert "geometric-gradients" not in {each.code for each in run.verdict.warnings}
    exact = ffrf.compile(wing(30), variables=variables).statics(gradients=True)
    others = {
        each["frames"]: ffrf.compile(wing(each["frames"]), variables=variables).statics(gradients=True) for each in (few, enough)
    }
    for each in (few, enough):
        parts = [
            abs(exact.gradients[f][x] / slope - 1)
            for f, row in others[each["frames"]].gradients.items()
            for x, slope in row.items()
        ]
        assert each["estimated_error"] / 2 < max(parts) < 2 * each["estimated_error"]


def test_an_error_that_no_number_reaches_is_refused_with_the_mesh_that_would(tmp_path):
    scene = automatic(cantilever(tmp_path, STRAIGHT[::4], 1, (0.0, 2 * EI)), "beam", geometric_error=1e-4)
    with pytest.raises(
        InputError, match=r"no number of frames reaches a geometric error of 0.0001. One to every element, 4 in all"
    ) as found:
        ffrf.compile(scene).statics()
    needed = int(str(found.value).partition("with some ")[2].split()[0])
    assert 10 < needed < 200  # one frame to each of 4 elements leaves a part of a percent or of some


def test_a_body_that_cannot_be_cut_has_no_number_to_choose(tmp_path):
    cantilever(tmp_path, STRAIGHT, 1, (0.0, EI), basis=BasisChoice("eigenmodes", count=4))
    without_elements(tmp_path / "beam.h5")
    with pytest.raises(InputError, match=r"frames = auto.*does not keep its elements one by one"):
        ffrf.compile(automatic(ffrf.read_scene(tmp_path / "scene.toml"), "beam")).statics()


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"frames": "otto"}, 'is a whole number from 1 up, "auto", or a list of nodes'),
        ({"frames": "true"}, 'is a whole number from 1 up, "auto", or a list of nodes'),
        ({"frames": "2.5"}, 'is a whole number from 1 up, "auto", or a list of nodes'),
        (
            {"frames": "[3.5]"},
            'skin.frames: is a whole number from 1 up, "auto", or a list of nodes and interface points where the body is cut.$',
        ),
        ({"frames": "0"}, 'is a whole number from 1 up, "auto", or a list of nodes'),
        ({"frames": "auto", "geometric_error": "0"}, "greater than 0"),
        ({"frames": "4", "geometric_error": "0.01"}, 'is what frames = "auto" chooses a number for'),
    ],
)
def test_words_that_cannot_be_meant_are_refused(keys, words):
    with pytest.raises(InputError, match=words):
        ffrf.read_scene(WING / "scene.toml", {f"bodies.skin.{key}": value for key, value in keys.items()})


def test_the_study_of_settings_varies_frames():
    scene = wing(2)
    choices = read_axes(scene, "frames")["frames"]
    assert [each.label for each in choices] == ["2", "1", "4", "8", "every"]
    assert [each.own for each in choices] == [True, False, False, False, False]
    case = Case(WING / "scene.toml", {}, (), Path("."), "")
    counts = [case.scene_of(Setting({"frames": each})).bodies["skin"].frames for each in choices]  # type: ignore[attr-defined]
    assert counts == [2, 1, 4, 8, 30]
    assert len({case.key(Setting({"frames": each})) for each in choices}) == 5
    assert framed(scene, None) is scene
    with pytest.raises(InputError, match="whole numbers from 1 to 30, the elements of the body, or every"):
        read_axes(scene, "frames=31")
    of_modes = read_axes(scene, "modes_per_frame")["modes_per_frame"]
    assert [each.label for each in of_modes] == ["all", "0", "1", "2", "4", "8"]
    assert [each.own for each in of_modes] == [True] + 5 * [False]
    both = Setting({"frames": choices[2], "modes_per_frame": of_modes[3]})
    reduced = case.scene_of(both).bodies["skin"]
    assert (reduced.frames, reduced.modes_per_frame) == (4, 2)  # type: ignore[attr-defined]
    assert changes(case, both) == {"bodies.skin.frames": "4", "bodies.skin.modes_per_frame": "2"}
    assert len({case.key(Setting({"modes_per_frame": each})) for each in of_modes}) == 6
    with pytest.raises(InputError, match="modes_per_frame='-1' is invalid; give whole numbers from 0 on, or all"):
        read_axes(scene, "modes_per_frame=-1")
    with pytest.raises(InputError, match="no body has any"):
        read_axes(wing(1), "modes_per_frame")
    with pytest.raises(InputError, match="this scene has none"):
        read_axes(ffrf.read_scene(WING.parent / "pendulum" / "scene.toml"), "frames")


@pytest.mark.parametrize(("force", "doubted"), [(2.0, True), (0.4, False)])
def test_a_number_that_other_numbers_outgrow_is_told(tmp_path, force, doubted):
    """A force four times as large: four frames leave 0.45 % where 0.2 % are wanted, known to a factor of two; at a smaller one, less."""
    own, other = (tmp_path / name for name in ("own", "other"))
    for each in (own, other):
        each.mkdir()
    model = ffrf.compile(cantilever(own, STRAIGHT, '"auto", geometric_error = 2e-3', (0.0, 0.5 * EI)), variables=["F"])
    assert model.statics().verdict.trusted
    run = model.statics({"F": force * EI})
    exact = ffrf.compile(cantilever(other, STRAIGHT, 16, (0.0, force * EI))).statics().solution
    true = largest_distance(node_places(run.solution, "beam"), node_places(exact, "beam")) / largest_displacement(exact, "beam")
    told = [each for each in run.verdict.warnings if each.code == "outgrown-frames"]
    assert (true > 2e-3) == doubted
    assert [each.doubt for each in told] == [True] * doubted
    for each in told:
        said = float(each.text.partition("leaves about ")[2].partition("%")[0]) / 100
        assert 0.5 * true < said < 2 * true
