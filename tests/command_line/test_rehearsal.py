"""What is compiled before a command is exactly what the command calls, so that no wall time holds any of it, and it is announced."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest
from numba.core import event
from typer.testing import CliRunner

from toolkit.analyses.sensitivity.preparation import price
from toolkit.command_line import announcements
from toolkit.command_line.announcements import compile_before
from toolkit.command_line.cli import app
from toolkit.command_line.rehearsal import rehearse, rehearse_everything, rehearse_others
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.compiled.compile_watch import watched_compilation
from toolkit.scene.resolution import loaded
from toolkit.scene.space import PLANE
from toolkit.system.evaluation import formulas_of

ROOT = Path(__file__).parents[2]
MODELS = ROOT / "models"

PROBE = """
import json, os, sys
from numba.core.registry import CPUDispatcher
from toolkit.command_line.announcements import BACKWARDS, compile_before
from toolkit.command_line.rehearsal import rehearse
from toolkit.command_line.cli import app
from toolkit.foundation.compiled.compile_watch import watched_compilation
from toolkit.files.scene_reader import read_scene
from toolkit.analyses.sensitivity.preparation import evaluate_responses
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.analyses.sensitivity.methods import gradients_by

def loaded():
    ours = [vars(module).values() for name, module in list(sys.modules.items()) if name.startswith("toolkit")]
    kernels = {each for names in ours for each in names if isinstance(each, CPUDispatcher)}
    return sorted(f"{x.py_func.__name__} {signature}" for x in kernels for signature in x.overloads)

def answer(path, changes, kind, method, count, rehearsed):
    scene = read_scene(path, changes)
    with watched_compilation() as watch:
        if rehearsed:
            compile_before(scene, kind, kind == "transient" and method in BACKWARDS)
        before = loaded()
        if method == "none":
            solution = solve(prepare(scene), kind)
            evaluate_responses(solution)
        else:
            solution = gradients_by(method, scene, list(scene.design)[:count], kind).solution
        solution.verdict  # which holds what the commands print
    print(json.dumps([before, loaded(), watch.functions]), flush=True)

started = loaded()
for request in sys.stdin:
    if child := os.fork():
        if os.waitpid(child, 0)[1]:
            print(json.dumps(None), flush=True)
    else:
        assert loaded() == started  # as in a new process
        answer(*json.loads(request))
        os._exit(0)
"""
"""Answers requests from its standard input, each by a process of its own that has the imports behind it and has loaded no formula."""
SHORT = {"solver.end_time": "2e-4", "solver.step": "1e-4"}
RUNS = {
    "motion": ("four_bar_chain", SHORT | {"solver.formulation": "index-3"}, "transient", "none", 0),
    "both levels": ("four_bar_chain", SHORT | {"solver.formulation": "ggl"}, "transient", "direct", 1),
    "chosen steps and the force of a joint": ("pendulum", SHORT | {"solver.local_error": "1e-3"}, "transient", "none", 0),
    "states that do not fit": ("morphing_wing", {"solver.end_time": "0.1", "solver.memory": "1e-6"}, "transient", "adjoint", 2),
    "without inertia": ("morphing_wing", {"solver.end_time": "0.1", "solver.quasi_static": "true"}, "transient", "direct", 3),
    "equilibrium": ("morphing_wing", {"solver.load_steps": "2"}, "static", "direct", 5),
    "adjoint in space": ("spatial_bracket", SHORT, "transient", "adjoint", 2),
    "both levels in space": ("spatial_bracket", SHORT | {"solver.formulation": "ggl"}, "transient", "none", 0),
}
"""Model, changed values, analysis, method for gradients, and by how many variables: one column lies in memory as several do not."""
SMALL = ("revolute", "powers", "update_poses", "update_pose_designs", "add_lost", "choose_apart", "evaluate_states")
"""The joint and the response of the rehearsal, and what only some verdicts ask for: the energy balance, which a run in windows does
without, vibrations that steps take out, and the states of a motion that begins at rest. A few seconds."""


@pytest.fixture(scope="module")
def probe() -> Iterator[Callable[[str, bool], tuple[set[str], set[str]]]]:
    """Functions and signatures that were loaded from the disk before the analysis of a run, and after it."""
    command = [sys.executable, "-c", PROBE]
    with subprocess.Popen(command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:

        def ask(name: str, rehearsed: bool) -> tuple[set[str], set[str]]:
            model, changes, kind, method, count = RUNS[name]
            while True:
                request = json.dumps([str(MODELS / model / "scene.toml"), changes, kind, method, count, rehearsed])
                print(request, file=process.stdin, flush=True)
                found = json.loads(process.stdout.readline())
                assert found is not None, name  # the reason stands in the standard error of the tests
                before, after, compiled = found
                if not compiled:  # otherwise functions that others call are there too, which nobody loads by themselves
                    return set(before), set(after)

        yield ask


@pytest.mark.parametrize("name", RUNS)
def test_nothing_is_left_to_compile_and_nothing_is_compiled_in_vain(name, probe):
    before, after = probe(name, rehearsed=True)
    assert after - before == set()
    needed = probe(name, rehearsed=False)[1]
    assert {each for each in before - needed if each.split()[0] not in SMALL} == set()


def pretend_to_compile() -> None:
    with event.trigger_event("numba:compile", data={}), event.trigger_event("numba:compile", data={}):
        pass


def test_compilation_is_announced_before_it_begins_and_counted(monkeypatch, capsys):
    said: list[str] = []

    def pretended(*_) -> None:
        pretend_to_compile()
        said.append(capsys.readouterr().err)

    others: list[int] = []
    monkeypatch.setattr("toolkit.command_line.rehearsal.rehearse", pretended)
    monkeypatch.setattr("toolkit.command_line.rehearsal.rehearse_others", lambda scene: others.append(scene.dimension))
    monkeypatch.setattr("toolkit.foundation.compiled.compiled_code._TOLD", set())
    scene = read_scene(MODELS / "pendulum" / "scene.toml")
    compile_before(scene, "transient")
    functions, seconds = announcements.EXPECTED[2]
    assert said == [
        f"compiling the formulas for this machine, once for all commands: at most some {functions} functions, some {seconds} s of a free "
        "core ...\n"
    ]
    assert others == [2]
    assert capsys.readouterr().err == "2 functions compiled in 0 s; they are kept on the disk.\n"
    compile_before(scene, "transient", quiet=True)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(
        "toolkit.foundation.compiled.compiled_code._TOLD", {"kept"}
    )  # a warning has said where it is, or that it is nowhere
    compile_before(scene, "transient")
    assert capsys.readouterr().err.endswith("2 functions compiled in 0 s.\n")


@pytest.mark.parametrize("model", ["governor"])
def test_what_is_warmed_up_is_there_for_every_scene(model):
    scene = read_scene(MODELS / model / "scene.toml")
    rehearse_everything(scene.space)
    with watched_compilation() as watch:
        formulas_of(loaded(scene))
        rehearse_others(scene)
    assert watch.functions == 0


def test_warming_up_says_what_it_has_compiled(monkeypatch):
    monkeypatch.setattr(
        "toolkit.command_line.rehearsal.rehearse_everything", lambda space: space is PLANE and pretend_to_compile()
    )
    told = CliRunner().invoke(app, ["warm-up", "--json"])
    compiled = json.loads(told.stdout)["compiled"]
    assert {name: each["functions"] for name, each in compiled.items()} == {"2D": 2, "3D": 0}
    assert "2 functions compiled" in told.stderr
    assert CliRunner().invoke(app, ["warm-up", "--for", "space"]).stdout.startswith("nothing to compile")


def test_nothing_is_said_where_nothing_is_compiled(monkeypatch, capsys):
    monkeypatch.setattr("toolkit.command_line.rehearsal.rehearse", lambda *_: None)
    monkeypatch.setattr("toolkit.command_line.rehearsal.rehearse_others", lambda *_: pytest.fail("compiles for nobody"))
    compile_before(read_scene(MODELS / "pendulum" / "scene.toml"), "transient")
    assert capsys.readouterr().err == ""


def test_whoever_watches_is_told_how_far_it_has_come():
    done: list[int] = []
    with watched_compilation(on_function=done.append):
        pretend_to_compile()
    assert done == [1, 2]


def test_a_later_command_finds_its_formulas_whatever_the_first_one_was():
    """Functions that all other analyses of such a scene load are among those that the rehearsal of the others has loaded."""
    scene = read_scene(MODELS / "pendulum" / "scene.toml")
    rehearse_others(scene)
    for formulation in ("index-1", "index-3", "ggl"):
        options = scene.solver.model_copy(update={"formulation": formulation, "rho_inf": 0.8})
        for kind in ("transient", "static"):
            with watched_compilation() as watch:
                rehearse(scene.model_copy(update={"solver": options}), kind, backwards=True)
            assert watch.functions == 0


def test_a_repetition_that_compiles_does_not_count(monkeypatch):
    """Five minutes of a run of two seconds."""
    with watched_compilation() as watch:
        pretend_to_compile()
    watch.seconds, watch.rest = 298.0, 4.0
    times = iter([10.0, 12.0])
    monkeypatch.setattr("toolkit.analyses.sensitivity.preparation.clock", SimpleNamespace(perf_counter=lambda: next(times)))
    assert price(watch, True, lambda: None) == 2.0
    assert price(watch, False, lambda: None) == 4.0
    assert list(times) == []


def test_code_that_was_never_compiled_is_compiled_under_watch(tmp_path):
    """One small function in a cache of its own; the second process finds it on the disk."""
    code = """
from toolkit.command_line.cli import app
from toolkit.foundation.compiled.compile_watch import watched_compilation
from toolkit.components.joints.kernels.laws import SIGNATURE, angle_law
with watched_compilation() as watch:
    angle_law.compile(SIGNATURE)
print(watch.functions, watch.seconds > 0)
"""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", code]
    first, second = (
        subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True).stdout.split()
        for _ in range(2)
    )
    assert (int(first[0]) >= 1, first[1], second) == (True, "True", ["0", "False"])


def test_the_watch_ends_with_its_block():
    with watched_compilation() as watch:
        pretend_to_compile()
    pretend_to_compile()
    assert watch.functions == 2
