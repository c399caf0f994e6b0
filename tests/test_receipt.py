"""Only what a scene requires is read, compiled and solved; the receipt says what, and everything put back changes nothing."""

import shutil

import h5py
import numpy as np
import pytest

from tests.scenes import HANGING_DESIGN, MODELS, hanging_skin
from toolkit.reduced_model_file import load
from toolkit.scene_file import read_scene
from toolkit.sensitivity.analysis import evaluate_responses, prepare, solve
from toolkit.solvers.transient import simulate
from toolkit.system import compile_scene


@pytest.fixture
def wing(tmp_path):
    """The wing in a folder of its own, so that nothing of it was read before."""
    shutil.copytree(MODELS, tmp_path / "wing")
    return tmp_path / "wing" / "scene.toml"


@pytest.fixture
def read(monkeypatch):
    """Names of the datasets that are read -> their bytes in the file, once for every time."""
    found: list[tuple[str, int]] = []
    original = h5py.Dataset.__getitem__

    def counted(dataset, arguments):
        found.append((dataset.name, dataset.id.get_storage_size()))
        return original(dataset, arguments)

    monkeypatch.setattr(h5py.Dataset, "__getitem__", counted)
    return found


def groups(read) -> set[str]:
    """Groups of the datasets that were read."""
    return {name.split("/")[1] for name, _ in read}


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
        assert more.bytes_read[group] == sum(size for name, size in read if name.split("/")[1] == group)
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
