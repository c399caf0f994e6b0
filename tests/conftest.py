"""Order of a long run of the tests: what is compiled for the plane and for space is compiled once, each by a process of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

from toolkit.command_line.rehearsal import rehearse
from toolkit.scene.scene import Scene
from toolkit.scene_file.reader import read_scene

MODELS = Path(__file__).parents[1] / "models"
PLANE, SPACE = "four_bar_chain", "spatial_bracket"
SHARES = {"gw0": PLANE, "gw1": SPACE}
"""Worker of pytest-xdist -> the model whose dimension it compiles before its first test."""
LONG = 1000
"""Number of tests from which on it pays: a few tests compile what they need."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests in space come last, when their formulas are compiled; `make test` gives a file to one worker, for what its tests share."""
    items.sort(key=lambda item: "spatial" in item.nodeid or "space" in item.nodeid)


def pytest_collection_finish(session: pytest.Session) -> None:
    """Compile this worker's share before the first test of a long run."""
    share = SHARES.get(getattr(session.config, "workerinput", {}).get("workerid"))
    if share and len(session.items) >= LONG:
        for scene in formulations(share):
            rehearse(scene, "static", backwards=True)
            rehearse(scene, "transient", backwards=True)


def formulations(model: str) -> list[Scene]:
    """The scene with one level of equations and with both."""
    path = MODELS / model / "scene.toml"
    return [read_scene(path, {"solver.formulation": formulation}) for formulation in ("index-1", "ggl")]
