"""Campbell's diagram of a blade against published frequencies of a rotating beam, its order in the number of bodies, and its files."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from tests.spinning.scenes import UNIT, blade, planar_blade, table
from toolkit.analyses.modes import Campbell, campbell
from toolkit.api.model import compile_model
from toolkit.command_line.cli import app
from toolkit.command_line.commands.campbell_command import speeds_of
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ConvergenceError, InputError, SingularSystemError

MODEL = Path(__file__).parents[2] / "models" / "spinning_beam" / "scene.toml"
FLAP = {0: 3.5160, 1: 3.6817, 2: 4.1373, 3: 4.7973, 4: 5.5850, 5: 6.4495, 6: 7.3604, 8: 9.2568, 10: 11.2023}
"""Wright, Smith, Thresher and Wang, J. Applied Mechanics 49 (1982): lowest frequency across the plane of the spin of a clamped uniform
beam by the speed, both in parts of sqrt(E I / rho A) / L^2; in this plane its square is less by that of the speed."""


def diagram(scene, speeds: list[float], count: int) -> Campbell:
    return compile_model(scene).campbell([UNIT * each for each in speeds], count=count)


def lowest(found: Campbell) -> np.ndarray:
    """In units of the beam."""
    return 2 * np.pi * found.frequencies / UNIT


def test_a_blade_of_many_bodies_has_the_published_frequencies(tmp_path):
    """Of second order in the number of bodies, so that two of them extrapolate to four digits, in both planes."""
    speeds = list(map(float, FLAP))
    coarse, middle, fine = (lowest(diagram(blade(tmp_path, parts, 1.0), speeds, 2)) for parts in (4, 8, 16))
    flap, lag = np.array(list(FLAP.values())), np.sqrt(np.array(list(FLAP.values())) ** 2 - np.array(speeds) ** 2)
    fast = np.array(speeds) >= 2
    for number, published in ((1, flap), (0, lag)):
        order = np.log2((published - middle[:, number])[fast] / (published - fine[:, number])[fast])
        assert order == pytest.approx(2.0, abs=0.2)
        limit = fine[:, number] + (fine[:, number] - middle[:, number]) / 3
        # h^4 of 8 bodies at the highest speed, in the squares of both frequencies, of which that in the plane is the smaller
        assert np.abs(limit / published - 1).max() < 1e-3 * ((flap / lag).max() ** 2 if number == 0 else 1)
    assert (np.abs(coarse[:, 1] - flap) >= np.abs(middle[:, 1] - flap))[fast].all()
    slow = np.array(speeds) <= 2
    assert fine[slow, 1] == pytest.approx(flap[slow], rel=1.2e-3)


def test_the_meter_of_missing_stiffening_tells_what_is_missing(tmp_path):
    """Across the plane of the spin to a factor of two or so, and in that plane more is missing, as it says."""
    for parts, speed in ((2, 2.0), (4, 4.0), (8, 8.0)):
        found = diagram(blade(tmp_path, parts, 1.0), [speed], 2)
        (caution,) = (each for each in found.verdict.warnings if each.code == "missing-stiffening")
        told = float(caution.text.split("by about ")[1].split("%")[0]) / 100
        flap = FLAP[int(speed)]
        lag = np.sqrt(flap**2 - speed**2)
        lag_found, flap_found = lowest(found)[0]
        missed = 1 - flap_found / flap
        assert told / 2.5 < missed < 2 * told
        assert 1 - lag_found / lag > missed
        assert caution.doubt == (told > 0.025)


def test_a_single_linear_body_beyond_its_critical_speed_is_not_trusted(tmp_path):
    found = diagram(blade(tmp_path, 1, 1.0), [1.0, 5.0], 2)
    assert not found.verdict.trusted
    assert {"critical-speed", "missing-stiffening", "unstable"} <= set(found.verdict.codes)


def test_in_the_plane_it_is_what_it_is_in_space(tmp_path):
    """The frequencies in the plane of the spin; the beams' axial and lateral elements are the same."""
    speeds = [1.0, 4.0, 8.0]
    plane = lowest(diagram(planar_blade(tmp_path, 6, 1.0), speeds, 1))
    space = lowest(diagram(blade(tmp_path, 6, 1.0), speeds, 1))
    assert plane[:, 0] == pytest.approx(space[:, 0], rel=1e-4)  # rotary inertia of the sections, (1.9 d / 4)^2 and less


def test_speeds_of_a_table_and_what_cannot_be_found_is_named():
    """Frequencies of the closed form at every speed; beyond the last the block runs away."""
    scene = table(1.0, 50.0, 2.0, damping=0.0)
    found = compile_model(scene).campbell([0.0, 1.0, 2.0, 4.9], count=1)
    assert found.frequencies[:, 0] == pytest.approx(np.sqrt(25 - found.speeds**2) / (2 * np.pi), rel=1e-9)
    assert found.damping[:, 0] == pytest.approx(0.0, abs=1e-9)
    assert repr(found) == "<Campbell: 1 frequencies at 4 speeds from 0 to 4.9 rad per unit of time>"
    with pytest.raises((ConvergenceError, SingularSystemError), match="at 5 rad per unit of time"):
        compile_model(scene).campbell([5.0])


def test_modes_of_the_door_are_those_of_the_diagram_at_the_speed_of_the_motor():
    scene = read_scene(MODEL)
    model = compile_model(scene.model_copy(update={"solver": scene.solver.model_copy(update={"equilibrium": "rest"})}))
    found = model.modes({"speed": 40.0}, count=2, spinning=True)
    assert found.frequencies == pytest.approx(model.campbell([40.0], count=2).frequencies[0], rel=1e-10)
    assert found.damping is not None
    with pytest.raises(InputError, match="about the given positions or about a steady spin"):
        model.modes(undeformed=True, spinning=True)


def test_the_command_prints_a_table_and_writes_files(tmp_path):
    command = ["campbell", str(MODEL), "--speeds", "0:60:3", "--count", "2", "--quiet"]
    words = CliRunner().invoke(app, [*command, "--output", str(tmp_path)])
    assert words.exit_code == 0, words.output
    assert "speed in rad/s" in words.stdout
    assert "Frequencies are those that the frame sees which spins with the scene" in words.stdout
    record = json.loads(CliRunner().invoke(app, [*command, "--json"]).stdout)
    assert record["speeds"] == {"value": [0.0, 30.0, 60.0], "unit": "rad/s"}
    assert json.loads((tmp_path / "campbell.json").read_text()) == record
    rows = list(csv.reader((tmp_path / "campbell.csv").read_text().splitlines()))
    assert rows[0][:3] == ["speed in rad/s", "frequency 1 in Hz", "frequency 2 in Hz"]
    assert np.array(rows[1:], float)[:, 1:3] == pytest.approx(np.array(record["frequencies"]["value"]), rel=1e-12)
    files = {each.name for each in tmp_path.iterdir() if not each.name.startswith(".")}
    assert files == {f"campbell.{kind}" for kind in ("png", "svg", "csv", "json")}


@pytest.mark.parametrize("speeds", ["fast", "0:1", "0:10:1", "1,,2"])
def test_speeds_that_are_no_numbers(speeds):
    found = CliRunner().invoke(app, ["campbell", str(MODEL), "--speeds", speeds])
    assert found.exit_code == 2
    assert "names no speeds" in found.output


@pytest.mark.parametrize("count", [10_001, 10**9, 10**30])
def test_more_speeds_than_a_diagram_has_are_refused_before_they_take_memory(count):
    with pytest.raises(InputError, match="are more than the 10000 of one diagram"):
        speeds_of(f"0:1:{count}")
    if count < sys.maxsize:
        with pytest.raises(InputError, match="are more than the 10000 of one diagram"):
            campbell(None, range(count))


def test_the_command_for_modes_spins_too():
    found = CliRunner().invoke(app, ["modes", str(MODEL), "--spinning", "--count", "2", "--json", "--quiet"])
    record = json.loads(found.stdout)
    assert record["frequencies"]["unit"] == "Hz"
    assert record["damping_ratios"] == {"value": [0.0, 0.0], "unit": "1"}
