"""What all tests share: their order in a long run, in which the plane and space are compiled once, each by a process of its own; and how
files of other programs are read, and programs of the preprocessing run."""

from __future__ import annotations

import gc
import runpy
import subprocess
import sys
import warnings
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import BytesIO, StringIO
from math import inf
from pathlib import Path
from types import SimpleNamespace

import pytest

from preprocessing.foreign_files import apart
from preprocessing.foreign_files.apart import ReaderEnded
from preprocessing.foreign_files.child import reading
from preprocessing.foreign_files.wire import send
from toolkit.command_line.rehearsal import rehearse
from toolkit.files.scene_reader import read_scene
from toolkit.foundation import processes
from toolkit.scene.scene import Scene

MODELS = Path(__file__).parents[1] / "models"
PLANE, SPACE = "four_bar_chain", "spatial_bracket"
SHARES = {"gw0": PLANE, "gw1": SPACE}
"""Worker of pytest-xdist -> the model whose dimension it compiles before its first test."""
SELDOM = 20_000, 20, 20
"""Thresholds of the search for garbage, which nearly nothing here leaves, instead of Python's 700, 10, 10: a fiftieth of the time."""
LONG = 1000
"""Number of tests from which on it pays: a few tests compile what they need."""

FAST = {
    "analyses/test_statics_modes.py",
    "command_line/test_study_options.py",
    "compilation/test_joint_pattern.py",
    "cost_summary/test_cost_summary.py",
    "curves/test_curves.py",
    "equations/test_balances.py",
    "extremes/test_steps.py",
    "foreign_decks/test_keyword_lines.py",
    "foreign_meshes/test_vtk.py",
    "foundation/test_vectors.py",
    "frames/test_cut_wing.py",
    "fuzz/test_hostile_cases.py",
    "joints/test_gears.py",
    "linear/test_sparse_lu.py",
    "loads/test_controllers.py",
    "preprocessing/test_beam.py",
    "reduced_model/test_composition.py",
    "render/test_wheels.py",
    "responses/test_physics.py",
    "results/test_results.py",
    "scene/test_scene.py",
    "scene_file/test_schemas.py",
    "scenes/test_benchmarks.py",
    "sensitivity/test_every_number.py",
    "solvers/test_start_velocities.py",
    "spinning/test_closed_forms.py",
    "studies/test_engine.py",
    "validity/test_snapping_motions.py",
}
"""One file of a room whose tests answer in seconds; those in space are left out, whose formulas take a minute to compile."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what is fast, and sort: tests in space come last, when their formulas are compiled.

    `make test` gives a file to one worker, for what its tests share. Long files come first: so both workers end at about the same time.
    """
    for item in items:
        if "/".join(item.path.parts[-2:]) in FAST and "space" not in item.nodeid and "spatial" not in item.nodeid:
            item.add_marker("fast")
    size = {path: path.stat().st_size for path in {item.path for item in items}}
    items.sort(key=lambda item: -size[item.path] if "spatial" in item.nodeid or "space" in item.nodeid else -inf)


def pytest_collection_finish(session: pytest.Session) -> None:
    """Compile this worker's share before the first test of a long run; what is there now stays, and is not looked through for garbage."""
    gc.freeze()
    gc.set_threshold(*SELDOM)
    share = SHARES.get(getattr(session.config, "workerinput", {}).get("workerid"))
    if share and len(session.items) >= LONG:
        for scene in formulations(share):
            rehearse(scene, "static", backwards=True)
            rehearse(scene, "transient", backwards=True)


def formulations(model: str) -> list[Scene]:
    """The scene with one level of equations and with both."""
    path = MODELS / model / "scene.toml"
    return [read_scene(path, {"solver.formulation": formulation}) for formulation in ("index-1", "ggl")]


@pytest.fixture
def read_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Files of other programs are read without a process for each, where nothing of that process is tested."""
    monkeypatch.setattr(apart, "run", _read)


@pytest.fixture(scope="module")
def all_read_here() -> Iterator[None]:
    """The same for what the tests of a file share."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(apart, "run", _read)
        yield


@pytest.fixture
def programs_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Programs of the preprocessing run here, which saves their imports, where nothing of their process is tested."""
    monkeypatch.setattr(processes, "program", lambda *words: list(words))
    monkeypatch.setattr(processes, "subprocess", SimpleNamespace(run=_run))


def _run(command: list[str], *, input: str | None, **_options: object) -> subprocess.CompletedProcess[str]:
    output, errors, code = StringIO(), StringIO(), 0
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(output), redirect_stderr(errors), warnings.catch_warnings():
        patch.setattr(sys, "argv", command)
        patch.setattr(sys, "stdin", StringIO(input))
        warnings.filterwarnings("ignore", ".*found in sys.modules", RuntimeWarning)  # a program that is imported already
        try:
            runpy.run_module(command[0], run_name="__main__")
        except SystemExit as end:
            code = end.code
    return subprocess.CompletedProcess(command, code or 0, output.getvalue(), errors.getvalue())


def _read(reader: str, path: Path, _bounds: object, *more: str) -> ReaderEnded:
    output = BytesIO()
    send(output, reading(reader, str(path), *more))
    return ReaderEnded(0, output)
