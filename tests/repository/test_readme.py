"""The README: its Python runs, its commands exist, its files are there, its numbers are those that come out."""

import re
import subprocess
import tomllib
from pathlib import Path

import pytest
from typer.main import get_command

from toolkit.analyses.sensitivity.direct import direct
from toolkit.command_line.cli import app
from toolkit.files.scene_reader import read_scene

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
ABILITIES, COMMANDS, PACKAGES = (
    (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8") for name in ("abilities", "commands", "packages")
)


@pytest.mark.parametrize("text", [TEXT, COMMANDS], ids=["README", "commands"])
def test_the_python_example_runs(text, monkeypatch, capsys):
    (example,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    monkeypatch.chdir(ROOT)
    exec(compile(example, "README.md", "exec"), {})
    assert "max_stress" in capsys.readouterr().out


def test_every_file_named_exists():
    names = re.findall(r"(?:models|docs|toolkit|preprocessing|tests|tutorials|schemas)/[\w./-]*", TEXT + COMMANDS + PACKAGES)
    assert names
    assert [name for name in names if not (ROOT / name.rstrip(".")).exists()] == []


def test_every_command_and_option_named_exists():
    commands = get_command(app).commands
    lines = [line.split("#")[0].split() for line in re.findall(r"^ffrf .*$", TEXT + COMMANDS, re.MULTILINE)]
    assert lines
    for _, command, *words in lines:
        found = commands[command]
        found = getattr(found, "commands", {}).get(words[0], found)  # `ffrf new wing` lies one level deeper
        options = {option for parameter in found.params for option in parameter.opts}
        assert {word for word in words if word.startswith("--")} <= options


def test_every_make_target_named_exists():
    for target in re.findall(r"^make (\w+)", TEXT, re.MULTILINE):
        subprocess.run(["make", "--dry-run", target], cwd=ROOT, check=True, capture_output=True)


def test_the_picture_is_small_enough_to_commit():
    assert (ROOT / "docs" / "morphing_wing.png").stat().st_size < 300_000


def test_the_table_of_dependencies_is_that_of_the_project():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    table = PACKAGES
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines() if line.startswith("| ")][1:]
    listed = {(package, extra) for row in rows for package in row[0].split(", ") for extra in row[3].split(", ")}
    declared = {(re.split(r"[><=]", item)[0], "") for item in project["dependencies"]}
    for extra, items in project["optional-dependencies"].items():
        declared |= {(re.split(r"[><=]", item)[0], extra) for item in items if not item.startswith("ffrf-toolkit[")}
    assert listed == declared


def numbers(row: str) -> list[float]:
    """Numbers in a row of a table, after its first cell."""
    (line,) = [line for line in ABILITIES.splitlines() if line.startswith(f"| {row} |")]
    return [float(cell) for cell in line.split("|")[2:-1] if cell.strip()]


@pytest.mark.parametrize(
    ("row", "response"),
    [
        ("smooth (KS) maximum", "max_stress"),
        ("largest stress", "max_stress_true"),
        ("RMS distance", "shape_rmse"),
        ("largest distance", "shape_max_error"),
        ("rotation", "drive_angle"),
    ],
)
def test_the_printed_gradients_are_those_that_come_out(row, response):
    scene = read_scene(ROOT / "models" / "morphing_wing" / "scene.toml")
    slopes = direct(scene, list(scene.design), "transient").gradients[response]
    assert numbers(row) == pytest.approx(list(slopes.values()), rel=1e-5)  # six digits are printed
