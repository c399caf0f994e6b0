"""Shell completion of both commands: what the shell is told after the first letters."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SCENE = "models/slider_crank/scene.toml"


def completed(program: str, module: str, line: str) -> list[str]:
    """What bash would offer for the last word of a line."""
    variable = f"_{program.replace('-', '_').upper()}_COMPLETE"
    words = {"COMP_WORDS": line, "COMP_CWORD": str(len(f"{line}|".split()) - 1), variable: "complete_bash"}
    code = f"import sys; sys.argv = [{program!r}]; from {module} import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, env={**os.environ, **words}, capture_output=True, text=True, check=False
    )
    return done.stdout.split()


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("ffrf stat", ["statics"]),
        ("ffrf new ", ["wing", "linkage", "solid"]),
        ("ffrf sensitivity --method c", ["complex-step", "central-difference"]),
        ("ffrf new wing --air", ["--airfoil"]),
        (f"ffrf sensitivity {SCENE} --variables k,points.M.", ["k,points.M.x", "k,points.M.y"]),
        (f"ffrf statics {SCENE} --set solver.st", ["solver.step=", "solver.start="]),
        ("ffrf statics nowhere.toml --set solver.st", []),
    ],
)
def test_commands_options_and_their_values_are_completed(line, offered):
    assert completed("ffrf", "toolkit.command_line.cli", line) == offered


def test_options_of_the_preprocessing_are_completed():
    assert completed("ffrf-preprocess", "preprocessing.commands.cli", "ffrf-preprocess --fo") == ["--force"]
