"""Scenes, studies, skins, bodies and airfoils with the mistakes of the fast tests, through the commands."""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import HealthCheck, given, seed, settings
from hypothesis import strategies as st

from tests.fuzz.case import Case
from tests.fuzz.toml_mutations import document, spoilt
from tests.models.truss import SCENE
from tests.preprocessing.test_fuzz_airfoils import spoilt_rows
from toolkit.foundation.files.toml_file import read_toml

MODELS = Path(__file__).parents[2] / "models"
AT_ONCE = 200
"""Examples that are drawn together."""
STUDY = """
scene = "scene.toml"
analysis = "statics"
responses = { fall = { type = "displacement", body = "tip", point = "P", component = "y" } }
objective = { minimize = { rise = 1.0 }, over_cases = "sum" }
constraints = { load_margin = { above = 1.05 }, fall = { below = 0.1, above = -0.4 } }
cases = { light = { "loads.right.stiffness" = 900.0 }, heavy = { "loads.right.stiffness" = 1100.0 } }
search = { method = ["slsqp"], starts = 1, evaluations = 2, optimality = 1e-3, certify = false }
sweep = { points = "sobol", count = 2, seed = 1, responses = ["rise"], gradients = true }

[variables]
"loads.push.force.y" = { between = [-40.0, -10.0] }
both = { of = ["points.L.x", "points.R.x"], factors = [1.0, -1.0], between = [-0.1, 0.1] }

[uncertain]
"loads.left.stiffness" = { distribution = "normal", sigma = 10.0 }
"points.P.y" = { distribution = "uniform", between = [0.49, 0.51] }

[uncertainty]
runs = 4
monte_carlo = 1
quantiles = [0.05, 0.95]
responses = ["rise"]
correlations = [{ of = ["loads.left.stiffness", "points.P.y"], coefficient = 0.3 }]
"""
ASIDE = ("--output", "../kept", "--no-pictures", "--quiet")
"""Beside the folder of a case: what a study has solved stays where it then fails."""
STUDIES = (
    ("sweep", "--points", "sobol", "--count", "2"),
    ("optimize", "--starts", "1", "--evaluations", "2"),
    ("uncertainty", "--runs", "4", "--monte-carlo", "1"),
)
"""Commands that solve a few designs, whatever the study says."""
SHORT = {"end_time": 0.02, "step": 0.01, "load_steps": 2, "path_steps": 10, "max_iterations": 10}


def drawn(strategy: st.SearchStrategy[Any], rng: np.random.Generator) -> Iterator[Any]:
    """Examples of a strategy, without end."""
    while True:
        yield from _some(strategy, int(rng.integers(2**32)))


def _some(strategy: st.SearchStrategy[Any], number: int) -> list[Any]:
    found: list[Any] = []

    @seed(number)
    @settings(max_examples=AT_ONCE, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(strategy)
    def collect(example: Any) -> None:
        found.append(example)

    collect()
    return found


def scenes(rng: np.random.Generator) -> Iterator[Case]:
    """Spoilt scenes, inspected or solved."""
    tables = []
    for path in sorted(MODELS.glob("*/scene.toml")):
        table = tomllib.loads(path.read_text())
        for each in table["bodies"].values():
            if "model" in each:
                each["model"] = str(path.parent / each["model"])
        table["solver"] = {**table.get("solver", {}), **SHORT}
        tables.append(table)
    for k, table in enumerate(drawn(spoilt(tables), rng)):
        command = ("ffrf", "statics", "scene.toml") if k % 3 == 0 else ("ffrf", "inspect", "scene.toml", "--no-measure")
        yield Case(f"scene {k}", command, _written({"scene.toml": document(table)}))


def studies(rng: np.random.Generator) -> Iterator[Case]:
    """Spoilt studies of a truss: swept, optimised, or asked what is uncertain."""
    for k, table in enumerate(drawn(spoilt([tomllib.loads(STUDY)]), rng)):
        command, *options = STUDIES[k % len(STUDIES)]
        write = _written({"scene.toml": SCENE, "study.toml": document(table)})
        yield Case(f"study {k}", ("ffrf", command, "study.toml", *options, *ASIDE), write)


def skins(rng: np.random.Generator) -> Iterator[Case]:
    """Spoilt skins and frames."""
    wing = MODELS / "morphing_wing"
    airfoils = {name: (wing / name).read_text() for name in ("high_speed.dat", "low_speed.dat")}
    for k, table in enumerate(drawn(spoilt([tomllib.loads((wing / "skin.toml").read_text())]), rng)):
        yield Case(f"skin {k}", ("ffrf-preprocess", "skin.toml"), _written({"skin.toml": document(table), **airfoils}))


def bodies(rng: np.random.Generator) -> Iterator[Case]:
    """Spoilt descriptions of bodies with a mesh."""
    table = read_toml(MODELS / "bracket" / "body.toml", "")
    for k, found in enumerate(drawn(spoilt([table]), rng)):
        write = _written({"body.toml": document(found)}, MODELS / "bracket" / "bracket.msh")
        yield Case(f"body {k}", ("ffrf-preprocess", "body.toml"), write)


def airfoils(rng: np.random.Generator) -> Iterator[Case]:
    """Spoilt sections, built into a skin."""
    wing = MODELS / "morphing_wing"
    skin, target = (wing / "skin.toml").read_text(), (wing / "low_speed.dat").read_text()
    for k, text in enumerate(drawn(spoilt_rows(), rng)):
        files = {"skin.toml": skin, "low_speed.dat": target, "high_speed.dat": text}
        yield Case(f"airfoil {k}", ("ffrf-preprocess", "skin.toml"), _written(files))


def _written(files: dict[str, str], *copied: Path) -> Any:
    def write(folder: Path) -> None:
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8", errors="replace", newline="")
        for each in copied:
            shutil.copy(each, folder)

    return write
