"""What users see of a scene whose body has several frames: cost summary, ParaView series, report, map of stability, price of accuracy."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import ffrf
from tests.models.spatial_chains import save_chain
from toolkit.analyses.sensitivity.run import restored
from toolkit.command_line.cli import app
from toolkit.files.results_file import load_results
from toolkit.validity.bodies.deformation import node_places

SCENE = """units = "m-kg-s"
[points]
root = { body = "beam", interface = "root" }
tip = { body = "beam", interface = "tip" }
[bodies]
beam = { type = "flexible", model = "beam.h5", frames = 3 }
[joints]
hub = { type = "revolute", bodies = ["beam", "ground"], point = "root" }
[loads]
weight = { type = "gravity", acceleration = [0.0, -9.81] }
coil = { type = "rotational-spring-damper", bodies = ["beam", "ground"], point = "root", stiffness = 0.5, damping = 0.05 }
[design]
E = "bodies.beam.youngs_modulus_m"
k = "loads.coil.stiffness"
[responses]
y = { type = "displacement", body = "beam", point = "tip", component = "y" }
stress = { type = "ks-stress", body = "beam", aggregation = 10.0, reference_stress = 1e6 }
[solver]
end_time = 0.1
step = 0.005
rho_inf = 0.8
"""
ELEMENTS = 6


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A slender beam that falls about a sprung hub, and its kept motion."""
    found = tmp_path_factory.mktemp("beam")
    nodes = np.column_stack([np.linspace(0, 1, ELEMENTS + 1), np.zeros(ELEMENTS + 1)])
    save_chain(found, nodes, young=2e8, damping=1e-3)
    (found / "scene.toml").write_text(SCENE)
    asked("simulate", found / "scene.toml", "--output", found / "kept.h5")
    return found


def asked(*arguments: object) -> str:
    """What a command prints."""
    done = CliRunner().invoke(app, [*map(str, arguments), "--quiet"])
    assert done.exit_code == 0, done.output
    return done.stdout


def test_the_cost_summary_counts_what_frames_add(folder):
    """Three parts of two elements: nine nodal coordinates each, less three for its chord, and three of its frame; ties, and the hub."""
    found = json.loads(asked("inspect", folder / "scene.toml", "--json"))["cost_summary"]
    assert {each["what"]: each["kept"] for each in found["coordinates"]} == {f"beam[{k}]": 9 for k in (1, 2, 3)}
    assert {each["what"]: each["kept"] for each in found["constraint rows"]} == {
        "1 revolute": 2,
        "2 between parts of bodies": 6,
    }


def test_a_series_for_paraview_goes_through_the_nodes(folder):
    pyvista = pytest.importorskip("pyvista")
    asked("export", folder / "kept.h5", "--paraview", folder / "series")
    series = sorted((folder / "series").glob("beam_*.vtp"))
    solution = restored(load_results(folder / "kept.h5")).solution
    for instant in (0, -1):
        drawn = np.asarray(pyvista.read(series[instant]).points)[:, :2]
        for place in node_places(solution, "beam")[instant]:
            assert np.linalg.norm(drawn - place, axis=1).min() < 1e-7  # single precision of a length of 1


def test_a_report_shows_one_body(folder):
    write_short(folder)
    asked("report", folder / "short.toml", "--no-judges", "--output", folder / "report")
    page = (folder / "report" / "report.html").read_text(encoding="utf-8")
    assert "beam" in page
    assert "beam[" not in page
    told = json.loads((folder / "report" / "numbers.json").read_text())
    kept = load_results(folder / "kept.h5")
    assert told["responses"]["rows"] == [["y", pytest.approx(kept.responses["y"], rel=1e-12), "m"]]


def test_it_is_as_stable_in_other_units(folder):
    """Of the model in mm, t and s the motion is the same, and stable with its gradients."""
    found = json.loads(asked("stability", folder / "scene.toml", "--maps", "units", "--jobs", 1, "--json"))["maps"]["units"]
    assert found["stable"] == {"run": "all", "gradient": "all"}
    one, other = (each["values"] for each in found["cells"])
    assert other == {name: pytest.approx(value, rel=1e-11) for name, value in one.items()}  # round-off of 20 steps


def test_the_price_of_frames_is_measured_and_drawn(folder):
    """Errors are those of a run with a frame to every element; the step, of second order, is that of all."""
    write_short(folder)
    output: Path = folder / "tradeoff"
    words = ["--axes", "frames=1/3/every", "--budget", "all=0.1", "--repeats", 1, "--jobs", 1, "--output", output]
    found = json.loads(asked("tradeoff", folder / "short.toml", *words, "--json"))
    assert (output / "tradeoff.png").stat().st_size > 5000
    told = {each["setting"]["frames"]: each["relative_errors"]["y"] for each in found["settings"]}
    true = found["reference"]["values"]["y"]["value"]
    for frames, error in told.items():
        changes = {"bodies.beam.frames": str(ELEMENTS) if frames == "every" else frames}
        value = ffrf.compile(ffrf.read_scene(folder / "short.toml", changes)).simulate().values["y"]
        assert error == pytest.approx(abs(value / true - 1), rel=1e-6)
    assert told["1"] > 5 * told["3"]


def write_short(folder: Path) -> None:
    """The scene with one response alone, and no variables."""
    text = SCENE[: SCENE.index("[design]")] + SCENE[SCENE.index("[responses]") : SCENE.index("stress =")]
    (folder / "short.toml").write_text(text + SCENE[SCENE.index("[solver]") :])
