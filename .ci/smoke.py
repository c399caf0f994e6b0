"""Whether the program works with the packages of an environment: every one of them is called, in half a minute and without pytest.

The formulas run as plain Python, since compiling them takes minutes; what is used of numba is tried on a formula of its own.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

MODELS = Path(__file__).resolve().parents[1] / "models"
BIN = Path(sys.executable).parent
KERNEL = """
import numpy as np
from numba import types
from toolkit.kernel import call, inner, inlined, is_on_disk, kernel, plain, slots

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
def by(functions, x):
    functions[0](x)

x = np.zeros(3)
call(by, slots([filled], types.void(types.float64[::1])), x)
assert (x == 2.0).all(), x
assert plain(quarter)(8j) == 2j
assert is_on_disk(by) and is_on_disk(filled)
print(sum(filled.stats.cache_hits.values()))
"""


def run(*command: str, **environment: str) -> str:
    """Standard output of a command that must succeed, without a warning."""
    done = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, check=False)
    if done.returncode or "Warning" in done.stderr or "Traceback" in done.stderr:
        raise SystemExit(f"{' '.join(command)}\n{done.stdout}\n{done.stderr}\nfailed with exit code {done.returncode}")
    return done.stdout


def ffrf(*arguments: str) -> str:
    """A command of the runtime, without compiled code."""
    return run(str(BIN / "ffrf"), *arguments, NUMBA_DISABLE_JIT="1")


def refused(*arguments: str) -> str:
    """What a command says that must fail."""
    done = subprocess.run([str(BIN / "ffrf"), *arguments], capture_output=True, text=True, check=False)
    assert done.returncode, arguments
    assert "Traceback" not in done.stderr, done.stderr
    return done.stderr


def compiled_formulas(folder: Path) -> None:
    """What the program uses of numba, also its private parts: code is compiled, kept, and found again."""
    (folder / "formula.py").write_text(KERNEL)
    assert run(sys.executable, str(folder / "formula.py")) == "0\n"
    assert run(sys.executable, str(folder / "formula.py")) == "1\n"


def commands(folder: Path) -> None:
    """The way from an airfoil and a mesh to pictures."""
    assert "simulate" in ffrf("--help")
    assert "--overwrite" in run(str(BIN / "ffrf-preprocess"), "--help")
    wing, kept, pendulum = folder / "wing", str(folder / "kept.h5"), str(MODELS / "pendulum" / "scene.toml")
    ffrf("new", "wing", str(wing), "--airfoil", str(MODELS / "morphing_wing" / "high_speed.dat"))
    run(str(BIN / "ffrf-preprocess"), str(wing / "skin.toml"))
    run(str(BIN / "ffrf-preprocess"), str(MODELS / "bracket" / "body.toml"), "--output", str(folder / "bracket.h5"))
    assert json.loads(ffrf("inspect", str(wing / "skin.h5"), "--json"))["sizes"]["elastic coordinates"] == 90
    assert "units" in ffrf("inspect", str(wing / "scene.toml"), "--no-measure")
    ffrf("sensitivity", pendulum, "--set", "solver.end_time=0.05", "--set", "solver.step=0.01", "--output", kept, "--quiet")
    ffrf("export", kept, "--csv", str(folder / "tables"), "--paraview", str(folder / "series"))
    assert (folder / "series" / "results.pvd").is_file()
    ffrf("report", kept, "--output", str(folder / "report"), "--quiet")
    assert (folder / "report" / "report.html").stat().st_size > 100_000
    assert "cannot be read" in refused("statics", "nowhere.toml")
    assert "--set" in refused("simulate", pendulum, "--set", "nothing")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        compiled_formulas(Path(place))
        commands(Path(place))
    print("the program works with the packages of this environment")
