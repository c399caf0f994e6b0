"""Sweeps: designs against closed forms, failures as rows, tables, and invalid input."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest
from pyarrow import parquet
from typer.testing import CliRunner

import ffrf
from tests.models.studies import LEFT, LOAD, SWEEP, sweep_file
from tests.models.truss import force_slope, height, limit_load
from toolkit.command_line.cli import app
from toolkit.foundation.errors import InputError
from toolkit.studies.design_work import NoDesignError
from toolkit.studies.store import StudyFileError
from toolkit.studies.study_file import read_study
from toolkit.studies.sweep import points_of, sweep_problem

TWO = SWEEP.replace("[sweep]", f'"{LEFT}" = {{ between = [900.0, 1100.0] }}\n[sweep]')


def points(folder, text):
    return points_of(sweep_problem(read_study(sweep_file(folder, text))))


def test_a_grid_has_the_values_and_slopes_of_the_closed_form_and_failures_are_rows_with_reasons(tmp_path):
    found = ffrf.sweep(sweep_file(tmp_path))
    loads = -found.designs[:, 0]
    assert loads == pytest.approx(np.linspace(90.0, 10.0, 9))
    good = loads < limit_load()
    assert [not each.failed for each in found.solved] == good.tolist()
    exact = np.array([height(load) for load in loads[good]])
    assert found.values("rise")[good] == pytest.approx(exact - 0.5, rel=1e-9)
    assert found.gradients("rise")[good, 0] == pytest.approx([-1 / force_slope(y) for y in exact], rel=1e-8)
    assert np.all(np.isnan(found.values("rise")[~good]))
    assert all("limit point" in each.reason for each in found.solved if each.failed)
    assert found.failed == 5
    assert "failed-designs" in found.verdict.codes


def test_points_fill_the_bounds_as_their_names_say(tmp_path):
    scattered = points(tmp_path, TWO.replace("levels = 9", 'points = "latin-hypercube"\ncount = 20\nseed = 3'))
    low, high = np.array([-90.0, 900.0]), np.array([-10.0, 1100.0])
    strata = np.floor(20 * (scattered - low) / (high - low)).astype(int)
    assert [sorted(column) for column in strata.T] == [list(range(20))] * 2
    few, many = (points(tmp_path, TWO.replace("levels = 9", f'points = "sobol"\ncount = {n}')) for n in (5, 32))
    assert np.array_equal(few, many[:5])
    assert len(many) == 32
    halves = (many - low) / (high - low) < 0.5
    assert halves.sum(axis=0).tolist() == [16, 16]  # 2^k points of the sequence are balanced
    grid = points(tmp_path, TWO.replace("levels = 9", f'levels = {{ "{LOAD}" = 3, "{LEFT}" = 1 }}'))
    assert grid.tolist() == [[-90.0, 1000.0], [-50.0, 1000.0], [-10.0, 1000.0]]


def test_the_designs_of_a_table_come_in_its_order_and_equal_ones_are_solved_once(tmp_path):
    (tmp_path / "designs.csv").write_text(f"{LEFT},{LOAD}\n1000.0,-20.0\n950.0,-30.0\n\n1000,-20\n")
    found = ffrf.sweep(sweep_file(tmp_path, TWO.replace("levels = 9", 'file = "designs.csv"')), output=tmp_path / "kept")
    assert found.designs.tolist() == [[-20.0, 1000.0], [-30.0, 950.0], [-20.0, 1000.0]]
    assert found.solved[0] is found.solved[2]
    assert found.values("rise")[0] == pytest.approx(height(20.0) - 0.5, rel=1e-9)


def test_command_tables_and_python_say_the_same(tmp_path):
    path, folder = sweep_file(tmp_path), tmp_path / "out"
    run = CliRunner().invoke(app, ["sweep", str(path), "--levels", "5", "--json", "--quiet", "-o", str(folder)])
    assert run.exit_code == 0, run.output
    record = json.loads(run.stdout)
    path.write_text(SWEEP.replace("levels = 9", "levels = 5"))
    found = ffrf.sweep(path)
    assert (record["evaluations"], record["failed"]) == (5, found.failed)
    assert record["sweep"]["responses"]["rise"]["least"]["value"] == np.nanmin(found.values("rise"))
    assert record["failures"][0]["reason"] == found.solved[0].reason
    assert record["verdict"]["trusted"] == found.verdict.trusted
    with (folder / "sweep.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    table = parquet.read_table(folder / "sweep.parquet").to_pydict()
    assert list(rows[0]) == list(table) == list(found.columns)
    slope = f"d(rise)/d({LOAD})"
    for k, row in enumerate(rows):
        assert (row["failure"], float(row[LOAD])) == (found.solved[k].reason, found.designs[k, 0])
        assert row[slope] == ("" if found.solved[k].failed else repr(float(found.gradients("rise")[k, 0])))
        assert table["rise"][k] == (None if found.solved[k].failed else found.values("rise")[k])
    assert (folder / "sweep.png").is_file()
    told = CliRunner().invoke(app, ["sweep", str(path), "--levels", "5", "-o", str(folder)])
    assert "failed-designs" in [each["code"] for each in record["warnings"]]
    assert found.verdict.warnings[0].text in told.stdout


def test_a_wrong_option_is_said_as_it_was_typed(tmp_path):
    run = CliRunner().invoke(app, ["sweep", str(sweep_file(tmp_path)), "--points", "nonsense", "-o", str(tmp_path / "out")])
    assert run.exit_code == 1
    assert "points: input should be 'grid', 'latin-hypercube' or 'sobol' (given: 'nonsense')" in run.stderr


@pytest.mark.parametrize(
    "text", [TWO, TWO.replace("[sweep]", '"loads.right.stiffness" = { between = [900.0, 1100.0] }\n[sweep]')]
)
def test_sweeps_of_several_variables_are_drawn_with_their_failures(tmp_path, text):
    path = sweep_file(tmp_path, text.replace("levels = 9", 'levels = 3\nresponses = ["rise"]'))
    run = CliRunner().invoke(app, ["sweep", str(path), "--quiet", "-o", str(tmp_path / "out")])
    assert run.exit_code == 0, run.output
    assert (tmp_path / "out" / "sweep.png").stat().st_size > 10_000


MOVED = SWEEP.replace("[sweep]", f'moved = {{ between = [-100.0, 100.0], of = ["{LEFT}"] }}\n[sweep]')
WRONG = {
    "no variables": (SWEEP.replace(f'"{LOAD}" = {{ between = [-90.0, -10.0] }}', ""), "variables is empty"),
    "unknown variable": (SWEEP.replace("push.force", "pull.force"), "unknown design variable 'loads.pull.force.y'"),
    "empty bounds": (SWEEP.replace("[-90.0, -10.0]", "[-10.0, -90.0]"), "holds nothing"),
    "count of a grid": (SWEEP + "count = 3", "a grid has `levels`, no `count` or `seed`"),
    "levels of scattered points": (SWEEP + 'points = "sobol"', "has a `count`, no `levels`"),
    "file and levels": (SWEEP + 'file = "designs.csv"', "the designs of a file need no levels"),
    "unknown kind": (SWEEP + 'points = "random"', "points"),
    "levels of nothing": (SWEEP.replace("levels = 9", "levels = { x = 3 }"), "sweep.levels: 'x' is no variable of the study"),
    "too many": (SWEEP.replace("levels = 9", "levels = 1000001"), "1000001 designs are more than 1000000"),
    "unknown response": (SWEEP + 'responses = ["fall"]', "sweep.responses: no response 'fall'"),
    "margin without limit": (SWEEP + 'responses = ["load_margin"]', "load_margin needs to know how far to look"),
    "missing file": (SWEEP.replace("levels = 9", 'file = "no.csv"'), "no.csv' cannot be read (No such file"),
    "variable like a response": (
        MOVED.replace("moved", "rise"),
        "variables.rise: 'rise' is the column of a sweep's table that holds the",
    ),
    "variable like the number": (MOVED.replace("moved", "design"), "that holds the number of the design"),
    "variable like the reason": (MOVED.replace("moved", "failure"), "that holds why a design failed"),
    "variable like a derivative": (MOVED.replace("moved", f"'d(sway)/d({LOAD})'"), "that holds a derivative"),
    "variable like a case": (
        MOVED.replace("moved", '"a.rise"') + '[cases.a]\n"loads.right.stiffness" = 990.0',
        "that holds the response 'rise'",
    ),
    "response like the reason": (
        SWEEP + '[responses]\nfailure = { type = "displacement", body = "tip", point = "P", component = "y" }',
        "responses.failure: 'failure' is the column of a sweep's table that holds why a design failed",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_sweeps_are_refused_in_clear_words(tmp_path, name):
    text, words = WRONG[name]
    with pytest.raises(InputError) as error:
        points(tmp_path, text)
    assert words in str(error.value)


TABLES = {
    "": "names nothing",
    "load\n-20\n": "names load; it has to name each variable of the study once",
    f"{LOAD}\n": "holds no designs below its first line",
    f"{LOAD}\n-20\nmany\n": "designs.csv, line 3: loads.push.force.y = 'many' is no number",
    f"{LOAD}\n-20,3\n": "designs.csv, line 2: 2 cells, where the first line has 1",
    f"{LOAD}\n-200\n": "is not between -90 and -10",
    f"{LOAD}\nnan\n": "is not between -90 and -10",
}


@pytest.mark.parametrize("table", TABLES)
def test_wrong_tables_are_refused_with_their_line(tmp_path, table):
    (tmp_path / "designs.csv").write_text(table)
    with pytest.raises(InputError) as error:
        points(tmp_path, SWEEP.replace("levels = 9", 'file = "designs.csv"'))
    assert TABLES[table] in str(error.value)


def test_a_sweep_of_which_no_design_can_be_solved_says_why(tmp_path):
    path = sweep_file(tmp_path, SWEEP.replace("-10.0", "-80.0").replace("levels = 9", "levels = 3"))
    with pytest.raises(NoDesignError, match=r"not one of 3 designs could be solved(.|\n)*1 times: the static path ends at"):
        ffrf.sweep(path)
    run = CliRunner().invoke(app, ["sweep", str(path), "--quiet", "-o", str(tmp_path / "out")])
    assert run.exit_code == 1


def test_contradictory_options_of_the_command_are_refused_in_words(tmp_path):
    run = CliRunner().invoke(app, ["sweep", str(sweep_file(tmp_path)), "--count", "5", "--quiet", "-o", str(tmp_path / "out")])
    assert run.exit_code == 1
    assert "a grid has `levels`, no `count` or `seed`" in run.stderr


def test_more_levels_find_what_is_kept_and_another_study_is_left_as_it_is(tmp_path):
    path, folder, counts = sweep_file(tmp_path), tmp_path / "kept", []
    ffrf.sweep(path, output=folder)
    path.write_text(SWEEP.replace("levels = 9", "levels = 17"))
    ffrf.sweep(path, output=folder, progress=lambda done, total: counts.append((done, total)))
    assert counts[0] == (9, 17)  # every other one of 17 is kept
    path.write_text(SWEEP.replace("[sweep]", "[constraints]\nload_margin = { above = 1.2 }\n[sweep]"))
    before = (folder / "sweep.h5").read_bytes()
    with pytest.raises(StudyFileError, match="belongs to another study"):
        ffrf.sweep(path, output=folder)
    assert (folder / "sweep.h5").read_bytes() == before


CASES = """
[cases.stiff]
"loads.right.stiffness" = 1200.0
[cases.soft]
"loads.right.stiffness" = 1000.0
"""


@pytest.mark.parametrize("exchanged", ["cases", "variables"])
def test_what_is_kept_of_a_study_whose_tables_stand_in_another_order_is_not_taken_for_this_one(tmp_path, exchanged):
    """Arrays are kept by the places of cases and variables; both springs have the same bounds, so that designs are equal to the bit."""
    left, right = (f'"loads.{side}.stiffness" = {{ between = [900.0, 1100.0] }}\n' for side in ("left", "right"))
    one, other = CASES.split("[cases.soft]")
    text = {
        "cases": (SWEEP + CASES, SWEEP + "[cases.soft]" + other + one),
        "variables": tuple(
            f'scene = "scene.toml"\n[variables]\n{springs}[sweep]\nlevels = 2\n' for springs in (left + right, right + left)
        ),
    }[exchanged]
    folder = tmp_path / "kept"
    ffrf.sweep(sweep_file(tmp_path, text[0].replace("levels = 9", "levels = 2")), output=folder)
    with pytest.raises(StudyFileError, match="belongs to another study"):
        ffrf.sweep(sweep_file(tmp_path, text[1].replace("levels = 9", "levels = 2")), output=folder)


def test_load_margins_that_are_cut_off_are_said(tmp_path):
    text = SWEEP.replace("[-90.0, -10.0]", "[-40.0, -10.0]").replace("levels = 9", 'levels = 3\nresponses = ["load_margin"]')
    found = ffrf.sweep(sweep_file(tmp_path, text + "[constraints]\nload_margin = { above = 1.05 }\n"))
    margins = limit_load() / -found.designs[:, 0]
    assert found.values("load_margin") == pytest.approx(np.minimum(margins, 2.1), rel=1e-8)
    (said,) = [each for each in found.verdict.warnings if each.code == "margin-cut-off"]
    assert said.text.startswith(f"in {np.sum(margins > 2.1)} of 3 designs no limit point up to 2.1: load_margin is at least that")
    assert not said.doubt
