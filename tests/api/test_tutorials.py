"""The tutorials run from start to end in any folder, leave nothing behind, and end in the right number."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TUTORIALS = ROOT / "tutorials"
LONGEST = 115  # lines

ENDS = {
    "my_first_wing": (56.78, 0.01),  # MPa, stated with the reference scene
    "my_own_airfoil": (0.3, 0.3),  # mm: a tenth of the droop of 6 mm may be left by a linkage that was tuned for another section
    "four_bar_in_python": (0.0, 1e-9),  # rad off the law of cosines: stabilized joints at rest, so the Newton tolerance is left
    "rotating_beam": (
        0.0,
        2e-4,
    ),  # relative: the beam stretches by rho Omega^2 / (3 E) = 2e-5, its stress and rate follow with a few
    "trusting_gradients": (
        0.0,
        1e-9,
    ),  # relative difference of direct differentiation and complex step: Newton's tolerance of 1e-10
    "fewer_coordinates": (
        0.0,
        1e-6,
    ),  # relative difference of gradients to new preprocessing: round-off of modes, 1e-10, over the step, 1e-3; and h^4
    "every_gradient": (
        0.0,
        1e-7,
    ),  # relative: round-off, 1e-10, of thirty slopes that sum up to a tenth of the largest
    "large_deformation": (
        0.0,
        1e-5,
    ),  # relative difference to central differences: their truncation, (1e-6)^(2/3), and their noise
    "cheapest_setting": (0.0, 1e-3),  # relative: the budget, against an independent run
    "spatial_bracket": (
        0.0,
        1e-9,
    ),  # difference of the three exact methods, relative to the largest slope: Newton's tolerance of 1e-10
    "how_sure_is_my_stress": (0.0, 1e-2),  # error of the polynomials at random wings in parts of sigma; 1.6e-3 here
    "my_linkage_optimised": (
        0.0,
        1e-5,
    ),  # relative: what the residual of 1e-6 leaves of the limit's slack is some ten times itself
    "my_own_joint": (0.0, 1e-9),  # relative, off the closed form: constant accelerations are integrated without error
    "my_own_load": (0.0, 1e-4),  # relative: (step / delay)^2 = 2.5e-5, of second order
    "my_own_response": (0.0, 1e-5),  # relative, off school geometry: drift of the driven joint with 200 steps
}
"""The module's variable `check` at its end, and how far it may be off."""


def test_every_tutorial_has_a_known_end_and_is_short():
    found = {path.stem: path.read_text() for path in TUTORIALS.glob("*.py")}
    assert set(found) == set(ENDS)
    assert {name: len(text.splitlines()) for name, text in found.items() if len(text.splitlines()) > LONGEST} == {}
    assert [name for name, text in found.items() if "\n# %%\n" not in text or "\ncheck = " not in text] == []


RUNNER = """
import json, os, runpy, sys, tempfile, traceback
import matplotlib.figure, toolkit.analyses.transient, toolkit.command_line.announcements, toolkit.report.drawing
import preprocessing.builders.build_model

for request in sys.stdin:
    script, folder, kept = json.loads(request)
    if child := os.fork():
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
        continue
    try:
        for stream, name in ((1, "out"), (2, "err")):
            os.dup2(os.open(os.path.join(kept, name), os.O_CREAT | os.O_WRONLY), stream)
        os.chdir(folder)
        tempfile.tempdir = folder
        os.environ["TMPDIR"] = folder
        print("check", float(runpy.run_path(script)["check"]), flush=True)
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
        os._exit(1)
    os._exit(0)
"""
"""Runs scripts, each in a process of its own that has the imports behind it, in a folder, and keeps what they print in another one."""


@pytest.fixture(scope="module")
def runner():
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        [sys.executable, "-c", RUNNER], env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        yield process


@pytest.mark.robustness
@pytest.mark.parametrize("name", ENDS)
def test_a_tutorial_runs_and_ends_in_the_right_number(name, runner, tmp_path):
    before = {path for path in TUTORIALS.rglob("*") if "__pycache__" not in path.parts}
    folder = tmp_path / "folder"
    folder.mkdir()
    print(json.dumps([str(TUTORIALS / name) + ".py", str(folder), str(tmp_path)]), file=runner.stdin, flush=True)
    code, errors = int(runner.stdout.readline()), (tmp_path / "err").read_text()
    assert (code, errors) == (0, "")
    value, tolerance = ENDS[name]
    assert float((tmp_path / "out").read_text().splitlines()[-1].split()[1]) == pytest.approx(value, abs=tolerance)
    assert {path for path in TUTORIALS.rglob("*") if "__pycache__" not in path.parts} == before


def test_a_tutorial_needs_nothing_that_another_process_has_imported(tmp_path):
    """The first one, as a reader starts it."""
    command = [sys.executable, str(TUTORIALS / "my_first_wing.py")]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(tmp_path)}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
