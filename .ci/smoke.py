"""Whether the program works with the packages of an environment: every one of them is called, in half a minute and without pytest.

The formulas run as plain Python, since compiling them takes minutes; what is used of numba is tried on formulas of its own.
"""

from __future__ import annotations

import json
import os
import runpy
import subprocess
import sys
import tempfile
from pathlib import Path

import ffrf

OF_THE_PROJECT = Path(ffrf.__file__).parents[1] / "models"
MODELS = OF_THE_PROJECT if OF_THE_PROJECT.is_dir() else Path(sys.prefix) / "share" / "ffrf-toolkit" / "models"
"""Those beside the code, or those that a wheel has installed."""
FORMULAS = """
from typing import NamedTuple
import numpy as np
from numba import types
from toolkit.foundation.compiled.calls import call
from toolkit.foundation.kernel import inlined, inner, kernel, plain, slots

class Record(NamedTuple):
    added: np.ndarray
    times: int

@inner
def half(x):
    return x / 2

@inlined
def quarter(x):
    return half(half(x))

@kernel
def filled(x):
    for i in range(len(x)):
        x[i] = quarter(8.0)

@kernel
def by(functions, record, x):
    functions[0](x)
    for i in range(len(x)):
        x[i] += record.times * record.added[i]

x = np.zeros(3)
call(by, slots([filled], types.void(types.float64[::1])), Record(np.ones(3), 2), x)
assert (x == 4.0).all(), x
assert plain(quarter)(8j) == 2j
hits = sum(filled.stats.cache_hits.values())
"""


def start(*command: str, **environment: str) -> None:
    """Run a process that must succeed."""
    done = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, check=False)
    sys.stdout.write(done.stdout if command[0] == sys.executable else "")
    if done.returncode:
        raise SystemExit(f"{' '.join(command)}\n{done.stdout}\n{done.stderr}\nfailed with exit code {done.returncode}")


def run(command: str, *arguments: object, code: int = 0) -> str:
    """Standard output of a command in this process, its standard error if it must fail."""
    from typer.testing import CliRunner

    from preprocessing.commands.cli import app as preprocess
    from toolkit.command_line.cli import app

    done = CliRunner().invoke(preprocess if command == "ffrf-preprocess" else app, list(map(str, arguments)))
    if done.exit_code != code or "Warning" in done.stderr or not isinstance(done.exception, SystemExit | None):
        raise SystemExit(f"{command} {' '.join(map(str, arguments))}\n{done.output}\n{done.stderr}\n{done.exception!r}")
    return done.stderr if code else done.stdout


def formulas(folder: Path) -> None:
    """What the program uses of numba, also its private parts: code is compiled, kept, and found again."""
    (folder / "formulas.py").write_text(FORMULAS)
    assert [runpy.run_path(str(folder / "formulas.py"))["hits"] for _ in range(2)] == [0, 1]


def draw(results: Path, folder: Path) -> None:
    """Planar pictures of every format; pyvista is called by `ffrf export`."""
    for kind in ("png", "svg", "pdf"):
        run("ffrf", "render", results, "--output", folder, "--format", kind)
        assert len(list(folder.glob(f"*.{kind}"))) > 2


def commands(folder: Path) -> None:
    """The way from an airfoil and a mesh to tables and figures."""
    wing, kept, pendulum = folder / "wing", folder / "kept.h5", MODELS / "pendulum" / "scene.toml"
    assert "--overwrite" in run("ffrf-preprocess", "--help")
    run("ffrf", "new", "wing", wing, "--airfoil", MODELS / "morphing_wing" / "high_speed.dat")
    run("ffrf-preprocess", wing / "skin.toml")
    run("ffrf-preprocess", MODELS / "bracket" / "body.toml", "--output", folder / "bracket.h5")
    assert json.loads(run("ffrf", "inspect", wing / "skin.h5", "--json"))["sizes"]["elastic coordinates"] == 90
    assert "skin: flexible" in run("ffrf", "inspect", wing / "scene.toml", "--no-measure")
    run(
        "ffrf", "sensitivity", pendulum, "--set", "solver.end_time=0.05", "--set", "solver.step=0.01", "--output", kept, "--quiet"
    )
    run("ffrf", "export", kept, "--csv", folder / "tables", "--paraview", folder / "series")
    assert (folder / "series" / "results.pvd").is_file()
    run("ffrf", "report", kept, "--output", folder / "report", "--quiet")
    assert (folder / "report" / "report.html").stat().st_size > 100_000
    draw(kept, folder / "pictures")
    run("ffrf", "new", "linkage", folder / "linkage")
    assert "hold" in json.loads(run("ffrf", "statics", folder / "linkage" / "scene.toml", "--json", "--quiet"))["responses"]
    mesh = MODELS / "bracket" / "bracket.msh"
    run("ffrf", "new", "solid", folder / "solid", "--mesh", mesh, "--clamp", "crank", "--grip", "pin")
    assert json.loads(run("ffrf-preprocess", folder / "solid" / "body.toml", "--json"))["stress_error"]["cases"]
    assert "cannot be read" in run("ffrf", "statics", "nowhere.toml", code=1)
    assert "--set" in run("ffrf", "simulate", pendulum, "--set", "nothing", code=2)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        if sys.argv[1:]:
            {"formulas": formulas, "commands": commands}[sys.argv[1]](Path(place))
        else:
            start(str(Path(sys.executable).parent / "ffrf"), "--help")
            start(sys.executable, "-P", __file__, "formulas")
            start(sys.executable, "-P", __file__, "commands", NUMBA_DISABLE_JIT="1")
            print("the program works with the packages of this environment")
