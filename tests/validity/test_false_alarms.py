"""Verdicts of random scenes whose true answers are known from finer runs of finer models: what is right is trusted, and nothing else.

`tests.benchmarks.random_scenes` finds these answers, of as many scenes as one likes.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest

from tests.random_scenes.reference import answers
from tests.random_scenes.scene import named_scene
from toolkit.analyses.sensitivity.direct import again
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.analyses.sensitivity.run import run_of

RIGHT = {
    5017: "a derivative that three runs with other chosen steps agree on to 3 %",
    5042: "a driver's work against weights, which cancels",
    5054: "a bent body that no answer feels",
}
"""Seed -> what is right to 4 % of its largest value, and derivatives to 13 %, and may be doubted no more."""
WRONG = {
    5009: "values off by 25 %, by the length of the steps",
    5022: "a stress off by 9 %, which elements miss between their nodes",
    6052: "forces off by 17 %, of links that come near to buckling",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("models")


def doubts(seed: int, folder: Path) -> set[str]:
    scene = named_scene(seed, folder)[1]
    system = prepare(scene, list(scene.design))
    solution = solve(system, "transient")
    found = answers(solution, sizes=False)
    told = run_of(solution, found.values, found.gradients, "direct", 0.0, 0.0, partial(again, system)).verdict
    return {each.code for each in told.warnings if each.doubt}


@pytest.mark.parametrize("seed", RIGHT)
def test_right_answers_are_trusted(seed, folder):
    assert not doubts(seed, folder)


@pytest.mark.parametrize("seed", WRONG)
def test_wrong_answers_are_doubted(seed, folder):
    assert doubts(seed, folder)
