"""Speed against accuracy: the reference's error against the truth, the Pareto set, what is recommended, and what is kept on disk."""

from __future__ import annotations

import json
import math
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipj, ellipk
from typer.testing import CliRunner

from toolkit.analyses.sensitivity.direct import direct
from toolkit.command_line.cli import app
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.toml_file import parse_toml
from toolkit.studies.store import RunFolder
from toolkit.studies.tradeoff import setting_run
from toolkit.studies.tradeoff.axes import SOLVER_AXES, available, read_axes
from toolkit.studies.tradeoff.reference import limit
from toolkit.studies.tradeoff.setting import BudgetError, ErrorQuantity, SettingOutcome, grid, read_budget
from toolkit.studies.tradeoff.tradeoff import Tradeoff, TradeoffPlan, errors, pareto, plan, toml_table, tradeoff

ROOT = Path(__file__).parents[2]
PENDULUM = ROOT / "models" / "pendulum" / "scene.toml"
CRANK = ROOT / "models" / "slider_crank" / "scene.toml"
WING = ROOT / "models" / "morphing_wing"
SHORT = {"solver.end_time": "2.0", "solver.step": "0.02"}
SET = [f"--set={path}={value}" for path, value in SHORT.items()]


def study(folder: Path, path: Path = PENDULUM, changes: dict | None = None, **wanted) -> Tradeoff:
    """A study in this process, timed by two runs each."""
    return tradeoff(planned(folder, path, changes, **wanted), repeats=2)


def planned(folder: Path, path: Path = PENDULUM, changes: dict | None = None, **wanted) -> TradeoffPlan:
    return plan(path, folder, SHORT if changes is None else changes, **wanted)


@pytest.fixture(scope="module")
def pendulum(tmp_path_factory) -> Tradeoff:
    """The falling pendulum for 2 s, by steps and schemes."""
    return study(tmp_path_factory.mktemp("pendulum"), axes="step,scheme")


def swing(length: float, gravity: float, end: float) -> np.ndarray:
    """Place (x, y) under the pivot, and pull per mass, of a pendulum that falls from the horizontal at rest.

    sin(theta / 2) = k sn(K - omega t), k = sin(pi / 4), omega = sqrt(g / L); pull / m = 3 g cos(theta)
    """
    m = 0.5
    sn = ellipj(ellipk(m) - np.sqrt(gravity / length) * end, m)[0]
    theta = -2 * np.arcsin(np.sqrt(m) * sn)
    return np.array([length * np.sin(theta), -length * np.cos(theta), 3 * gravity * np.cos(theta)])


def exact() -> tuple[dict[str, float], dict[str, dict[str, float]]]:
    """Responses and gradients of the pendulum after 2 s from its closed form; the derivatives of elliptic functions by differences."""
    length, gravity, end = 1.0, 9.81, 2.0
    x, y, pull = swing(length, gravity, end)
    values = {"move_x": x + length, "move_y": y, "rod_force": pull}
    h = 1e-3

    def slope(f) -> np.ndarray:  # fourth order: h^4 against smooth functions of scale 0.1 is 1e-9
        return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h)

    by_length = slope(lambda d: swing(length + d, gravity, end) + np.array([d, 0, 0]))
    by_gravity = slope(lambda d: swing(length, gravity + d, end))
    gradients = {
        name: {"x_P": -by_length[k], "g_y": -by_gravity[k], "m": pull if name == "rod_force" else 0.0}
        for k, name in enumerate(values)
    }
    return values, gradients


def test_the_reference_is_as_near_to_the_closed_form_as_it_says(pendulum):
    values, gradients = exact()
    reference = pendulum.reference
    assert reference.enough
    for name, value in values.items():
        stated = reference.limits[name]
        assert stated.order == pytest.approx(2, abs=0.1)
        # an estimate: the next power of the step may be the fourth instead of the third, and differences of the truth leave 1e-9
        assert abs(stated.value - value) <= 3 * stated.error + 1e-8 * abs(value), name
        for x, slope in gradients[name].items():
            stated = reference.slopes[name][x]
            assert abs(stated.value - slope) <= 3 * stated.error + 1e-8 * max(map(abs, gradients[name].values())), (name, x)


def test_measured_errors_are_the_true_ones(pendulum):
    values, gradients = exact()
    worked = [each for each in pendulum.settings if not each.outcome.failed]
    assert len(worked) >= 8
    for each in worked:
        for name, value in values.items():
            true = abs(each.outcome.value(name) / value - 1)
            assert each.errors[ErrorQuantity(name, False)] == pytest.approx(true, rel=1e-2, abs=1e-7)
            sizes = {"x_P": 1.0, "g_y": 9.81, "m": 1.0}
            off = max(abs(each.outcome.slope(name, x) - slope) * sizes[x] for x, slope in gradients[name].items())
            largest = max(abs(slope) * sizes[x] for x, slope in gradients[name].items())
            assert each.errors[ErrorQuantity(name, True)] == pytest.approx(off / largest, rel=1e-2, abs=1e-7)


def test_the_reference_meets_the_published_integral_and_gradients_of_the_slider_crank(tmp_path):
    known = json.loads((ROOT / "tests" / "data" / "benchmarks" / "sundials_slider_crank_sensitivity.json").read_text())
    found = study(tmp_path, CRANK, {"solver.step": "0.05"}, axes="step=0.05/0.025").reference
    assert found.limits["G"].value == pytest.approx(known["reference"]["G_idas_forward"], rel=3e-6)  # published to that
    assert abs(found.limits["G"].value - known["rederived"]["G"]) <= 5 * found.limits["G"].error
    for name, stated in found.slopes["G"].items():
        value = known["rederived"]["dG_d"][name]
        assert abs(stated.value - value) <= 5 * stated.error + 1e-8, name  # rederived to nine digits


@pytest.mark.parametrize("order", [1, 2, 3])
def test_an_error_of_one_power_of_the_step_is_extrapolated_away(order):
    runs = [5.0 + 0.1 * (0.5**k) ** order for k in range(3)]
    for known in (order, None):
        found = limit(runs, known)
        assert found.value == pytest.approx(5.0, abs=1e-14)
        assert found.order == pytest.approx(order, abs=1e-9)


def test_the_estimated_error_is_that_of_the_next_power_of_the_step():
    runs = [5.0 + 0.1 * h**2 + 0.01 * h**3 for h in (1, 0.5, 0.25)]
    found = limit(runs, 2)
    # e_2 lacks 0.01 h^3 (1 / 8 - (1 / 4 - 1 / 8) / 3 ...): its own estimate meets it, as there is no further power
    assert found.error == pytest.approx(abs(found.value - 5.0), rel=1e-9)


def test_runs_without_an_order_are_not_extrapolated():
    for runs in ([1.0, 1.2, 0.9], [1.0, 1.0, 1.0], [1.0, 1.1, 1.2]):
        found = limit(runs, 2)
        assert math.isnan(found.order)
        assert found.value == runs[-1]
        assert found.error >= abs(runs[-1] - runs[-2])
    assert limit([1.0, 1.1, 1.2], 2).stalled
    assert not limit([1.0, 1.4, 1.5], 1).stalled


def test_no_member_of_the_pareto_set_is_dominated_and_all_others_are(pendulum):
    rng = np.random.default_rng(0)
    clouds = [[tuple(point) for point in rng.integers(0, 6, (40, 2)).astype(float)] for _ in range(20)]
    clouds.append([(each.price, each.ratio) for each in pendulum.settings if not each.outcome.failed])
    for points in clouds:
        best = pareto(points)
        for k, point in enumerate(points):
            smaller = [p for p in points if p != point and p[0] <= point[0] and p[1] <= point[1]]
            twin = any(points[b] == point for b in best)
            assert (k in best or twin) == (not smaller)
        assert len({points[k] for k in best}) == len(best)
    assert pareto([(math.nan, 1.0), (1.0, math.inf)]) == []


def test_the_recommended_fragment_pasted_into_the_scene_reproduces_the_error(pendulum, tmp_path):
    from toolkit.studies.tradeoff.tradeoff import changes, solver_fragment

    best, case = pendulum.recommended, pendulum.plan.case
    assert best is not None
    assert all(error + pendulum.reference.error(q) <= pendulum.plan.budget[q] for q, error in best.errors.items())
    text = PENDULUM.read_text()
    head, _, _ = text.partition("[solver]")
    (tmp_path / "scene.toml").write_text(head + solver_fragment(case, best.setting) + "\n")
    for scene in (read_scene(tmp_path / "scene.toml"), read_scene(PENDULUM, SHORT | changes(case, best.setting))):
        again = direct(scene, list(scene.design), "transient")
        record = SettingOutcome(values=again.values, gradients=again.gradients)
        assert errors(pendulum.reference, record) == pytest.approx(
            best.errors, rel=1e-6, abs=1e-12
        )  # round-off of the two methods


def test_of_all_settings_that_keep_the_budget_none_is_clearly_faster_than_the_recommended(pendulum):
    kept = [each for each in pendulum.settings if each.kept]
    assert pendulum.recommended in kept
    assert pendulum.recommended.price <= 1.05 * min(each.price for each in kept)


def test_a_table_comes_back_from_its_text():
    table = {"a": True, "b": 0.1, "c": 'x"y', "d": [1.0, 2.0], "e": {"damping": 1e-7, "k": 3}}
    assert parse_toml(toml_table("solver", table)) == {"solver": table}


def test_a_second_study_runs_nothing_again_and_another_scene_uses_nothing_of_it(tmp_path, monkeypatch):
    ran: list[str] = []
    true = setting_run.run_setting
    monkeypatch.setattr(setting_run, "run_setting", lambda case, setting: ran.append(str(setting)) or true(case, setting))
    first = study(tmp_path, axes="step=0.02/0.01")
    assert len(ran) == 2 + 3  # two settings, three runs of the reference
    ran.clear()
    second = study(tmp_path, axes="step=0.02/0.01")
    assert ran == []
    assert [each.outcome for each in second.settings] == [each.outcome for each in first.settings]  # times too
    study(tmp_path, axes="step=0.02/0.01/0.005")  # one more, and a finer reference, which shares the runs it can
    assert len(ran) == 1 + 1
    ran.clear()
    study(tmp_path, changes=SHORT | {"bodies.bob.mass": "2.0"}, axes="step=0.02/0.01")
    assert len(ran) == 5


def test_a_damaged_record_is_run_again(tmp_path):
    first = study(tmp_path, axes="step=0.02")
    key = first.plan.case.key(first.settings[0].setting)
    file = tmp_path / "records" / f"{key}.json"
    file.write_text(file.read_text()[:100])
    again = study(tmp_path, axes="step=0.02")
    assert again.settings[0].outcome.values == first.settings[0].outcome.values
    found = RunFolder(tmp_path / "records", SettingOutcome).find(key)
    assert found is not None
    assert found.values == first.settings[0].outcome.values


@pytest.mark.robustness
def test_a_killed_study_leaves_whole_records_and_goes_on_from_them(tmp_path):
    arguments = ["tradeoff", str(PENDULUM), *SET, "--axes", "step=0.02/0.01,rho_inf", "-o", str(tmp_path), "--jobs", "2", "-q"]
    command = [sys.executable, "-m", "toolkit.command_line.cli", *arguments]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    deadline = time.monotonic() + 60

    def records() -> list[Path]:
        return [file for file in tmp_path.glob("records/*.json") if ".tmp" not in file.name]

    while len(records()) < 4 and time.monotonic() < deadline:
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    store = RunFolder(tmp_path / "records", SettingOutcome)
    whole = {file.stem: store.find(file.stem) for file in records()}
    assert len(whole) >= 4
    before = {key: outcome.values for key, outcome in whole.items() if outcome is not None}
    assert len(before) == len(whole)
    done = CliRunner().invoke(app, [*arguments[:-2], "1", "-q", "--repeats", "1", "--json"])
    assert done.exit_code in (0, 1), done.stderr  # 1 if no setting keeps the budget
    after = {file.stem: json.loads(file.read_text())["values"] for file in records() if file.stem in before}
    assert after == before


def test_a_setting_that_is_refused_is_listed_with_the_reason(tmp_path):
    found = study(tmp_path, changes={"solver.end_time": "2.0", "solver.step": "0.01"}, axes="step=1.0/0.01")
    (failed,) = found.failed
    assert failed.setting.labels == {"step": "1"}
    assert failed.outcome.reason
    assert found.settings[-1] is failed
    assert math.isinf(failed.ratio)
    done = CliRunner().invoke(
        app, ["tradeoff", str(PENDULUM), "--set", "solver.end_time=2.0", "--set", "solver.step=0.01", "--axes", "step=1.0/0.01",
              "--budget", "all=0.1", "-o", str(tmp_path), "-q"],
    )  # fmt: skip
    assert done.exit_code == 0, done.stderr
    assert (
        f"failed: step 1: {failed.outcome.reason}".split()[:8]
        == done.stdout.split("failed: ")[1].join(["failed: ", ""]).split()[:8]
    )


def test_a_budget_that_nothing_keeps_is_an_error_that_says_how_near_it_was(tmp_path):
    found = study(tmp_path, axes="step=0.02/0.01", budgets=["move_x=1e-6"])
    assert found.recommended is None
    with pytest.raises(BudgetError, match=r"nearest is step 0.01.*--axes step=0.005/0.0025"):
        found.check()


def test_without_design_variables_values_alone_are_judged(tmp_path):
    found = study(tmp_path, axes="step=0.02/0.01", names=[])
    assert {quantity.derived for quantity in found.plan.budget} == {False}
    assert all(each.outcome.primal == each.outcome.whole for each in found.settings)


def test_a_response_that_is_zero_is_compared_with_what_its_variables_do(pendulum):
    """The motion does not depend on the mass, whose gradients of the places are round-off: they do not spoil the measure."""
    assert min(each.errors[ErrorQuantity("move_x", True)] for each in pendulum.settings if not each.outcome.failed) < 1e-3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"axes": "steps"}, "no axis 'steps', did you mean 'step'; available: step, scheme"),
        ({"axes": "step,step=0.1"}, "'step' is named twice"),
        ({"axes": "step="}, "has no values"),
        ({"axes": " , "}, "names nothing"),
        ({"axes": "scheme=euler"}, "solver.scheme"),
        ({"axes": "rho_inf=2"}, "solver.rho_inf"),
        ({"axes": "step=fast"}, "solver.step"),
        ({"axes": "modes"}, "needs a flexible body with a skin file"),
        ({"axes": "step,tolerance=" + "/".join(f"1e-{k / 1000 + 3}" for k in range(1000))}, "at most 2000"),
        ({"budgets": ["speed=1e-3"]}, "no response 'speed' to have a budget; the scene has move_x"),
        ({"budgets": ["move_z=1e-3"]}, "no response 'move_z' to have a budget, did you mean 'move_y'; the scene has"),
        ({"budgets": ["move_x=-1"]}, "is no budget"),
        ({"budgets": ["move_x"]}, "is no budget"),
        ({"budgets": ["all=nan"]}, "is no budget"),
        ({"gradient_budgets": ["move_x=1e-2"], "names": []}, "need design variables"),
    ],
)
def test_what_cannot_be_meant_is_refused_before_anything_runs(tmp_path, options, message):
    with pytest.raises(InputError, match=message):
        planned(tmp_path, **options)
    assert list(tmp_path.iterdir()) == []


def test_budgets_of_single_responses_differ_from_that_of_all():
    found = read_budget(["a", "b"], ["b=1e-2", "all=1e-4", "d(a)=0.5"], [], True)
    assert found == {("a", False): 1e-4, ("b", False): 1e-2, ("a", True): 0.5}
    assert read_budget(["a", "b"], [], [], True)["b", True] == 10 * read_budget(["a", "b"], [], [], True)["b", False]


def test_every_axis_of_the_solver_has_choices_that_the_solver_takes():
    scene = read_scene(PENDULUM)
    for name in available():
        if name in SOLVER_AXES:
            axes = read_axes(scene, name)
            assert sum(choice.own for choice in axes[name]) == 1, name
            assert 1 < len(grid(scene, axes)) <= len(axes[name])


def test_the_command_writes_table_json_and_picture(tmp_path):
    arguments = ["tradeoff", str(PENDULUM), *SET, "--axes", "step=0.02/0.01/0.005"]
    arguments += ["--budget", "all=1e-2", "--output", str(tmp_path), "--repeats", "1", "--jobs", "1", "--quiet"]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 0, done.stderr
    assert "Cheapest within the budget: step 0.005" in done.stdout or "Cheapest within the budget: step 0.01" in done.stdout
    assert "[solver]\nend_time = 2.0\nstep = 0.0" in done.stdout
    record = json.loads(CliRunner().invoke(app, [*arguments, "--json"]).stdout)
    assert record == json.loads((tmp_path / "tradeoff.json").read_text())
    assert {each["setting"]["step"] for each in record["settings"] if each["own"]} == {"0.02"}
    for picture in ("tradeoff.png", "tradeoff.svg"):
        assert (tmp_path / picture).stat().st_size > 5000


@pytest.mark.usefixtures("programs_here")
def test_modes_and_elements_are_built_afresh_and_their_fragment_builds_the_same_model(tmp_path):
    """A coarse mesh is that of a skin file in which its keys stand, interface points at the same places."""
    pytest.importorskip("gmsh")
    from preprocessing import build
    from toolkit.reduced_model.file import load
    from toolkit.studies.tradeoff.tradeoff import skin_fragments

    wing = Path(shutil.copytree(WING, tmp_path / "wing"))
    (wing / "skin.toml").write_text((wing / "skin.toml").read_text().replace("elements = 30", "elements = 12").replace("10 }", "4 }")
                                    .replace("25 }", "10 }").replace("30 }", "12 }"))  # fmt: skip
    short = {"solver.end_time": "0.4", "solver.step": "0.05", "loads.drive.curve.duration": "0.4"}
    found = study(
        tmp_path / "out",
        wing / "scene.toml",
        short,
        axes="modes=full/2,elements=6",
        names=["M_t"],
        budgets=["drive_angle=0.1"],
    )
    assert found.failed == []
    sizes = {tuple(each.setting.labels.values()): each.outcome.coordinates for each in found.settings}
    assert sizes["full", "6"] - sizes["2", "6"] == 3 * 6 - (
        9 + 2
    )  # per node; static shapes of three interface points, and two modes
    assert [each.skin["skin.elements"] for each in found.reference.in_mesh] == [3, 6, 12]
    coarse = next(each for each in found.settings if each.setting.labels == {"modes": "2", "elements": "6"})
    fragment = skin_fragments(found.plan.case, coarse.setting)["skin"]
    text = (wing / "skin.toml").read_text()
    kept = {name: table for name, table in parse_toml(text).items() if name not in parse_toml(fragment)}
    units = f'units = "{kept.pop("units")}"\nrotary_inertia = {str(kept.pop("rotary_inertia")).lower()}\n\n'
    (wing / "other.toml").write_text(units + "\n\n".join([*(toml_table(name, each) for name, each in kept.items()), fragment]))
    ours = build(wing / "other.toml")
    theirs = load(found.plan.case.scene_of(coarse.setting).bodies["skin"].model)
    assert ours.n_f == theirs.n_f
    np.testing.assert_array_equal(ours.mesh.nodes, theirs.mesh.nodes)
    assert {name: float(place.arc_length) for name, place in ours.interfaces.items()} == pytest.approx(
        {name: float(place.arc_length) for name, place in theirs.interfaces.items()}, rel=1e-12
    )


def remeshed(tmp_path: Path, more: str, elements: int, **keys):
    """The wing's skin file with more in it, meshed by another number of elements."""
    from preprocessing.builders.skin_recipe import SkinRecipe, with_keys

    (tmp_path / "skin.toml").write_text((WING / "skin.toml").read_text().replace('clamp = "F"', 'clamp = "F"\n' + more, 1))
    arc_lengths = np.arange(31.0)  # of 30 elements of length 1
    return with_keys(SkinRecipe.read(tmp_path / "skin.toml").file, {"skin.elements": elements, **keys}, lambda: arc_lengths)


def test_points_and_groups_stay_where_they_are_in_another_mesh(tmp_path):
    more = "[groups.nose]\nelements = [10, 19]\nthickness = 1.0"
    found = remeshed(tmp_path, more, 15, basis={"kind": "static"})
    assert {name: place.model_dump(exclude_none=True) for name, place in found.interface_points.items()} == {
        "C": {"node": 5}, "E": {"arc_length": 25.0}, "G": {"node": 15}
    }  # fmt: skip
    assert found.groups["nose"].elements == [5, 9]
    assert found.basis.kind == "static"
    assert remeshed(tmp_path, more, 60).groups["nose"].elements == [20, 39]


@pytest.mark.parametrize(
    ("more", "elements", "message"),
    [
        ("[groups.nose]\nelements = [10, 19]\nthickness = 1.0", 20, "groups.nose ends where no element of a mesh of 20 does"),
        ('separate = ["thickness"]', 15, "quantities of single elements mean others in another mesh"),
        ("", 3000, "skin.elements: .*2000"),
    ],
)
def test_a_mesh_that_does_not_fit_is_refused(tmp_path, more, elements, message):
    with pytest.raises(InputError, match=message):
        remeshed(tmp_path, more, elements)
