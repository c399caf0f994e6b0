"""Spoilt scenes and changes: a solution, or one of the program's own errors; numpy's warnings count as failures."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.fuzz.toml_mutations import NAMES, NUMBERS, as_toml, document, spoilt, values
from toolkit.analyses.sensitivity.preparation import evaluate_responses, prepare, solve
from toolkit.command_line.commands.inspection import describe_scene
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ToolkitError
from toolkit.scene.scene import Scene

pytestmark = pytest.mark.robustness

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "models").glob("*/scene.toml"))
TABLES: list[dict[str, Any]] = [tomllib.loads(path.read_text()) for path in FILES]
for path, table in zip(FILES, TABLES, strict=True):
    for body in table["bodies"].values():
        if "model" in body:
            body["model"] = str(path.parent / body["model"])


def examples(count: int) -> settings:
    """The same cases in every run."""
    return settings(max_examples=count, deadline=None, derandomize=True, database=None, suppress_health_check=list(HealthCheck))


@pytest.fixture(scope="module")
def file(tmp_path_factory) -> Path:
    """Where the spoilt scene is written."""
    return tmp_path_factory.mktemp("scenes") / "scene.toml"


def use(scene: Scene) -> None:
    """Everything that is done with a scene that was accepted, in few steps."""
    describe_scene(scene)
    options = scene.solver.model_copy(
        update={
            "end_time": min(scene.solver.end_time, 3 * scene.solver.step),
            "load_steps": min(scene.solver.load_steps, 2),
            "max_iterations": min(scene.solver.max_iterations, 10),
            "path_steps": min(scene.solver.path_steps, 20),  # statics gives up early
        }
    )
    short = scene.model_copy(update={"solver": options})
    for kind in ("static", "transient"):
        try:
            system = prepare(short, list(scene.design)[:2])
            evaluate_responses(solve(system, kind))
        except ToolkitError as error:
            check(error)


def check(error: ToolkitError) -> None:
    """It is something to read, not the content of the file."""
    assert 10 < len(str(error)) < 40_000
    str(error).encode()


def attempt(path: Path, changes: dict[str, str] | None = None) -> Scene | None:
    """A scene, or None if it was refused as it should be."""
    try:
        return read_scene(path, changes)
    except ToolkitError as error:
        check(error)
        return None


@examples(400)
@given(table=spoilt(TABLES))
def test_a_spoilt_scene_is_refused_by_the_program_itself_or_solved(file, table):
    file.write_text(document(table), encoding="utf-8")
    scene = attempt(file)
    if scene is not None:
        use(scene)


texts = st.one_of(
    values.map(as_toml), st.text(max_size=20), st.sampled_from(["1\n[x]", "#", "'", "[" * 3000, "1" * 5000, "0x" + "f" * 5000])
)
parts = st.one_of(st.sampled_from(["points", "bodies", "joints", "loads", "design", "solver", "A",
                                   "skin", "hub", "O", "x", "y", "0", "baumgarte",
                                   "damping", "model", "torque", "drive", "curve", "step", "type", "between", "²", "1" * 5000, "-1", ""]),
                  st.sampled_from(NAMES), st.text(max_size=5))  # fmt: skip


@examples(600)
@given(data=st.data())
def test_a_spoilt_change_is_refused_by_the_program_itself_or_used(data):
    path = data.draw(st.sampled_from(FILES))
    known = st.sampled_from([*read_scene(path).available_paths(), "solver.step", "solver.baumgarte.damping", "units"])
    keys = st.one_of(known, st.lists(parts, min_size=1, max_size=5).map(".".join))
    attempt(path, data.draw(st.dictionaries(keys, texts, max_size=3)))


@examples(150)
@given(data=st.data())
def test_any_number_of_a_scene_can_be_changed_to_anything(data):
    path = data.draw(st.sampled_from(FILES))
    number = data.draw(st.sampled_from(read_scene(path).available_paths()))
    scene = attempt(path, {number: as_toml(data.draw(st.one_of(st.sampled_from(NUMBERS), st.floats())))})
    if scene is not None:
        use(scene)


@examples(300)
@given(content=st.one_of(st.binary(max_size=60), st.text(max_size=60).map(str.encode)))
def test_what_is_no_toml_is_refused(file, content):
    file.write_bytes(content)
    attempt(file)
