"""Options that stand for keys of a study: out of their range they are refused in words, before anything is solved."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from toolkit.command_line.cli import app

WING = Path(__file__).parents[2] / "models" / "morphing_wing"


@pytest.mark.parametrize(
    ("command", "option", "key"),
    [
        ("optimize", "--starts", "[search]: starts"),
        ("optimize", "--evaluations", "[search]: evaluations"),
        ("uncertainty", "--runs", "[uncertainty]: runs"),
        ("uncertainty", "--monte-carlo", "[uncertainty]: monte_carlo"),
        ("sweep", "--count", "[sweep]: count"),
    ],
)
def test_more_designs_than_a_study_has_are_refused_before_they_take_memory(tmp_path, command, option, key):
    shutil.copy(WING / "study.toml", tmp_path)
    points = ["--points", "sobol"] if command == "sweep" else []
    found = CliRunner().invoke(app, [command, str(tmp_path / "study.toml"), *points, option, "1000000000"])
    assert found.exit_code == 1
    assert "less than or equal to 1000000 (given: 1000000000)" in found.output
    assert key in found.output
    assert [file.name for file in tmp_path.iterdir()] == ["study.toml"]
