"""Public names: what a user imports, compiled once, analysed many times, with words for all that can be typed wrong."""

from __future__ import annotations

import ast
import copy
import inspect
import math
import re
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import ffrf
import preprocessing
import toolkit
from toolkit.analyses import transient
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.sensitivity.preparation import ANALYSES
from toolkit.components.curves.catalogue import Curve
from toolkit.responses.response import Response
from toolkit.scene.kinds import kinds_of

MODELS = Path(__file__).parents[2] / "models"
WING = MODELS / "morphing_wing" / "scene.toml"
PENDULUM = MODELS / "pendulum" / "scene.toml"


@pytest.fixture(scope="module")
def wing() -> ffrf.Model:
    return ffrf.compile(ffrf.read_scene(WING), variables=["t_w", "M_t"])


# --- what is there ---------------------------------------------------------------------------------------------------------------


def test_all_names_are_there_and_type_checkers_see_the_same_ones():
    block = next(node for node in ast.parse(inspect.getsource(toolkit)).body if isinstance(node, ast.If))
    typed = {alias.asname or alias.name for node in ast.walk(block) if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert typed == set(toolkit.__all__) == set(toolkit._PLACES) == {*ffrf.__all__} - {"preprocessing"}
    for name in ffrf.__all__:
        assert getattr(ffrf, name).__doc__
        assert name == "preprocessing" or getattr(ffrf, name) is getattr(toolkit, name)
    assert re.match(r"\d+\.\d+", ffrf.__version__)


def test_no_name_hides_a_room_nor_is_hidden_by_one():
    """A room becomes an attribute of the package as soon as anybody imports it."""
    for package in (toolkit, preprocessing):
        rooms = {path.name for path in Path(package.__file__).parent.iterdir()}
        hidden = {
            name
            for name in rooms & set(package.__all__)
            if getattr(package, name) is not import_module(f"{package.__name__}.{name}")
        }
        assert hidden == set()


def test_importing_it_loads_nothing():
    code = "import sys, ffrf; print('numpy' in sys.modules, 'toolkit.foundation' in sys.modules)"
    assert (
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split() == ["False"] * 2
    )


def test_a_name_that_is_not_there_lists_those_that_are():
    with pytest.raises(AttributeError, match=r"ffrf has no 'simulate'; it has: .*compile.*read_scene"):
        _ = ffrf.simulate
    with pytest.raises(AttributeError, match=r"ffrf has no 'read_scen', did you mean 'read_scene'; it has: "):
        _ = ffrf.read_scen


def test_names_of_preprocessing_are_imported_from_the_public_package_and_are_the_same():
    from ffrf.preprocessing import __all__ as names
    from ffrf.preprocessing import build

    assert build is preprocessing.build
    assert ffrf.preprocessing.save is preprocessing.save
    assert sorted(names) == sorted(preprocessing.__all__)
    with pytest.raises(AttributeError, match="preprocessing has no 'biuld'"):
        _ = ffrf.preprocessing.biuld


@pytest.mark.parametrize(("dimension", "place"), [(2, "plane"), (3, "space")])
def test_every_kind_that_a_scene_file_can_name_can_be_imported(dimension, place):
    module = getattr(ffrf, place)
    offered = {getattr(module, name) for name in module.__all__}
    for kinds in [*kinds_of(dimension).values(), Response.kinds, Curve.kinds]:
        built_in = {kind for name, kind in kinds.items() if name != "ground" and kind.__module__.startswith("toolkit.")}
        assert built_in <= offered


def test_every_public_name_states_its_parameters_and_errors():
    members = [(ffrf.Model, name) for name in ("at", "simulate", "statics", "modes", "map", "run")]
    members += [(ffrf.Run, name) for name in ("render", "save")]
    for function in [getattr(owner, name) for owner, name in members] + [ffrf.compile, ffrf.load, ffrf.read_scene]:
        text = inspect.getdoc(function)
        assert "Raises\n------" in text, function
        for parameter in list(inspect.signature(function).parameters)[function.__qualname__.count(".") :]:
            assert re.search(rf"^{parameter}\b|^[\w, ]*\b{parameter}\b[\w, ]*$", text, re.MULTILINE), (function, parameter)


# --- what it does ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("analysis", "kind"), [("simulate", "transient"), ("statics", "static")])
def test_an_analysis_gives_what_the_analysis_below_gives_and_repeats_nothing(wing, analysis, kind, monkeypatch):
    run = getattr(wing, analysis)(gradients=True)
    below = direct(wing.scene, ["t_w", "M_t"], kind)
    assert (run.values, run.gradients, run.units) == (below.values, below.gradients, below.units)
    solved = []
    for name, original in ANALYSES.items():
        monkeypatch.setitem(ANALYSES, name, lambda *a, original=original, **k: solved.append(1) or original(*a, **k))
    getattr(wing, analysis)(gradients=True)
    assert len(solved) == 1


def test_the_steps_of_a_motion_are_five_calls_below_the_public_one(wing, monkeypatch):
    """Of functions of the toolkit; the fifth is that of the compiled loop."""
    passed, steps = [], transient.take_steps

    def take_steps(*given) -> None:
        frame = sys._getframe(1)
        while frame is not None:
            if Path(toolkit.__file__).parent in Path(frame.f_code.co_filename).parents:
                passed.append(frame.f_code.co_name)
            frame = frame.f_back
        steps(*given)

    monkeypatch.setattr(transient, "take_steps", take_steps)
    wing.simulate()
    assert passed == ["advance", "simulate", "analysed", "simulate"]


def test_times_are_measured_where_they_are_asked_for(wing):
    assert wing.simulate(gradients="direct").wall_primal is None
    timed = wing.simulate(gradients="direct", timed=True)
    assert timed.wall_primal > 0
    assert timed.wall_sensitivity >= 0


@pytest.mark.parametrize("numbers", [{"t_w": 1.6}, {"bodies.skin.thickness": 1.6, "M_t": 4000}, {"points.A.x": 73.5}])
def test_other_numbers_give_what_a_scene_with_them_gives(wing, numbers):
    fresh = ffrf.compile(ffrf.read_scene(WING, numbers), variables=["t_w", "M_t"]).simulate(gradients="direct")
    run = wing.simulate(numbers, gradients="direct")
    assert (run.values, run.gradients) == (fresh.values, fresh.gradients)
    assert wing.variables == {"t_w": 1.5, "M_t": 4200.0}  # the model itself stays what it is


def test_other_numbers_compile_nothing_anew():
    """The scene is compiled once without its variables and once with them, however many numbers follow."""
    model = ffrf.compile(ffrf.read_scene(WING), variables=["t_w", "M_t"])
    runs = [model.simulate({"t_w": 1.5 + 0.01 * k}, gradients=how) for k in range(3) for how in (False, "direct")]
    numberings = [run.solution.system.numbering for run in runs]
    assert len({id(numbering) for numbering in numberings}) == 2


def test_numbers_of_the_solver_can_be_changed_too(wing):
    assert wing.simulate({"solver.step": 0.1}).solution.steps == wing.simulate().solution.steps / 2


def test_an_equilibrium_can_begin_in_that_of_another_design(wing):
    """Newton goes on to round-off from wherever it starts; a thin skin leaves nine digits of a gradient."""
    near, far = wing.statics({"t_w": 1.52}, gradients=True, start=wing.statics()), wing.statics({"t_w": 1.52}, gradients=True)
    assert near.solution.load_steps == 0
    assert "own-start" in [each.code for each in near.warnings]
    for name, value in far.values.items():
        assert near.values[name] == pytest.approx(value, rel=1e-9)
        for variable, slope in far.gradients[name].items():
            assert near.gradients[name][variable] == pytest.approx(slope, rel=1e-8)


def test_where_a_design_is_too_far_the_path_is_followed_from_its_beginning(wing):
    far = wing.statics({"M_t": 420.0}, start=wing.statics())
    assert far.solution.load_steps > 0
    assert "own-start" not in [each.code for each in far.warnings]


def test_a_motion_can_begin_where_another_ends():
    """Half a swing and the other half are a whole one, but for the step at which the forces of the first half are forgotten."""
    model = ffrf.compile(ffrf.read_scene(PENDULUM, {"solver.step": 1e-3, "solver.end_time": 1.0}))
    half = model.simulate({"solver.end_time": 0.5})
    rest, whole = model.simulate({"solver.end_time": 0.5}, start=half), model.simulate()
    np.testing.assert_allclose(rest.solution.q[-1], whole.solution.q[-1], atol=1e-5)  # second order in the step


@pytest.mark.parametrize("name", ["slider_crank", "four_bar_chain", "rotating_beam"])
def test_a_motion_can_begin_in_a_state_whose_joints_are_as_open_as_its_steps_left_them(name):
    model = ffrf.compile(ffrf.read_scene(MODELS / name / "scene.toml"))
    short = {"solver.end_time": 10 * float(model.scene.solver.step)}
    first = model.simulate(short)
    second = model.simulate(short, start=first)
    begun, ended = second.solution.q[0], first.solution.q[-1]
    weights = second.solution.system.weights[: len(begun)]
    assert np.max(weights * np.abs(begun - ended)) < 10 * model.scene.solver.drift_tolerance


def test_a_start_that_is_moved_by_more_than_joints_may_drift_is_told():
    """A start whose first body stands off its joint by twice what they may drift; more than ten times is refused."""
    model = ffrf.compile(ffrf.read_scene(MODELS / "slider_crank" / "scene.toml"))
    short = {"solver.end_time": 10 * float(model.scene.solver.step)}
    first = model.simulate(short)
    assert "start-moved" not in model.simulate(short, start=first).verdict.codes
    weights = first.solution.system.weights
    first.solution.q[-1, 0] += 4 * model.scene.solver.drift_tolerance / weights[0]
    second = model.simulate(short, start=first)
    assert "start-moved" in second.verdict.codes
    assert 1 < second.solution.start_moved / model.scene.solver.drift_tolerance < 10


def test_a_motion_whose_driver_begins_elsewhere_cannot_be_gone_on_with():
    """Curves begin at t = 0 again: the crank would have to be where it began."""
    model = ffrf.compile(ffrf.read_scene(MODELS / "bracket" / "scene.toml", {"solver.end_time": 0.01}))
    with pytest.raises(ffrf.ToolkitError, match="time curves"):
        model.simulate(start=model.simulate())


def test_a_model_file_that_changes_after_the_compilation_is_refused_everywhere(tmp_path):
    folder = Path(shutil.copytree(WING.parent, tmp_path / "wing"))
    model = ffrf.compile(ffrf.read_scene(folder / "scene.toml"), variables=["t_w"])
    run = model.statics(gradients=True)
    shutil.copyfile(MODELS / "snap_through" / "skin.h5", folder / "skin.h5")
    calls = [
        model.statics,
        model.simulate,
        model.modes,
        lambda: model.statics({"t_w": 1.4}),
        lambda: run.stress("skin"),
        run.plot,
    ]
    for call in [*calls, run.table, lambda: run.render(tmp_path), lambda: run.save(tmp_path / "run.h5")]:
        with pytest.raises(ffrf.ToolkitError, match="has changed since the scene was compiled"):
            call()


def test_any_number_of_changes_one_after_the_other_cost_no_more_than_one():
    model = base = ffrf.compile(ffrf.read_scene(WING), variables=["t_w"])
    for k in range(1500):
        model = model.at({"t_w": 1.5 + 1e-4 * (k % 7), "M_t": 4200.0})
    assert model._compiled.base is base._compiled
    assert model.statics().values == base.statics({"t_w": 1.5 + 1e-4 * (1499 % 7)}).values


def test_a_model_can_be_copied_as_processes_do_and_a_run_says_how_it_is_kept(wing):
    wing.statics()
    again = copy.deepcopy(wing)
    assert again.statics({"t_w": 1.6}).values == wing.statics({"t_w": 1.6}).values
    with pytest.raises(TypeError, match=r"run\.save"):
        copy.deepcopy(wing.statics())


def test_numbers_inside_of_sums_of_curves_are_checked_too(wing):
    plane, drive = ffrf.plane, wing.scene.loads["drive"]
    curve = plane.Sum(terms=(plane.SmoothStep(duration=1.0), plane.Sine(amplitude=0.1, frequency=1.0)))
    loads = {"drive": drive.model_copy(update={"curve": curve})}
    model = ffrf.compile(wing.scene.model_copy(update={"loads": loads}))
    for value in (-1.0, 0.0, math.nan):
        with pytest.raises(ffrf.ToolkitError, match=r"loads\.drive\.curve\.terms\.0\.duration"):
            model.statics({"loads.drive.curve.terms.0.duration": value})
    assert model.statics({"loads.drive.curve.terms.0.duration": 0.9}).values


def test_modes_are_those_about_the_equilibrium(wing):
    found = wing.modes(count=2)
    assert len(found.frequencies) == 2
    assert repr(found).startswith(f"<Modes: {found.frequencies[0]:.6g}")
    assert [each.code for each in found.verdict.warnings] == [each.code for each in wing.statics().solution.warnings]


@pytest.mark.parametrize("processes", [1, 2])
def test_many_designs_come_back_in_order_and_failures_with_their_reason(wing, processes):
    designs = [{"t_w": 1.4}, {"t_w": -1.0}, {"M_t": 1e9}, {"t_w": 1.5}]
    done = []
    found = wing.map(
        designs, "statics", gradients=True, processes=processes, judged=False, progress=lambda k, n: done.append((k, n))
    )
    assert [each.numbers for each in found] == designs
    assert [each.failed for each in found] == [False, True, True, False]
    assert "must be a positive number" in found[1].error
    assert "limit point" in found[2].error
    here = wing.statics(gradients=True)
    assert (found[3].values, found[3].gradients, found[3].verdict) == (here.values, here.gradients, None)
    assert done[-1] == (4, 4)


def test_designs_in_threads_have_the_bits_of_single_runs(wing):
    designs = [{"t_w": 1.4, "M_t": 4100.0}, {"chord": 1.0}, {"t_w": -1.0}, {"t_w": 1.6}, {}, {"M_t": 4300.0, "solver.step": 0.1}]
    alone, together = (wing.map(designs, gradients=True, threads=threads, judged=False) for threads in (1, 3))
    assert together == alone
    assert [each.numbers for each in together] == designs
    assert [each.failed for each in together] == [False, True, True, False, False, False]
    assert "there is no number 'chord'" in together[1].error
    assert "must be a positive number" in together[2].error
    for each in together:
        if not each.failed:
            run = wing.simulate(each.numbers, gradients=True)
            assert (each.values, each.gradients) == (run.values, run.gradients)
        else:
            assert (each.values, each.gradients) == ({}, {})


def test_designs_in_threads_are_judged_as_single_ones(wing):
    designs = [{"t_w": 1.4}, {"t_w": 1.6}]
    found = wing.map(designs, threads=2)
    assert [each.verdict for each in found] == [wing.simulate(design).verdict for design in designs]


def test_a_run_is_kept_and_read_back_with_its_verdict(wing, tmp_path):
    run = wing.simulate(gradients="direct")
    again = ffrf.load(run.save(tmp_path / "wing.h5"))
    assert (again.values, again.gradients, again.units, again.wall_primal) == (run.values, run.gradients, run.units, None)
    assert [each.code for each in again.warnings] == [each.code for each in run.warnings]
    assert again.table() == run.table()


def test_a_run_shows_itself_in_words_and_in_a_notebook(wing):
    run = wing.statics(gradients=True)
    text = run.table()
    for name, value in run.values.items():
        assert re.search(rf"^{name} +{re.escape(f'{value:.6g}')} +{run.units[name]}", text, re.MULTILINE)
        slope = re.escape(f"{run.gradients[name]['t_w']:.6g}")
        assert re.search(rf"^{name}, {run.units[name]} +{slope} ", text, re.MULTILINE)
    assert "NOT TO BE TRUSTED" in text
    page = run._repr_html_()
    assert page.count("<tr>") == 2 + 2 * len(run.values)
    assert f"<td>{run.values['max_stress']:.6g}</td>" in page
    assert repr(run).startswith("<Run: equilibrium, max_stress = ")


# --- what is typed wrong ---------------------------------------------------------------------------------------------------------

WRONG = {
    "a number that is not there": (lambda m: m.statics({"chord": 1.0}), "there is no number 'chord'.*bodies.skin.position.x"),
    "a value that cannot be": (lambda m: m.statics({"points.A.x": math.nan}), "points.A.x.*finite"),
    "a rod without area": (lambda m: m.statics({"bodies.body2.area": 0.0}), "bodies.body2.area: .*greater than 0"),
    "a solver without steps": (lambda m: m.simulate({"solver.step": -1.0}), "solver.step: .*greater than 0"),
    "a number that is no float": (lambda m: m.statics({"t_w": 10**400}), "larger than any valid number"),
    "a name that is none": (lambda m: m.statics({1: 1.0}), "1 is no name"),
    "nothing instead of numbers": (lambda m: m.statics(0), "numbers are given by name"),
    "a path instead of a scene": (lambda m: ffrf.compile("scene.toml"), r"compile takes a scene, .*ffrf\.read_scene"),
    "nothing as variables": (
        lambda m: ffrf.compile(m.scene, None),
        r"list of names, not None. Leave them out, or write variables=\[",
    ),
    "a number as variables": (lambda m: ffrf.compile(m.scene, 1), "list of names, not 1"),
    "a number as variable": (lambda m: ffrf.compile(m.scene, [1]), "variables are names"),
    "half a mode": (lambda m: m.modes(count=2.5), "whole number of modes"),
    "no mode": (lambda m: m.modes(count=0), "at least one"),
    "no thread": (lambda m: m.map([{}], threads=0), "threads = 0"),
    "threads in processes": (
        lambda m: m.map([{}], threads=2, processes=2),
        "Leave out all but one of processes, threads and dask",
    ),
    "half a process": (lambda m: m.map([{}], processes=1.5), "processes = 1.5"),
    "one design": (lambda m: m.map({"t_w": 1.6}), "designs are a list"),
    "a list as method": (lambda m: m.statics(gradients=["direct"]), "no method"),
    "a body that is not there": (lambda m: m.statics().stress("nix"), "body 'nix', which does not exist"),
    "a picture of nothing": (lambda m: m.statics().render(width=0), "width = 0"),
    "a price with a start": (lambda m: m.statics(start=m.statics(), timed=True), "Leave out one of timed and start"),
    "a text": (lambda m: m.statics({"t_w": "1.6"}), "t_w = '1.6' is no number"),
    "a truth value": (lambda m: m.statics({"t_w": True}), "t_w = True is no number"),
    "one number twice": (lambda m: m.statics({"t_w": 1.6, "bodies.skin.thickness": 1.7}), "same number.*Give it once"),
    "a list": (lambda m: m.statics([1.6]), "numbers are given by name"),
    "a method": (lambda m: m.statics(gradients="exact"), "no method 'exact'.*auto, direct, adjoint"),
    "an analysis": (lambda m: m.map([{}], "static analysis"), "no analysis 'static analysis'.*transient, static"),
    "a variable": (
        lambda m: ffrf.compile(m.scene, ["thickness"]),
        "unknown design variable 'thickness', did you mean 'bodies.skin.thickness'; short names.*t_w",
    ),
    "variables as a text": (lambda m: ffrf.compile(m.scene, "t_w"), r"list of names, not the text 't_w'. Write \['t_w'\]"),
    "no variables": (lambda m: ffrf.compile(m.scene).statics(gradients=True), r"no design variables.*compile\(scene, variables="),
    "a start that is no run": (lambda m: m.statics(start={"q": 1}), "start must be a run"),
    "a motion as start of statics": (lambda m: m.statics(start=m.simulate()), "a start of statics is an equilibrium"),
    "the start of another scene": (
        lambda m: m.simulate(start=ffrf.compile(ffrf.read_scene(PENDULUM)).simulate()),
        "other bodies or joints",
    ),
    "the adjoint from a start": (
        lambda m: m.simulate(gradients="adjoint", start=m.statics()),
        "direct differentiation, not 'adjoint'",
    ),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_typed_wrong_is_refused_with_what_would_be_right(wing, what):
    call, message = WRONG[what]
    with pytest.raises(ffrf.ToolkitError, match=f"(?s){message}"):
        call(wing)


# --- pictures --------------------------------------------------------------------------------------------------------------------


def test_a_motion_plots_its_curves_and_an_equilibrium_its_picture(wing):
    curves, picture = wing.simulate().plot(), wing.statics().plot()
    assert [axes.get_ylabel() for axes in curves.axes] == ["stress in MPa", "distance to target in mm", "rotation in rad"]
    (drawn,) = [line for line in curves.axes[2].lines if line.get_label().startswith("body2")]
    assert drawn.get_ydata()[-1] == pytest.approx(wing.simulate().values["drive_angle"], rel=1e-12)
    corner, right, up = picture.axes[0].transData.transform([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    assert right[0] - corner[0] == pytest.approx(up[1] - corner[1], rel=1e-6)  # x and y to one scale
    assert picture._repr_png_().startswith(b"\x89PNG")  # what a notebook asks for that nobody told of matplotlib


def test_a_run_is_drawn_into_files(wing, tmp_path):
    run = wing.statics()
    assert [file.name for file in run.render(tmp_path, width=400)] == ["step-0.png"]
    (drawn,) = run.render(tmp_path, width=400, format="svg")
    assert drawn.read_text().startswith("<?xml")
    with pytest.raises(ffrf.ToolkitError, match="no pictures of format 'gif'"):
        run.render(tmp_path, format="gif")


def test_an_equilibrium_in_space_says_where_its_pictures_are():
    space = ffrf.space
    rod = space.Rod(between=("O", "P"), area=1e-4, density=7800.0)
    scene = ffrf.Scene(
        units="m-kg-s",
        dimension=3,
        points={"O": space.Point(x=0.0, y=0.0, z=0.0), "P": space.Point(x=0.0, y=0.0, z=-1.0)},
        bodies={"rod": rod},
        joints={"hinge": space.Revolute(bodies=("rod", "ground"), point="O", axis=(0.0, 1.0, 0.0))},
        loads={"weight": space.Gravity(acceleration=(0.0, 0.0, -9.81))},
    )
    model = ffrf.compile(scene)
    with pytest.raises(ffrf.ToolkitError, match=r"run\.render"):
        model.statics().plot()


def test_a_reduced_model_replaces_nothing_but_a_reduced_model(tmp_path):
    section = preprocessing.Section(youngs_modulus=7e10, density=2700.0, thickness=0.01, width=0.02)
    beam = preprocessing.polygon_beam(np.array([[0.0, 0.0], [1.0, 0.0]]), section, {"tip": 1.0})
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(ffrf.ToolkitError, match="not a reduced model"):
        preprocessing.save(beam, tmp_path / "notes.txt")
    assert (tmp_path / "notes.txt").read_text() == "mine"
    for _ in range(2):
        preprocessing.save(beam, str(tmp_path / "beam.h5"))


@pytest.mark.parametrize("quantity", ["youngs_modulus", "density", "thickness", "width", "damping_mass"])
def test_a_beam_of_nothing_is_refused(quantity):
    section = dict(youngs_modulus=7e10, density=2700.0, thickness=0.01, width=0.02) | {quantity: -1.0}
    with pytest.raises(ffrf.ToolkitError, match=f"{quantity} = -1.0"):
        preprocessing.polygon_beam(np.array([[0.0, 0.0], [1.0, 0.0]]), preprocessing.Section(**section), {})
