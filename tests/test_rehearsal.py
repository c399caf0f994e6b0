"""What is compiled before a command is exactly what the command calls, so that no wall time holds any of it, and it is announced."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core import event

from toolkit.command_line import announcements
from toolkit.command_line.announcements import compile_before
from toolkit.compile_watch import KIND, watched_compilation
from toolkit.scene_file import read_scene
from toolkit.sensitivity.analysis import repeated

ROOT = Path(__file__).parents[1]
MODELS = ROOT / "models"

PROBE = """
import json, sys
from numba.core.registry import CPUDispatcher
from toolkit.command_line.announcements import BACKWARDS, compile_before
from toolkit.scene_file import read_scene
from toolkit.sensitivity.analysis import evaluate_responses, prepare, solve
from toolkit.sensitivity.methods import gradients_by
from toolkit.validity.energy_balance import energy_balance

def loaded():
    ours = [vars(module).values() for name, module in list(sys.modules.items()) if name.startswith("toolkit")]
    kernels = {each for names in ours for each in names if isinstance(each, CPUDispatcher)}
    return sorted(f"{x.py_func.__name__} {signature}" for x in kernels for signature in x.overloads)

path, changes, kind, method, rehearsed = json.loads(sys.argv[1])
scene = read_scene(path, changes)
if rehearsed:
    compile_before(scene, kind, kind == "transient" and method in BACKWARDS)
before = loaded()
if method == "none":
    solution = solve(prepare(scene), kind)
    evaluate_responses(solution)
    if kind == "transient":
        energy_balance(solution)
else:
    gradients_by(method, scene, list(scene.design)[:1], kind)
print(json.dumps([before, loaded()]))
"""
SHORT = {"solver.end_time": "2e-4", "solver.step": "1e-4"}
RUNS = {
    "motion in the plane": ("four_bar_chain", SHORT, "transient", "none"),
    "with the force of a joint": ("pendulum", SHORT, "transient", "none"),
    "index 3, modified Newton": (
        "four_bar_chain",
        SHORT | {"solver.formulation": "index-3", "solver.newton": "modified"},
        "transient",
        "none",
    ),
    "both levels": ("four_bar_chain", SHORT | {"solver.formulation": "ggl"}, "transient", "direct"),
    "chosen steps": ("slider_crank", SHORT | {"solver.local_error": "1e-3"}, "transient", "none"),
    "scheme of the paper, flexible, adjoint": ("morphing_wing", {"solver.end_time": "0.1"}, "transient", "adjoint"),
    "states that do not fit": ("morphing_wing", {"solver.end_time": "0.1", "solver.memory": "1e-6"}, "transient", "adjoint"),
    "without inertia": ("morphing_wing", {"solver.end_time": "0.1", "solver.quasi_static": "true"}, "transient", "direct"),
    "equilibrium": ("morphing_wing", {"solver.load_steps": "2"}, "static", "direct"),
    "motion in space": ("spatial_bracket", SHORT, "transient", "none"),
    "adjoint in space": ("spatial_bracket", SHORT, "transient", "adjoint"),
    "both levels in space": ("spatial_bracket", SHORT | {"solver.formulation": "ggl"}, "transient", "none"),
}
"""Model, changed values, analysis, method for gradients."""


def probe(name: str, rehearsed: bool) -> tuple[set[str], set[str]]:
    """Functions and signatures that were there, from the disk or compiled, before the analysis and after it."""
    model, changes, kind, method = RUNS[name]
    request = json.dumps([str(MODELS / model / "scene.toml"), changes, kind, method, rehearsed])
    done = subprocess.run([sys.executable, "-c", PROBE, request], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    before, after = json.loads(done.stdout)
    return set(before), set(after)


@pytest.mark.parametrize("name", RUNS)
def test_nothing_is_left_to_compile_and_nothing_is_compiled_in_vain(name):
    before, after = probe(name, rehearsed=True)
    assert after - before == set()
    needed = probe(name, rehearsed=False)[1]
    hinge = {each for each in before if each.split()[0] == "revolute"}  # the only joint of the rehearsal, a few lines
    assert before - needed - hinge == set()


def pretend_to_compile() -> None:
    with event.trigger_event(KIND, data={}), event.trigger_event(KIND, data={}):
        pass


def test_compilation_is_announced_before_it_begins_and_counted(monkeypatch, capsys):
    said: list[str] = []

    def rehearse(*_) -> None:
        pretend_to_compile()
        said.append(capsys.readouterr().err)

    monkeypatch.setattr("toolkit.command_line.rehearsal.rehearse", rehearse)
    scene = read_scene(MODELS / "pendulum" / "scene.toml")
    compile_before(scene, "transient")
    assert said == [f"compiling the formulas for this machine, once, {announcements.EXPECTED[2]} ...\n"]
    assert capsys.readouterr().err == "2 functions compiled in 0 s; they are kept on the disk.\n"
    compile_before(scene, "transient", quiet=True)
    assert capsys.readouterr().err == ""


def test_nothing_is_said_where_nothing_is_compiled(monkeypatch, capsys):
    monkeypatch.setattr("toolkit.command_line.rehearsal.rehearse", lambda *_: None)
    compile_before(read_scene(MODELS / "pendulum" / "scene.toml"), "transient")
    assert capsys.readouterr().err == ""


def test_a_repetition_that_compiles_does_not_count(monkeypatch):
    """Five minutes of a run of two seconds."""
    durations: list[float] = []

    def work(_: object) -> str:
        if not durations:
            pretend_to_compile()
        durations.append(2.0 if durations else 302.0)
        return "done"

    monkeypatch.setattr("toolkit.sensitivity.analysis._clocked", lambda work, told: (work(told), durations[-1])[::-1])
    assert repeated(work) == (2.0, "done")
    assert durations == [302.0, 2.0]


def test_code_that_was_never_compiled_is_compiled_under_watch(tmp_path):
    """One small function in a cache of its own; the second process finds it on the disk."""
    code = (
        "from toolkit.compile_watch import watched_compilation; from toolkit.joints.joint_kernel import SIGNATURE;"
        "from toolkit.joints.revolute import revolute; w = watched_compilation().__enter__(); revolute.compile(SIGNATURE);"
        "print(w.functions, w.seconds > 0)"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", code]
    first, second = (
        subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True).stdout.split()
        for _ in range(2)
    )
    assert (first, second) == (["1", "True"], ["0", "False"])


def test_the_watch_ends_with_its_block():
    with watched_compilation() as watch:
        pretend_to_compile()
    pretend_to_compile()
    assert watch.functions == 2
