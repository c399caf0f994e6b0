"""Only what a scene requires is read, compiled and solved; the cost summary says what, and everything put back changes nothing."""

import shutil

import numpy as np
import pytest

from tests.models.scenes import HANGING_DESIGN, MODELS, hanging_skin
from toolkit.analyses.sensitivity.preparation import evaluate_responses, prepare, responses_of, solve
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.model_body import FRAME
from toolkit.components.joints.revolute import Revolute
from toolkit.description.design import BodyPoint
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.files.hdf5 import Content
from toolkit.reduced_model.file import load
from toolkit.report.cost_summary import cost_summary, costs
from toolkit.report.cost_terms import prepare_everything, with_frames
from toolkit.scene.scene import Scene, forget_models
from toolkit.system.system import compile_scene


@pytest.fixture
def wing(tmp_path):
    """The wing in a folder of its own, so that nothing of it was read before."""
    shutil.copytree(MODELS, tmp_path / "wing")
    return tmp_path / "wing" / "scene.toml"


@pytest.fixture
def read(monkeypatch):
    """Names of the datasets that are read -> their bytes in the file, once for every time."""
    found: list[tuple[str, int]] = []
    original = Content._read

    def counted(content, name):
        values = original(content, name)
        found.append((name, content.stored_bytes(name)))
        return values

    monkeypatch.setattr(Content, "_read", counted)
    return found


def groups(read) -> set[str]:
    """Groups of the datasets that were read."""
    return {name.split("/")[0] for name, _ in read}


def test_a_motion_reads_the_groups_that_equations_and_responses_need_and_each_array_once(wing, read):
    evaluate_responses(solve(prepare(read_scene(wing)), "transient"))
    assert groups(read) == {"invariants", "interfaces", "shape"}
    assert len(read) == len(dict(read))


def test_responses_that_are_not_asked_for_leave_their_groups_unread(wing, read):
    scene = read_scene(wing)
    evaluate_responses(solve(prepare(scene.model_copy(update={"responses": {}})), "transient"))
    assert groups(read) == {"invariants", "interfaces"}


@pytest.mark.parametrize("path", ["bodies.skin.thickness", "bodies.skin.density"])
def test_a_variable_of_a_body_reads_what_its_arrays_depend_on_and_each_array_once(wing, read, path):
    system = prepare(read_scene(wing), [path])
    for response in system.scene.responses.values():
        response.evaluate(simulate(system))
    assert groups(read) == {"invariants", "interfaces", "affine", "derivatives", "shape"}
    assert len(read) == len(dict(read))


def test_a_variable_of_something_else_reads_nothing_more(wing, read):
    compile_scene(read_scene(wing), ["loads.drive.torque", "points.A.x"])
    assert groups(read) == {"invariants", "interfaces"}


def test_a_parameter_off_its_nominal_value_reads_what_it_changes(wing, read):
    compile_scene(read_scene(wing, {"bodies.skin.thickness": "1.6"}))
    assert groups(read) == {"invariants", "interfaces", "affine", "derivatives"}


def test_a_model_knows_how_many_bytes_of_its_file_were_read(wing, read):
    path = wing.parent / "skin.h5"
    lean = load(path, ("interfaces",))
    more = load(path, ("interfaces", "shape"), lean)
    assert more.interfaces is lean.interfaces
    for group in ("invariants", "interfaces", "shape"):
        assert more.bytes_read[group] == sum(size for name, size in read if name.split("/")[0] == group)
    everything = load(path).bytes_read
    # the rest of the file, under a third, are names, attributes and the tables of HDF5
    assert 0.6 * path.stat().st_size < sum(everything.values()) < path.stat().st_size


def test_a_file_that_was_replaced_is_read_anew(wing):
    path = wing.parent / "skin.h5"
    old = load(path, ("interfaces",))
    shutil.copy(MODELS.parent / "rotating_beam" / "beam.h5", path)
    assert load(path, ("interfaces", "mesh"), old).n_f != old.n_f


@pytest.fixture
def rng():
    """Random numbers, the same every time."""
    return np.random.default_rng(7)


@pytest.mark.parametrize("path", HANGING_DESIGN)
def test_entries_that_only_variables_fill_change_no_residual(path, rng):
    """More entries are stored with a variable than without; the sums stay the same but for their order."""
    scene = hanging_skin()
    alone, varied = compile_scene(scene), compile_scene(scene, [path])
    q, v, acc = (np.concatenate([0.01 * rng.normal(size=alone.n_q), np.zeros(alone.n - alone.n_q)]) for _ in range(3))
    one, other = (system.evaluate(system.inputs(0.005, np.ones(3)), q, v, acc) for system in (alone, varied))
    for a, b in ((one.inertial, other.inertial), (one.applied, other.applied)):
        assert a == pytest.approx(b, rel=1e-12, abs=1e-12 * np.abs(a).max())  # round-off of sums over 90 coordinates


def clamped_skin() -> Scene:
    """The skin stands clamped at a place and angle of its own, falls, and is pushed by an arm; no loop of rods drives it."""
    loose = hanging_skin()
    skin = Flexible(model="skin.h5", frame="grounded", position=(3.0, 5.0), angle=0.1)
    joints = {name: joint for name, joint in loose.joints.items() if name in ("C", "guide")}
    responses = {name: each for name, each in loose.responses.items() if name != "rod_force"}
    return loose.model_copy(update={"bodies": {**loose.bodies, "skin": skin}, "joints": joints, "responses": responses})


def rotating_beam() -> Scene:
    """The spinning beam, for some steps."""
    return read_scene(MODELS.parent / "rotating_beam" / "scene.toml", {"solver.end_time": "0.02"})


def excluded_numbers() -> Scene:
    """The spatial bracket, whose universal joint allows no derivative by single numbers of its axes."""
    return read_scene(MODELS.parent / "spatial_bracket" / "scene.toml", {"solver.end_time": "0.0003"})


SCENES = {
    "wing": lambda: read_scene(MODELS / "scene.toml"),
    "clamped skin": clamped_skin,
    "rotating beam": rotating_beam,
}


@pytest.mark.parametrize("name", [*SCENES, "excluded numbers"])
def test_everything_put_back_changes_no_response(name):
    """Newton stops at corrections of 1e-10 of the model size, so that two ways to the same motion agree to some of these."""
    scene = {**SCENES, "excluded numbers": excluded_numbers}[name]()
    lean, whole = (evaluate_responses(simulate(system)) for system in (prepare(scene), prepare_everything(scene)))
    for response, value in lean.items():
        assert whole[response] == pytest.approx(value, rel=1e-8), response


@pytest.mark.parametrize("name", ["wing", "clamped skin"])
def test_everything_put_back_changes_no_gradient(name):
    """Gradients are judged to 1e-9 of the largest; blocks of right-hand sides are not refined below 1e-11."""
    scene = SCENES[name]()
    variables = list(scene.design.values()) or ["bodies.skin.thickness", "bodies.skin.position.x", "bodies.skin.angle"]
    lean, whole = simulate(prepare(scene, variables)), simulate(prepare_everything(scene))
    where = [list(whole.system.design.names).index(path) for path in variables]
    for response, each in responses_of(scene).items():
        gradient, complete = each.gradient(lean), each.gradient(whole)
        assert complete[where] == pytest.approx(gradient, rel=1e-7, abs=1e-9 * np.abs(complete).max()), response


def test_frames_put_back_stay_where_they_are():
    solution = simulate(prepare(with_frames(clamped_skin())))
    frame = solution.q[:, solution.coordinates("skin")][:, :3]
    assert frame == pytest.approx(np.tile([3.0, 5.0, 0.1], (len(frame), 1)), rel=1e-10)


def test_a_joint_can_grip_the_origin_of_a_frame():
    """The beam's frame is tied to its hub: holding one is holding the other."""
    beam = rotating_beam()
    held = beam.model_copy(
        update={
            "points": {**beam.points, "origin": BodyPoint(body="beam", interface=FRAME)},
            "joints": {"hub": Revolute(bodies=("beam", "ground"), point="origin")},
        }
    )
    first, second = (evaluate_responses(solve(prepare(scene), "transient")) for scene in (beam, held))
    for name, value in first.items():
        assert second[name] == pytest.approx(value, rel=1e-9), name  # Newton's tolerance of 1e-10, some times


def total(lines: list[dict], key: str) -> int:
    """Sum over a section of the cost summary."""
    return sum(line[key] for line in lines)


@pytest.mark.parametrize("name", SCENES)
def test_the_cost_summary_counts_what_the_compiled_scene_holds(name):
    scene = SCENES[name]()
    variables = list(scene.design) or ["bodies.skin.thickness"]
    system, found = prepare(scene, variables), cost_summary(scene, variables, measured=False)
    assert total(found["coordinates"], "kept") == system.n_q
    assert total(found["constraint rows"], "kept") == system.n - system.n_q
    assert total(found["derivative blocks (rows of the residual)"], "kept") == len(system.plan.touched_row)
    assert total(found["markers"], "kept") == len(system.numbering.markers)
    assert found["matrix (entries)"][0]["kept"] == len(system.plan.indices)
    assert all(line["why"] for lines in found.values() for line in lines if line.get("dropped"))


def test_the_cost_summary_states_the_bytes_that_were_read_and_all_of_the_file(wing, read):
    found = cost_summary(read_scene(wing), ["M_t"], measured=False)["bytes of skin.h5"]
    read.clear()
    prepare(read_scene(wing), ["M_t"])  # nothing is read twice in one program
    assert not read
    assert total(found, "kept") + total(found, "dropped") == (wing.parent / "skin.h5").stat().st_size
    kept = {line["what"]: line["kept"] for line in found if line["kept"]}
    assert kept.keys() == {"invariants", "interfaces", "shape"}
    load(wing.parent / "skin.h5", ("interfaces", "shape"))
    assert sum(kept.values()) == sum(size for _, size in read)


@pytest.mark.parametrize("variables", [[], ["t_w"]])
def test_the_bytes_of_the_cost_summary_are_those_that_a_whole_run_reads(wing, read, variables):
    scene = read_scene(wing)
    stated = costs(scene, variables, measured=False)[len(variables)].bytes_read
    forget_models()
    read.clear()
    solution = simulate(prepare(scene, variables))
    for response in responses_of(scene).values():
        response.evaluate(solution)
    assert sum(size for _, size in read) == stated


def test_with_everything_kept_the_cost_summary_drops_nothing_that_could_be_put_back(wing):
    found = cost_summary(read_scene(wing), [], keep_all=True, measured=False)
    assert total(found["coordinates"], "dropped") == total(found["constraint rows"], "dropped") == 0
    assert total(found["derivative blocks (rows of the residual)"], "dropped") == 0
    assert [line["what"] for line in found["bytes of skin.h5"] if line["dropped"]] == ["names, attributes, tables of HDF5"]


def test_whatever_is_put_back_costs_more_by_every_count(wing):
    """Counts, not times: the same on every machine."""
    lean, gradients, frames, whole = costs(read_scene(wing), ["t_w"], measured=False)
    for key in ("coordinates", "rows", "jacobian", "factorization", "solution"):
        assert getattr(lean, key) == getattr(gradients, key) < getattr(frames, key) == getattr(whole, key)
    assert lean.variables < gradients.variables < whole.variables
    assert lean.bytes_read == frames.bytes_read < gradients.bytes_read < whole.bytes_read


def test_a_time_of_every_way_is_measured_or_the_reason_is_stated(wing):
    assert all(each.step_us and not each.reason for each in costs(read_scene(wing), ["t_w"]))
    torn = costs(read_scene(wing, {"points.A.x": "75.0", "solver.drift_tolerance": "1e-12"}), ["t_w"])
    assert all(each.step_us is None and "the joints came apart" in each.reason for each in torn)


def test_a_run_of_one_step_has_no_time_of_a_step():
    short = read_scene(MODELS / "scene.toml", {"solver.end_time": "0.05"})
    assert {each.reason for each in costs(short, [])} == {"a run of one step is mostly its start"}
