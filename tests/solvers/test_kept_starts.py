"""Motions that begin in the last state of a results file: two runs are one, with its gradients, and a file of something else is refused."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import ffrf
from tests.models.cases import write_models
from tests.models.spatial_cases import write_models as write_spatial_models
from toolkit.analyses.sensitivity.certificate.certificate import certify
from toolkit.analyses.sensitivity.certificate.fresh_models import fresh_gradients
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.sensitivity.preparation import evaluate_responses, prepare
from toolkit.analyses.transient import simulate
from toolkit.command_line.cli import app
from toolkit.components.curves.rise import Cycloid
from toolkit.description.description import Description
from toolkit.description.design import BodyPoint
from toolkit.description.results_layout import ResultsFileError
from toolkit.description.run_options import RunOptions
from toolkit.files.results import restore_scene
from toolkit.files.results_file import load_results, save_results
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.solvers.start.initial_conditions import continued_start
from toolkit.studies.stability.maps import speed_map
from toolkit.studies.stability.study import unit_map

HALF, STEP = 0.6, 0.01
NUMBERS = {
    2: ["bodies.arm.thickness", "loads.weight.acceleration.y", "bodies.arm.angle", "bodies.arm.angular_velocity"],
    3: ["bodies.arm.thickness_bar", "loads.weight.acceleration.2", "bodies.arm.orientation.0", "bodies.arm.angular_velocity.1"],
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    directory = tmp_path_factory.mktemp("models")
    write_models(directory)
    write_spatial_models(directory)
    return directory


def pendulum(folder: Path, dimension: int, **solver: Any) -> Scene:
    """A damped flexible body with numbers of order one, hung up at one point, that begins to swing."""
    kinds: Any = ffrf.plane if dimension == 2 else ffrf.space
    plane, space = (
        {"angle": 0.7, "angular_velocity": 0.4},
        {"orientation": (0.3, -0.5, 0.7), "angular_velocity": (0.1, 0.3, -0.2)},
    )
    turned: Any = plane if dimension == 2 else space
    joint = kinds.Revolute if dimension == 2 else kinds.Spherical
    return Scene(
        units="m-kg-s",
        dimension=dimension,
        directory=folder,
        points={"T": BodyPoint(body="arm", interface="middle"), "U": BodyPoint(body="arm", interface="end")},
        bodies={"arm": kinds.Flexible(model="beam.h5" if dimension == 2 else "frame.h5", **turned)},
        joints={"hook": joint(bodies=("arm", "ground"), point="T")},
        loads={"weight": kinds.Gravity(acceleration=(0.02, -0.08, 0.05)[:dimension])},
        responses={
            "x": kinds.Displacement(body="arm", point="U", component="x"),
            "y": kinds.Displacement(body="arm", point="U", component="y"),
            "energy": kinds.KineticEnergy(),
        },
        solver=RunOptions(**({"end_time": HALF, "step": STEP, "tolerance": 1e-13} | solver)),
    )


def further(scene: Scene, file: str = "kept.h5", **solver: Any) -> Scene:
    return scene.model_copy(update={"solver": scene.solver.model_copy(update={"start": file, **solver})})


def kept(scene: Scene, folder: Path, variables: list[str] | None = None, file: str = "kept.h5") -> Path:
    """The results file of a run, with derivatives of its states by some numbers."""
    return ffrf.compile(scene, variables or []).simulate(gradients="direct" if variables else False).save(folder / file)


@pytest.mark.parametrize("dimension", [2, 3])
def test_two_runs_are_one_up_to_an_error_of_second_order(folder, dimension):
    """What the file does not keep is the auxiliary acceleration of the scheme: the second run begins with the consistent one."""
    differences = []
    for step in (STEP, STEP / 2):
        scene = pendulum(folder, dimension, step=step)
        kept(scene, folder)
        two = ffrf.compile(further(scene)).simulate()
        one = ffrf.compile(pendulum(folder, dimension, step=step, end_time=2 * HALF)).simulate()
        scale = np.abs(one.solution.q[-1] - one.solution.q[0]).max()
        differences.append(np.abs(two.solution.q[-1] - one.solution.q[-1]).max() / scale)
    assert differences[0] < 1e-4  # of the way that the body has gone
    assert differences[0] / differences[1] == pytest.approx(4, rel=0.25)  # second order


@pytest.mark.parametrize("dimension", [2, 3])
def test_gradients_are_those_of_both_runs(folder, dimension):
    """Judged by a complex step through both runs, the second one started in the complex state of the first.

    The file keeps the derivatives of direct differentiation, and in another round those of the complex step, to judge the second run alone.
    """
    scene, paths = (
        pendulum(folder, dimension, end_time=4 * STEP),
        NUMBERS[dimension],
    )  # a complex run is slow, and exact at any length
    file = kept(scene, folder, paths)
    exact: dict[str, dict[str, float]] = {path: {} for path in paths}
    results = load_results(file)
    dq, dv = results.dq.copy(), results.dv.copy()
    for x, path in enumerate(paths):
        system = prepare(scene.with_number(path, scene.number(path) + 1e-30j))
        end = simulate(system)
        dq[-1, :, x], dv[-1, :, x] = np.imag(end.q[-1]) / 1e-30, np.imag(end.v[-1]) / 1e-30
        q, v, _ = continued_start(system, end.q[-1], end.v[-1], scene.solver)
        exact[path] = {name: np.imag(value) / 1e-30 for name, value in evaluate_responses(simulate(system, q=q, v=v)).items()}
    save_results(replace(results, dq=dq, dv=dv), folder / "exact.h5")
    # direct: blocks whose vectors refine by less than 1e-11 are not refined, which small derivatives beside large ones feel
    close = {"adjoint": (1e-10, 1e-11), "complex-step": (1e-10, 1e-11), "direct": (1e-8, 1e-9)}
    for name, method in (("exact.h5", "adjoint"), ("exact.h5", "complex-step"), ("exact.h5", "direct"), ("kept.h5", "direct")):
        found = gradients_by(method, further(scene, name), paths, "transient").gradients
        rel, part = close[method]
        for response, slopes in found.items():
            largest = max(map(abs, slopes.values()))
            wanted = {path: exact[path][response] for path in paths}
            assert slopes == pytest.approx(wanted, rel=rel, abs=part * largest), (name, method, response)


def test_a_variable_of_several_numbers_is_known_by_its_parts_or_as_a_whole(folder):
    scene = pendulum(folder, 2)
    both: Any = {"of": ["loads.weight.acceleration.x", "loads.weight.acceleration.y"], "factors": [1.0, -2.0]}
    named = Scene(**{**dict(scene), "design": {"both": both}})
    found = []
    for variables in (["both"], both["of"]):
        kept(named, folder, variables)
        found.append(gradients_by("direct", further(named), ["both"], "transient").gradients["x"]["both"])
    assert found[0] == pytest.approx(found[1], rel=1e-10)


def test_a_driver_goes_on_where_its_curve_has_led(folder):
    """A cycloid of one second in two runs: in the second it has begun half a second before."""

    def crank(begin: float, **solver: Any) -> Scene:
        rise = Cycloid(height=2.0, start=begin, duration=1.0)
        return Scene(
            units="m-kg-s",
            directory=folder,
            points={"O": ffrf.plane.Point(x=0.0, y=0.0), "A": ffrf.plane.Point(x=1.0, y=0.0)},
            bodies={"rod": ffrf.plane.Rod(between=("O", "A"), area=1.0, density=1.0)},
            joints={
                "hinge": ffrf.plane.Revolute(bodies=("rod", "ground"), point="O"),
                "drive": ffrf.plane.AngleDriver(bodies=("rod", "ground"), point="O", curve=rise),
            },
            responses={"turn": ffrf.plane.Rotation(body="rod", point="A")},
            solver=RunOptions(**({"end_time": 0.5, "step": 0.01, "formulation": "index-3"} | solver)),
        )

    kept(crank(0.0), folder)
    run = ffrf.compile(crank(-0.5, start="kept.h5")).simulate()
    assert run.values["turn"] == pytest.approx(2.0, abs=1e-10)
    assert "start-of-other-numbers" not in {caution.code for caution in run.warnings}  # a curve has to be another
    released = crank(0.0, start="kept.h5")
    released = released.model_copy(update={"joints": {"hinge": released.joints["hinge"]}})
    coasting = (
        ffrf.compile(released).simulate().values["turn"]
    )  # half the height, and half a second at twice the mean rate of 2 rad/s
    assert coasting == pytest.approx(1.0 + 0.5 * 4.0, rel=1e-3)  # second order in the step
    with pytest.raises(
        InputError, match=r"the start is off the joints of this scene at t = 0.*give the drivers curves that begin"
    ):
        ffrf.compile(crank(0.0, start="kept.h5")).simulate()


def test_a_motion_begins_in_an_equilibrium_that_a_file_keeps(folder):
    """A mass at rest on a spring under a force; the force is gone, and it swings: x = F / k cos(w t)."""

    def swing(force: float, **solver: Any) -> Scene:
        kinds = ffrf.plane
        return Scene(
            units="m-kg-s",
            directory=folder,
            points={"O": kinds.Point(x=0.0, y=0.0), "P": kinds.Point(x=1.0, y=0.0)},
            bodies={"block": kinds.Rigid(mass=1.3, inertia=1.0, center="P")},
            joints={"rail": kinds.Slider(bodies=("block", "ground"), point="P", axis=(1.0, 0.0), lock_rotation=True)},
            loads={
                "spring": kinds.SpringDamper(bodies=("block", "ground"), points=("P", "O"), stiffness=40.0, damping=0.0),
                "push": kinds.PointForce(body="block", point="P", force=(force, 0.0)),
            },
            responses={"way": kinds.Displacement(body="block", point="P", component="x")},
            solver=RunOptions(**({"end_time": 1.1, "step": 1.1 / 1600, "rho_inf": 1.0} | solver)),
        )

    ffrf.compile(swing(6.0)).statics().save(folder / "rest.h5")
    run = ffrf.compile(swing(0.0, start="rest.h5"), ["loads.push.force.y"]).simulate()
    assert run.values["way"] == pytest.approx(6 / 40 * np.cos(np.sqrt(40 / 1.3) * 1.1), rel=1e-4)  # second order in the step
    (told,) = [caution for caution in run.warnings if caution.code == "start-of-other-numbers"]
    assert "loads.push.force.x = 6 there and 0 here" in told.text
    assert run.verdict.trusted, run.verdict


def test_a_number_that_the_kept_run_did_not_have_needs_no_derivatives_in_the_file(folder):
    scene = pendulum(folder, 2)
    kept(scene, folder)
    pull = ffrf.plane.PointForce(body="arm", point="U", force=(0.01, 0.02))
    pulled = further(scene.model_copy(update={"loads": {**scene.loads, "pull": pull}}))
    path = "loads.pull.force.x"
    exact = gradients_by("complex-step", pulled, [path], "transient").gradients
    for method, close in (("direct", 1e-10), ("adjoint", 1e-10), ("central-difference", 1e-6)):
        found = gradients_by(method, pulled, [path], "transient").gradients
        for name, slopes in exact.items():
            assert found[name][path] == pytest.approx(slopes[path], rel=close), (method, name)


def test_a_certificate_does_without_differences_by_what_has_moved_the_kept_run(folder):
    scene, paths = pendulum(folder, 2), NUMBERS[2][:2]
    kept(scene, folder, paths)
    certificate = certify(further(scene), paths, "transient")
    certificate.check(1e-9)
    assert certificate.parts == {}


# --- refused ------------------------------------------------------------------------------------------------------------------------


def test_gradients_that_would_miss_the_kept_run_are_refused(folder):
    scene, path = pendulum(folder, 2), "bodies.arm.thickness"
    kept(scene, folder)
    for method in ("direct", "adjoint", "complex-step"):
        with pytest.raises(InputError, match=r"has acted in the run that 'kept\.h5' keeps too.*--variables bodies\.arm\.th"):
            gradients_by(method, further(scene), [path], "transient")
    kept(scene, folder, [path])
    for method in ("forward-difference", "central-difference"):
        with pytest.raises(InputError, match=r"differences by 'bodies\.arm\.thickness' leave out how the start depends on it"):
            gradients_by(method, further(scene), [path], "transient")
    moved = further(scene.with_number(path, scene.number(path) * 1.01))
    with pytest.raises(InputError, match=r"no gradient by 'bodies\.arm\.thickness': it is .*, and was .* in the run"):
        gradients_by("direct", moved, [path], "transient")
    told = {caution.code for caution in ffrf.compile(moved).simulate().solution.warnings}
    assert "start-of-other-numbers" in told


def test_a_map_over_the_speed_is_refused_where_a_file_sets_it(folder):
    with pytest.raises(InputError, match=r"the speed at the start is that of a results file \(solver\.start\)"):
        speed_map(further(pendulum(folder, 2)))
    with pytest.raises(
        InputError, match=r"it starts in a results file \(solver\.start\), whose numbers are in units of their own"
    ):
        unit_map(further(pendulum(folder, 2)), folder)


def test_a_certificate_leaves_out_models_built_afresh_which_the_kept_run_does_not_know(folder):
    scene, path = pendulum(folder, 2), "bodies.arm.thickness"
    kept(scene, folder, [path])
    found = fresh_gradients(further(scene), [path], "transient", lambda *_: None)
    assert found.slopes == {}
    assert "the run starts in a results file" in found.left_out[path]


def renamed(scene: Scene, folder: Path) -> Scene:
    points = {name: BodyPoint(body="leg", interface=point.interface) for name, point in scene.points.items()}  # type: ignore[union-attr]
    joints = {"hook": ffrf.plane.Revolute(bodies=("leg", "ground"), point="T")}
    return Scene(**{**dict(scene), "points": points, "bodies": {"leg": scene.bodies["arm"]}, "joints": joints, "responses": {}})


def with_another_model(scene: Scene, folder: Path) -> Scene:
    (folder / "other").mkdir(exist_ok=True)
    write_spatial_models(folder / "other")
    from preprocessing.elements.section import Section
    from tests.models.beam_models import save_beam

    nodes = np.array([[0.0, 0.0], [0.6, 0.1], [1.0, 0.5], [1.1, 1.2]])
    section = Section(youngs_modulus=1.3, density=0.9, thickness=0.3, width=0.8, damping_mass=0.2, damping_stiffness=0.3)
    save_beam(folder / "other" / "beam.h5", nodes, section, {"middle": 0.9, "end": 1.8})
    shutil.copy(folder / "kept.h5", folder / "other" / "kept.h5")
    return scene.model_copy(update={"directory": folder / "other"})


def in_other_units(scene: Scene, folder: Path) -> Scene:
    from toolkit.files.gradient_units import converted

    (folder / "units").mkdir(exist_ok=True)
    shutil.copy(folder / "kept.h5", folder / "units" / "kept.h5")
    return converted(scene, "mm-t-s", folder / "units")


def with_another_frame(scene: Scene, folder: Path) -> Scene:
    arm: Any = scene.bodies["arm"].model_copy(update={"frame": "grounded", "angular_velocity": None})
    return scene.model_copy(update={"bodies": {"arm": arm}, "joints": {}})


@pytest.mark.parametrize(
    ("other", "message"),
    [
        (renamed, r"'kept\.h5' keeps a run of another scene: it has no x of body 'leg'"),
        (with_another_model, r"'kept\.h5' keeps a run with another reduced model of body 'arm': 'beam\.h5' has another content"),
        (in_other_units, r"'kept\.h5' keeps a run in m-kg-s, the scene is in mm-t-s"),
        (with_another_frame, r"'kept\.h5' keeps a run of another scene: it has the x of body 'arm'"),
    ],
)
def test_a_file_of_another_scene_is_refused(folder, other, message):
    scene = pendulum(folder, 2)
    kept(scene, folder)
    with pytest.raises(InputError, match=message):
        ffrf.compile(further(other(scene, folder))).simulate()


@pytest.mark.parametrize(
    ("other", "message"),
    [
        (with_another_model, "start is a run with another reduced model of body 'arm'"),
        (in_other_units, "start is a run in m-kg-s, the scene is in mm-t-s"),
    ],
)
def test_a_run_of_another_scene_is_refused_too(folder, other, message):
    """Its coordinates have the same names; they would be taken for those of this scene."""
    scene = pendulum(folder, 2)
    run = ffrf.compile(scene).simulate()
    kept(scene, folder)  # beside which the other units' models are written
    with pytest.raises(InputError, match=message):
        ffrf.compile(other(scene, folder)).simulate(start=run)


def test_an_axis_of_another_direction_is_another_coordinate(folder):
    def wheel(axis: tuple[float, float, float], **solver: Any) -> Scene:
        kinds = ffrf.space
        return Scene(
            units="m-kg-s",
            dimension=3,
            directory=folder,
            points={"O": kinds.Point(x=0.0, y=0.0, z=0.0)},
            bodies={
                "wheel": kinds.Rigid(
                    mass=1.0, inertia=(1.0, 1.0, 1.0), center="O", frame="turning", axis=axis, angular_velocity=axis
                ),
                # beside it formulas of other scenes serve this one
                "stone": kinds.Rigid(mass=1.0, inertia=(1.0, 1.0, 1.0), center="O"),
            },
            solver=RunOptions(**({"end_time": 0.1, "step": 0.01} | solver)),
        )

    kept(wheel((0.0, 0.0, 1.0)), folder)
    with pytest.raises(InputError, match=r"bodies\.wheel\.axis was \[0\.0, 0\.0, 1\.0\] there and is \[0\.0, 1\.0, 0\.0\] here"):
        ffrf.compile(wheel((0.0, 1.0, 0.0), start="kept.h5")).simulate()
    run = ffrf.compile(wheel((0.0, 0.0, 1.0))).simulate()
    with pytest.raises(InputError, match=r"start is a run of another scene: bodies\.wheel\.axis was"):
        ffrf.compile(wheel((0.0, 1.0, 0.0))).simulate(start=run)


def test_what_is_no_results_file_is_refused(folder):
    scene = pendulum(folder, 2)
    with pytest.raises(InputError, match=r"solver\.start names the results file .*missing\.h5', which is not there"):
        ffrf.compile(further(scene, "missing.h5")).simulate()
    with pytest.raises(ResultsFileError, match="holds no results"):
        ffrf.compile(further(scene, "beam.h5")).simulate()
    (folder / "text.h5").write_text("no HDF5")
    with pytest.raises(ResultsFileError, match="damaged or incomplete"):
        ffrf.compile(further(scene, "text.h5")).simulate()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"start": "equilibriums"}, r"'equilibriums' is no start: write 'given' or 'equilibrium', or the name of a results file"),
        ({"start": "kept.h5", "quasi_static": True}, "a quasi-static run begins in the equilibrium at time 0"),
    ],
)
def test_a_start_that_cannot_be_meant_is_refused(options, message):
    with pytest.raises(ValueError, match=message):
        RunOptions(**options)


def test_a_run_does_not_write_over_its_start(folder):
    scene = pendulum(folder, 2)
    kept(scene, folder)
    again = ffrf.compile(further(scene)).simulate()
    with pytest.raises(ResultsFileError, match="is the start of this run"):
        again.save(folder / "kept.h5")


def test_the_command_goes_on_from_a_file_and_keeps_it(tmp_path):
    text = """
units = "m-kg-s"
points = { O = [0.0, 0.0], P = [1.0, 0.0] }
bodies = { rod = { type = "rod", between = ["O", "P"], area = 1.0, density = 1.0, angular_velocity = 2.0 } }
joints = { hinge = { type = "revolute", bodies = ["rod", "ground"], point = "O" } }
responses = { turn = { type = "rotation", body = "rod", point = "P" } }
solver = { end_time = 0.5, step = 0.01 }
"""
    (tmp_path / "scene.toml").write_text(text)
    run, first, second = CliRunner(), str(tmp_path / "first.h5"), str(tmp_path / "second.h5")
    assert run.invoke(app, ["simulate", str(tmp_path / "scene.toml"), "--output", first]).exit_code == 0
    onward = ["simulate", str(tmp_path / "scene.toml"), "--set", "solver.start=first.h5", "--output"]
    assert run.invoke(app, [*onward, second]).exit_code == 0
    refused = run.invoke(app, [*onward, first])
    assert refused.exit_code != 0
    assert load_results(second).responses["turn"] == pytest.approx(2.0, rel=1e-3)  # second order in the step
    scene = restore_scene(load_results(second))
    assert isinstance(scene, Description)
    assert scene.solver.start == "first.h5"
    assert read_scene(tmp_path / "scene.toml", {"solver.start": "first.h5"}).read_files() == [tmp_path / "first.h5"]


def test_a_start_that_changes_while_a_model_is_in_use_is_refused(folder):
    scene = pendulum(folder, 2)
    kept(scene, folder, file="moving.h5")
    model = ffrf.compile(further(scene, "moving.h5"))
    model.simulate()
    save_results(model.simulate(), folder / "copy.h5")
    shutil.copy(folder / "copy.h5", folder / "moving.h5")
    with pytest.raises(InputError, match=r"the file .*moving\.h5' has changed since the scene was compiled"):
        model.simulate()


@pytest.mark.parametrize(
    ("key", "wrong"),
    [("bodies", 3), ("bodies", {"arm": 3}), ("points", [1.0]), ("loads", None)],
    ids=["number", "body", "list", "none"],
)
def test_a_file_whose_scene_is_none_is_refused(folder, key, wrong):
    scene = pendulum(folder, 2)
    kept(scene, folder)
    found = load_results(folder / "kept.h5")
    save_results(replace(found, scene=replace(found.scene, table={**found.scene.table, key: wrong})), folder / "wrong.h5")
    with pytest.raises(ResultsFileError, match=r"wrong\.h5' is damaged or incomplete"):
        ffrf.compile(further(scene, "wrong.h5")).simulate()
