"""The nightly run of hostile inputs itself: it tells right from wrong, and gives the same cases for the same seed."""

from __future__ import annotations

import json
import subprocess
import sys
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from tests.fuzz import include_cases, matrix_cases, mesh_cases, option_cases, path_cases, toml_cases
from tests.fuzz.case import Case, Ended, identity, judged, snapshot
from toolkit.studies.problem import problem_of
from toolkit.studies.study_file import read_study

ROOT = Path(__file__).parents[2]
CASE = Case("any", ("ffrf",), lambda _: None, ("out.h5",))
WORDS = "there is no file 'x'. Fix the path."
BEFORE = {"in.toml": "1", "out.h5": "1"}
JUDGED = {
    "result": (Ended(0, ""), BEFORE),
    "result that replaces": (Ended(0, ""), {**BEFORE, "out.h5": "2", "more": "3"}),
    "own error": (Ended(1, WORDS), BEFORE),
    "hang": (Ended(None, ""), BEFORE),
    "crash": (Ended(-11, ""), BEFORE),
    "traceback": (Ended(1, "Traceback (most recent call last):\n  ..."), BEFORE),
    "traceback by its code": (Ended(70, WORDS), BEFORE),
    "no words": (Ended(1, "\n"), BEFORE),
    "damaged input": (Ended(0, ""), {**BEFORE, "in.toml": "2"}),
    "damaged output": (Ended(1, WORDS), {**BEFORE, "out.h5": "2"}),
    "damaged by what is left": (Ended(1, WORDS), {**BEFORE, "new": "2"}),
    "damaged by what is unfinished": (Ended(0, ""), {**BEFORE, "out12.tmp.h5": "2"}),
    "damaged by what is gone": (Ended(1, WORDS), {"in.toml": "1"}),
}


@pytest.mark.parametrize("kind", JUDGED)
def test_what_came_of_a_case_is_told(kind):
    ended, after = JUDGED[kind]
    assert kind.startswith(judged(CASE, ended, BEFORE, after)[0])


def identities(module, folder: Path, seed: int) -> list[str]:
    found = []
    for k, case in enumerate(islice(module.cases(np.random.default_rng(seed)), 12)):
        place = folder / f"{seed}-{k}"
        place.mkdir(parents=True)
        case.write(place)
        found.append(identity(case, snapshot(place)))
    return found


@pytest.mark.parametrize("module", [matrix_cases, mesh_cases, include_cases, option_cases, path_cases])
def test_a_seed_gives_the_same_cases_and_another_one_others(module, tmp_path):
    first, again, other = (identities(module, tmp_path / str(k), seed) for k, seed in enumerate((1, 1, 2)))
    assert first == again
    assert len(set(first) | set(other)) > 18


def test_studies_are_spoilt_too_and_the_one_that_is_spoilt_is_good(tmp_path):
    (tmp_path / "study.toml").write_text(toml_cases.STUDY)
    (tmp_path / "scene.toml").write_text(toml_cases.SCENE)
    problem = problem_of(read_study(tmp_path / "study.toml"))
    assert set(problem.variables) == {"loads.push.force.y", "both"}
    first = list(islice(toml_cases.studies(np.random.default_rng(1)), 3))
    assert [case.arguments[1] for case in first] == ["sweep", "optimize", "uncertainty"]


@pytest.mark.robustness
def test_a_small_run_finds_nothing_wrong(tmp_path):
    command = [
        sys.executable,
        "-m",
        "tests.fuzz.nightly",
        "--cases",
        "24",
        "--seed",
        "3",
        "--fresh",
        "12",
        "--folder",
        str(tmp_path),
    ]
    done = subprocess.run(
        [*command, "--kinds", "matrices,meshes,includes"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    figures = json.loads((tmp_path / "figures.json").read_text())["all"]
    assert figures["distinct"] >= 24
    assert figures["result"] + figures["own error"] == figures["distinct"]
    assert figures["fresh"] > 0
