"""Maps of stability: classes by their criteria, cells by closed forms, the command."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Annotated

import numpy as np
import pytest
from typer.testing import CliRunner

from preprocessing.builders.frame_recipe import polygon_beam
from preprocessing.elements.section import Section
from preprocessing.reduction.basis import BasisChoice
from tests.models.scenes import WING
from toolkit.analyses.sensitivity.preparation import prepare
from toolkit.analyses.transient import simulate
from toolkit.command_line.cli import app
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.driver import AngleDriver
from toolkit.components.joints.revolute import Revolute
from toolkit.components.loads.point_force import PointForce
from toolkit.description.description import Number, Quantity
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.file import save
from toolkit.responses.energy import KineticEnergy
from toolkit.responses.motion import Displacement, Rotation
from toolkit.scene.scene import Scene
from toolkit.studies.stability.cells import (
    CLASSES,
    CellClass,
    CellOutcome,
    Ending,
    Limits,
    created_energy,
    gradient_class,
    run_cell,
    run_class,
)
from toolkit.studies.stability.map_result import Cell, MapResult, breakdowns, record_of, stable_where
from toolkit.studies.stability.maps import (
    Axis,
    Map,
    baumgarte_map,
    load_map,
    mass_map,
    refined,
    speed_map,
    stiffness_map,
    thickness_map,
    with_options,
)
from toolkit.studies.stability.study import MAPS, maps_of, stability

PENDULUM = WING.parents[1] / "pendulum" / "scene.toml"
BEAM = WING.parents[1] / "rotating_beam" / "scene.toml"
CHAIN = WING.parents[1] / "four_bar_chain" / "scene.toml"
QUICK = {"solver.end_time": "0.5", "solver.step": "0.01"}
SET = [word for change in QUICK.items() for word in ("--set", "=".join(change))]
LIMITS = Limits()
GOOD = CellOutcome(
    differentiation=Ending(),
    drift=1e-9,
    created=1e-4,
    values={"f": 2.0},
    gradients={"f": {"x": 1.0, "y": -3.0}},
    disagreement=1e-12,
)


def run(*arguments: str):
    return CliRunner().invoke(app, ["stability", *arguments])


# Classes ------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "of_run", "of_gradient"),
    [
        ({}, "stable", "stable"),
        ({"drift": 2e-3}, "drifting", "drifting"),
        ({"drift": np.nan}, "drifting", "drifting"),
        ({"created": 0.06}, "drifting", "drifting"),
        ({"created": -0.9}, "stable", "stable"),  # what the scheme takes out makes nothing grow
        ({"values": {"f": 2.5}}, "stable", "stable"),  # 0.5 of the change of 3 that y can make, beyond 10 % of the value
        ({"values": {"f": np.nan}}, "inaccurate", "stable"),
        ({"gradients": {"f": {"x": 1.0, "y": -2.6}}}, "stable", "inaccurate"),
        ({"gradients": {"f": {"x": 1.2, "y": -3.0}}}, "stable", "stable"),  # beside the largest slope of the response
        ({"disagreement": 1e-5}, "stable", "inaccurate"),
        ({"differentiation": Ending("failed", "singular")}, "stable", "failed"),
        ({"status": "failed", "reason": "Newton", "differentiation": None}, "failed", "failed"),
        ({"status": "refused", "reason": "fixed", "differentiation": None}, "refused", "refused"),
    ],
)
def test_a_cell_has_the_class_that_its_criteria_state(change, of_run, of_gradient):
    cell = replace(GOOD, **change)
    reference = replace(GOOD, values={"f": 2.4}) if change.get("values") == {"f": 2.5} else GOOD
    assert run_class(cell, reference, LIMITS).name == of_run
    gradient = gradient_class(cell, reference, LIMITS)
    assert gradient is not None
    assert gradient.name == of_gradient


def test_a_cell_whose_refined_run_fails_is_inaccurate():
    refined = CellOutcome(status="failed", reason="Newton stopped")
    verdict = run_class(GOOD, refined, LIMITS)
    assert (verdict.name, verdict.reason) == ("inaccurate", "with half the step: Newton stopped")


def test_without_variables_there_is_no_gradient_to_judge():
    assert gradient_class(replace(GOOD, differentiation=None), None, LIMITS) is None


# Words --------------------------------------------------------------------------------------------------------------------


def mapped(names: str, values=(0.1, 1.0, 10.0, 100.0), own: int = 1) -> MapResult:
    """A map over one axis, with the classes of its cells by their first letters."""
    classes = {name[0]: name for name in CLASSES}
    axis = Axis("load", values, own, "N", factor=True, nominal=50.0)
    cells = {(k,): Cell(CellClass(classes[letter], f"at {k}"), None) for k, letter in enumerate(names)}
    return MapResult(Map("load", "all loads", (axis,), {}, "half step"), cells)


@pytest.mark.parametrize(
    ("names", "words"),
    [
        ("ssss", "all"),
        ("ffff", "nowhere"),
        ("sssf", "up to 500 N (x 10)"),
        ("fsss", "from 50 N (x 1)"),
        ("fssf", "50 N (x 1) to 500 N (x 10)"),
        ("sfss", "5 N (x 0.1), from 500 N (x 10)"),
        ("sssn", "all that ran: up to 500 N (x 10)"),
    ],
)
def test_stable_ranges_in_words(names, words):
    assert stable_where(mapped(names), "run") == words


def test_what_happens_first_beyond_is_named_with_its_place():
    found = breakdowns(mapped("dsif"))
    assert [(each.place, each.verdict.name) for each in found] == [
        ("load 5 N (x 0.1)", "drifting"),
        ("load 500 N (x 10)", "inaccurate"),
    ]


# What maps vary -----------------------------------------------------------------------------------------------------------


def driven() -> Scene:
    """A rod that is turned by half a radian, by a curve and nothing else."""
    return Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "A": Point(x=1.2, y=0.0)},
        bodies={"arm": Rod(between=("O", "A"), area=0.01, density=500.0)},
        joints={
            "hinge": Revolute(bodies=("arm", "ground"), point="O"),
            "lead": AngleDriver(bodies=("arm", "ground"), point="O", curve=SmoothStep(height=0.5, duration=2.0)),
        },
        responses={"angle": Rotation(body="arm", point="A"), "energy": KineticEnergy(time=1.0)},
        solver=RunOptions(end_time=2.0, step=0.02),
    )


def test_a_motion_twice_as_fast_has_four_times_the_energy_and_ends_at_the_same_angle():
    found = speed_map(driven())
    axis = found.axes[0]
    slow, fast = (run_cell(found.scenes[axis.values.index(by),], []) for by in (1.0, 10.0))
    # the same steps of the same curve: only round-off and Newton's 1e-10 differ
    assert fast.values["energy"] == pytest.approx(100 * slow.values["energy"], rel=1e-8)
    assert fast.values["angle"] == pytest.approx(slow.values["angle"], rel=1e-8)
    assert slow.values["angle"] == pytest.approx(
        0.5, rel=1e-4
    )  # the driver drifts by the square of the step, 1e-4 of the curve's
    # J omega^2 / 2 of the rod in the middle of the curve, omega = height 15 / 8 / duration; stabilisation leaves the step's square
    inertia, omega = 500 * 0.01 * 1.2**3 / 3, 0.5 * 15 / 8 / 2
    assert slow.values["energy"] == pytest.approx(inertia * omega**2 / 2, rel=1e-3)


def test_factors_multiply_what_their_map_is_about():
    wing = read_scene(WING)
    for found, path in (
        (load_map(wing), "loads.drive.torque"),
        (thickness_map(wing), "bodies.skin.thickness"),
        (stiffness_map(wing), "bodies.skin.youngs_modulus"),
        (mass_map(wing), "bodies.body3.density"),
    ):
        axis = found.axes[0]
        for (k,), scene in found.scenes.items():
            assert scene.number(path) == pytest.approx(axis.values[k] * wing.number(path), rel=1e-15)
        assert found.scenes[axis.own,] == wing


class Thruster(PointForce):
    """A user's own load, which says itself what it is proportional to."""

    kind = ""
    proportional = ("thrust",)
    thrust: Annotated[Number, Quantity("force")] = 3.0


def test_a_load_of_a_user_is_mapped_by_what_it_says_that_it_is_proportional_to():
    wing = read_scene(WING)
    own = wing.model_copy(update={"loads": {**wing.loads, "push": Thruster(body="body2", point="B", force=(1.0, 0.0))}})
    found = load_map(own)
    for (k,), scene in found.scenes.items():
        by = found.axes[0].values[k]
        paths = ("drive.torque", "push.thrust", "push.force.x")
        assert [scene.number(f"loads.{path}") for path in paths] == pytest.approx([4200.0 * by, 3.0 * by, 1.0], rel=1e-15)


def test_thickness_and_modulus_are_mapped_as_far_as_asked():
    wing = read_scene(WING)
    thick, stiff = ([scene.number(path) for scene in found.scenes.values()] for found, path in (
        (thickness_map(wing), "bodies.skin.thickness"), (stiffness_map(wing), "bodies.skin.youngs_modulus")
    ))  # fmt: skip
    assert (min(thick), max(thick)) == pytest.approx((0.05, 50.0), rel=1e-12)
    assert min(stiff) <= 1e-6  # MPa: 1 Pa
    assert max(stiff) >= 7e6


def test_a_mass_that_cancels_changes_nothing():
    """The pendulum's motion does not know its mass: all cells end where the first does."""
    found = mass_map(read_scene(PENDULUM, QUICK))
    ends = [run_cell(scene, []).values["move_y"] for scene in found.scenes.values()]
    assert ends == pytest.approx([ends[0]] * len(ends), rel=1e-7)  # Newton's tolerance, over some 100 iterations


def test_slopes_that_are_zero_but_for_round_off_do_not_make_a_gradient_inaccurate():
    """The pendulum's motion does not know its mass: what both methods give, 1e-14, is round-off; the rod's force goes with it."""
    found = run_cell(read_scene(PENDULUM, QUICK), ["m"])
    assert max(abs(found.gradients[name]["m"]) for name in ("move_x", "move_y")) < 1e-12
    assert found.gradients["rod_force"]["m"] == pytest.approx(found.values["rod_force"], rel=1e-9)
    assert found.disagreement < 1e-9
    assert gradient_class(found, found, LIMITS).name == "stable"


def test_runs_that_a_folder_holds_do_not_run_again(tmp_path):
    """To the bit, the seconds that they took too; a file that is lost or damaged is made anew, and a changed scene knows none of them."""
    scene, folder = read_scene(PENDULUM, QUICK), tmp_path / "runs"

    def ran(scene: Scene) -> tuple[str, list[int]]:
        """What is found, and what was told while it ran."""
        told: list[int] = []
        found = stability(scene, ["m"], ["step"], progress=lambda done, total: told.append(done), kept=folder)
        return json.dumps(record_of(found)), told

    first, told = ran(scene)
    files = sorted(folder.iterdir())
    assert told == list(range(len(files) + 1))  # what is known first, then one after the other
    assert len(files) > 3
    assert ran(scene) == (first, told[-1:])
    files[0].unlink()
    files[1].write_bytes(files[1].read_bytes()[:20])
    assert ran(scene)[1] == told[-3:]
    assert ran(scene.with_number("loads.gravity.acceleration.y", -5.0))[1] == told


def test_a_scene_names_the_maps_that_it_does_not_have(tmp_path):
    found, missing = maps_of(read_scene(PENDULUM), None, tmp_path, 1000)
    assert [each.name for each in found] == ["step", "baumgarte", "mass", "load", "units"]
    assert set(missing) == {"thickness", "stiffness", "speed"}


def test_maps_that_are_unknown_or_that_a_scene_does_not_have_are_refused(tmp_path):
    scene = read_scene(PENDULUM)
    with pytest.raises(InputError, match="unknown map 'steps', did you mean 'step'; available: step, baumgarte"):
        maps_of(scene, ["steps"], tmp_path, 1000)
    with pytest.raises(InputError, match="no map 'thickness' of this scene: no flexible body has a thickness"):
        maps_of(scene, ["thickness"], tmp_path, 1000)


# What cells measure -------------------------------------------------------------------------------------------------------


def drift(factor: float, rho_inf: float, end: float) -> float:
    """Of the pendulum, with both constants of the stabilisation at this part of 1/step."""
    scene = with_options(read_scene(PENDULUM, {"solver.step": "0.01"}), end_time=end, rho_inf=rho_inf)
    found = baumgarte_map(scene)
    a, b = found.axes
    return run_cell(found.scenes[a.values.index(factor), b.values.index(factor)], []).drift


def test_without_stabilisation_drift_grows_with_time_squared_and_with_it_it_does_not():
    # Phi'' = 0 alone: a damped scheme leaves an error of Phi'' of one sign, so that Phi grows like t^2, by 4 from 4 s to 8 s
    assert drift(0.0, 0.5, 8.0) > 3.5 * drift(0.0, 0.5, 4.0)
    # the stabilised equation forgets within a few steps, so that only the largest error of one swing counts
    assert drift(1.0, 0.5, 8.0) == pytest.approx(drift(1.0, 0.5, 4.0), rel=0.01)


def test_without_stabilisation_and_damping_drift_comes_back_with_every_swing():
    # for rho_inf = 1 a step backwards undoes a step forwards, so what one half of a swing opens the other half closes
    assert drift(0.0, 1.0, 16.0) == pytest.approx(drift(0.0, 1.0, 4.0), rel=0.01)


def test_a_scene_at_rest_creates_no_energy():
    wing = read_scene(WING, {"loads.drive.torque": "0.0", "solver.end_time": "0.5"})
    assert run_cell(wing, []).created < 1e-3  # round-off, beside the energy that Newton leaves open


def test_damping_that_no_step_resolves_is_no_energy_created():
    """The rotating beam's damping settles it within milliseconds; the sum of its power over steps of 0.5 s is wrong by 16 %."""
    beam = speed_map(read_scene(BEAM, {"solver.end_time": "0.02"}))
    slow = run_cell(beam.scenes[beam.axes[0].values.index(1e-3),], [])
    assert slow.ending == Ending()
    assert slow.created < 1e-3
    # what turns keeps its energy J omega^2 / 2, J = rho A L^3 / 3, beside which the strain of the pull is nothing
    assert slow.values["kinetic"] == pytest.approx(7800 * 1e-3 / 3 * 0.05**2 / 2, rel=1e-3)


def test_a_run_that_gains_energy_from_nowhere_is_seen():
    """States of a free block that moves ever faster, as no load drives it to."""
    scene = Scene(
        units="m-kg-s",
        points={"C": Point(x=0.0, y=0.0)},
        bodies={"block": Rigid(mass=2.0, inertia=1.0, center="C", velocity=(1.0, 0.0, 0.0))},
        solver=RunOptions(end_time=1.0, step=0.1),
    )
    solution = simulate(prepare(scene))
    assert created_energy(solution) < 1e-12
    faster = replace(solution, v=solution.v * np.linspace(1, 2, len(solution.times))[:, None])
    assert created_energy(faster) == pytest.approx(0.75, rel=1e-12)  # from v^2 to (2 v)^2: 3 / 4 of the largest energy


def test_a_gradient_that_only_one_method_can_give_is_judged_by_the_other_run_alone():
    """The magnitude of a displacement that is zero at the start needs the states' derivatives: the adjoint refuses."""
    scene = read_scene(PENDULUM, QUICK)
    still = scene.model_copy(update={"responses": {"way": Displacement(body="bob", point="P", component="magnitude", time=0.0)}})
    found = run_cell(still, ["g_y"])
    assert found.differentiation == Ending()


def test_a_model_that_cannot_follow_is_refused_cell_by_cell(tmp_path):
    nodes = np.column_stack([np.linspace(0, 1, 7), np.zeros(7)])
    section = Section(youngs_modulus=2e11, density=7800.0, thickness=0.02, width=0.05)
    save(polygon_beam(nodes, section, {"hub": 0.0, "tip": 1.0}, basis=BasisChoice("craig-bampton", count=2)), tmp_path / "b.h5")
    scene = Scene(
        units="m-kg-s",
        directory=tmp_path,
        points={"hub": BodyPoint(body="beam", interface="hub"), "tip": BodyPoint(body="beam", interface="tip")},
        bodies={"beam": Flexible(model="b.h5", frame="moving", velocity=(0.0, 0.0, 1.0))},
        joints={"hub": Revolute(bodies=("beam", "ground"), point="hub")},
        responses={"angle": Rotation(body="beam", point="hub")},
        solver=RunOptions(end_time=0.1, step=0.01),
    )
    study = stability(scene, [], ["thickness"])
    (found,) = study.maps
    classes = {found.map.axes[0].values[k]: cell.run.name for (k,), cell in found.cells.items()}
    assert classes.pop(1.0) == "stable"
    assert set(classes.values()) == {"refused"}


# Studies ------------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def pendulum_study():
    scene = read_scene(PENDULUM, {"solver.end_time": "2.0", "solver.step": "0.01"})
    return stability(scene, ["g_y", "x_P"], ["step", "units"], most_steps=2000)


def test_the_pendulum_is_stable_while_the_step_resolves_its_swing(pendulum_study):
    found, _ = pendulum_study.maps
    axis = found.map.axes[0]
    quarter = 2.366 / 4  # of the period from the horizontal, 4 K(1/2) sqrt(l / g), s
    classes = {(axis.values[step], row): cell.run.name for (step, row), cell in found.cells.items()}
    assert {name for (step, _), name in classes.items() if step <= quarter / 50} == {"stable"}
    assert "stable" not in {name for (step, _), name in classes.items() if step >= quarter}


def test_the_gradient_is_never_called_better_than_its_run(pendulum_study):
    for each in pendulum_study.maps:
        for cell in each.cells.values():
            if cell.run.name in ("failed", "refused", "drifting"):
                assert cell.gradient.name == cell.run.name


def test_units_change_nothing(pendulum_study):
    _, units = pendulum_study.maps
    assert {(cell.run.name, cell.gradient.name) for cell in units.cells.values()} == {("stable", "stable")}


def test_a_wrong_branch_is_told_from_a_right_motion():
    """The chain of four-bars passes positions where all bars lie on one line; a coarse step leaves them in the wrong way, in good order."""
    study = stability(read_scene(CHAIN, {"solver.end_time": "1.5", "solver.step": "0.01"}), [], ["step"], most_steps=1500)
    (found,) = study.maps
    reasons = {cell.run.name for cell in found.cells.values()}
    assert "stable" in reasons
    assert reasons & {"inaccurate", "drifting", "failed"}


def test_processes_find_what_one_process_finds():
    scene = read_scene(PENDULUM, QUICK)
    alone, aside = (stability(scene, ["g_y"], ["load"], jobs=jobs) for jobs in (1, 2))
    for one, other in zip(alone.maps, aside.maps, strict=True):
        same = {at: replace(cell.outcome, seconds=0.0) for at, cell in one.cells.items()}
        assert same == {at: replace(cell.outcome, seconds=0.0) for at, cell in other.cells.items()}


def test_cells_beyond_the_allowed_steps_are_not_run():
    study = stability(read_scene(PENDULUM, QUICK), [], ["step", "load"], most_steps=20)
    steps, loads = study.maps
    assert min(steps.map.axes[0].values) >= 0.5 / 20
    assert {cell.run.name for cell in loads.cells.values()} == {"not run"}
    assert study.own.run.reason == "50 steps, more than 20 (--most-steps)"
    (said,) = [each for each in study.verdict.warnings if each.code == "cut-reference"]
    assert said.doubt  # coarser than the scene itself
    assert "steps down to 0.0001 were wanted for the reference, but those up to 0.01 need more than 20 steps" in said.text


def test_given_times_are_refined_between_them_and_have_no_step_map(tmp_path):
    times = (0.0, 0.1, 0.3, 0.5)
    scene = with_options(read_scene(PENDULUM, QUICK), times=times)
    assert refined(scene, 2).solver.times == pytest.approx((0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5), rel=1e-15)
    assert "step" in maps_of(scene, None, tmp_path, 1000)[1]


def test_error_control_is_refined_by_the_cube_and_ends_when_its_steps_vanish(monkeypatch):
    scene = with_options(read_scene(PENDULUM, QUICK), local_error=1e-4, rho_inf=0.8)
    assert refined(scene, 2).solver.local_error == pytest.approx(1e-4 / 8, rel=1e-15)
    assert run_cell(scene, ["g_y"]).ending == Ending()
    monkeypatch.setattr("toolkit.studies.stability.cells.MOST_REPORTS", 2)
    impatient = run_cell(with_options(scene, local_error=1e-8), [])
    assert impatient.status == "failed"
    assert "solver.local_error" in impatient.reason


# The command --------------------------------------------------------------------------------------------------------------


def test_the_command_prints_limits_and_writes_picture_and_numbers(tmp_path):
    done = run(str(PENDULUM), *SET, "--maps", "step,load", "--jobs", "1", "--most-steps", "600", "--output", str(tmp_path))
    assert done.exit_code == 0, done.stderr
    assert "step x rho_inf" in done.stdout
    assert (tmp_path / "stability.png").stat().st_size > 10_000
    record = json.loads((tmp_path / "stability.json").read_text())
    assert list(record["maps"]) == ["step", "load"]
    assert [each["code"] for each in record["warnings"]] == ["cut-reference"]  # a hundredth of the step needs 5000
    assert record["verdict"]["trusted"]
    cells = record["maps"]["load"]["cells"]
    assert {cell["run"]["class"] for cell in cells} <= set(CLASSES)


def test_json_is_all_that_stands_on_standard_output():
    done = run(str(PENDULUM), *SET, "--maps", "units", "--jobs", "1", "--json")
    record = json.loads(done.stdout)
    assert set(record["maps"]) == {"units"}
    assert record["verdict"] == {"trusted": True, "reasons": []}


def test_maps_of_a_scene_without_responses_are_doubted_and_numbers_of_other_units_questioned(tmp_path):
    text = PENDULUM.read_text().partition("[responses]")[0] + "[solver]\nend_time = 0.01\nstep = 0.005\n"
    (tmp_path / "scene.toml").write_text(text.replace("-9.81", "-9810.0"))
    done = run(str(tmp_path / "scene.toml"), "--maps", "load", "--jobs", "1", "--json")
    record = json.loads(done.stdout)
    assert not record["verdict"]["trusted"]
    assert {"no-responses", "unit-of-gravity"} <= {each["code"] for each in record["warnings"]}
    assert "no responses" in done.stderr


def test_a_scene_that_fails_as_it_stands_is_said_so_and_mapped():
    done = run(str(PENDULUM), "--set", "solver.end_time=4.0", "--set", "solver.step=2.0", "--maps", "step", "--jobs", "1")
    assert done.exit_code == 0
    assert "step x rho_inf" in done.stdout
    assert "as it stands" in done.stdout


def test_unknown_maps_are_refused_by_name():
    done = run(str(PENDULUM), "--maps", "speeed")
    assert done.exit_code == 1
    assert "unknown map 'speeed'" in done.stderr
    for name in MAPS:
        assert name in done.stderr
