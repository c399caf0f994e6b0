"""Checks are found by their files, and each tells of one run and not of another."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import ffrf
from toolkit.foundation import verdict
from toolkit.foundation.verdict import SCENE, STATES, Verdict, checks, codes
from toolkit.scene.changed_numbers import with_numbers

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "house.md"
SCENE_FILE = """
units = "m-kg-s"
points = { O = [0.0, 0.0], P = [1.0, 0.0] }
bodies = { b = { type = "rigid", mass = 1.0, inertia = 1.0, center = "P" } }
loads = { k = { type = "spring-damper", bodies = ["b", "ground"], points = ["P", "O"], stiffness = 10.0, length = 0.6 } }
solver = { end_time = 1.2, step = 0.002 }
[joints]
x = { type = "slider", bodies = ["b", "ground"], point = "P", axis = [1.0, 0.0], lock_rotation = true }
"""
"""A mass on a spring, which oscillates by 0.4 about the relaxed length."""
TOLD = [
    ("spring-through-zero", "spring", {"loads.k.length": 0.2}, {}),
    ("coarse-steps", "spring", {"solver.step": 0.2}, {}),
    ("unit-of-inertia", "spring", {"bodies.b.inertia": 1e4}, {}),
    ("energy", "four_bar_chain", {"solver.step": 0.05}, {}),
]
"""Code, scene (the spring above, or a folder of `models/`), its numbers of which the code is told, and those of which it is not."""


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    file = tmp_path_factory.mktemp("checks") / "scene.toml"
    file.write_text(SCENE_FILE)
    return ffrf.read_scene(file)


def judged(scene, numbers: dict[str, float]) -> Verdict:
    return ffrf.compile(with_numbers(scene, numbers)[0]).simulate().solution.verdict


@pytest.mark.parametrize(("code", "name", "there", "elsewhere"), TOLD, ids=[row[0] for row in TOLD])
def test_a_check_tells_of_one_run_and_not_of_another(scene, code, name, there, elsewhere):
    if name != "spring":
        scene = ffrf.read_scene(ROOT / "models" / name / "scene.toml")
    assert code in judged(scene, there).codes
    assert code not in judged(scene, elsewhere).codes


def test_every_check_has_a_known_code_and_applies_to_something_that_exists():
    assert len(checks()) > 80
    for each in checks():
        assert each.code in codes()
        assert {*each.applies_to} <= {*STATES, SCENE}
    defining = [each.code for each in checks() if each.limit]
    assert len(defining) == len(set(defining)) > 60, "a code has its limit and its remedy once"


@pytest.fixture
def check_of_the_page() -> Iterator[None]:
    """The check that stands on the page about new parts, as if it were a file of the room."""
    before = list(verdict._CHECKS)
    (code,) = (
        each for each in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL) if "@check(" in each
    )
    exec(compile(code, "stretched_springs.py", "exec"), {"__name__": "toolkit.validity.stretched_springs"})
    yield
    verdict._CHECKS[:] = before


def test_a_check_that_is_written_as_the_page_says_is_told_and_explained(scene, check_of_the_page):
    """The spring begins 1 m long."""
    told = judged(scene, {"loads.k.length": 0.4})
    assert "spring-stretched" not in judged(scene, {}).codes
    assert any("loads.k is stretched to 2.5 times its relaxed length" in each for each in told.reasons)
    assert any(each.endswith("Fix: a longer spring, or a stiffer one.") for each in told.reasons)
    assert told.explained["spring-stretched"].limit == "twice its relaxed length"
