"""Beams that lie on each other are refused; what touches without being connected is told, and its mass is counted once."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from preprocessing import build
from preprocessing.builders.frame_recipe import FrameRecipe
from tests.preprocessing.test_frame_models import run
from toolkit.foundation.errors import InputError

LINE_MASS = 7850 * np.pi * 0.01**2
"""Mass of a metre of the rod below."""


def written(tmp_path, nodes: dict, beams: list[str]):
    """A frame of round rods between nodes with names of one letter: "AB" leads from A to B."""
    dimension = len(next(iter(nodes.values())))
    rows = ", ".join(f'{{ from = "{beam[0]}", to = "{beam[1]}", section = "s", elements = 1 }}' for beam in beams)
    section = 'kind = "circle", diameter = 0.02' if dimension == 3 else 'kind = "rectangle", thickness = 0.01, width = 0.02'
    poisson = "poisson_ratio = 0.3, " * (dimension == 3)
    path = tmp_path / "frame.toml"
    path.write_text(
        f"""units = "m-kg-s"
dimension = {dimension}
clamp = ["A"]
nodes = {{ {", ".join(f"{name} = {[float(x) for x in place]}" for name, place in nodes.items())} }}
beams = [{rows}]
sections.s = {{ {section}, material = "steel" }}
materials.steel = {{ youngs_modulus = 2.0e11, {poisson}density = 7850.0 }}
interface_points = {{ tip = {{ node = "{[*nodes][-1]}" }} }}
"""
    )
    return path


DOUBLED = {
    "twice": ({"A": (0, 0, 0), "B": (1, 0, 0)}, ["AB", "BA"], "beams.1: between B and A there is a beam already, beams.0"),
    "whole over two": (
        {"A": (0, 0, 0), "B": (1, 2, 3), "C": (3, 6, 9)},
        ["AB", "BC", "AC"],
        "beams.2 (from A to C) and beams.0 (from A to B) lie on each other over a length of 3.74166",
    ),
    "partly": (
        {"A": (0, 0), "B": (2, 0), "C": (1.5, 0), "D": (4, 0)},
        ["AB", "CD", "AC", "BD"],
        "beams.1 (from C to D) and beams.0 (from A to B) lie on each other over a length of 0.5",
    ),
    "inside, turned": (
        {"A": (0, 0), "B": (3, 3), "C": (2, 2), "D": (1, 1), "E": (0, 3)},
        ["AB", "CD", "BE", "EC"],
        "beams.1 (from C to D) and beams.0 (from A to B) lie on each other over a length of 1.41421",
    ),
    "other nodes at the same places": (
        {"A": (0, 0), "B": (1, 0), "C": (0, 1), "D": (0, 0), "E": (1, 0)},
        ["AB", "AC", "DE", "CD"],
        "beams.2 (from D to E) and beams.0 (from A to B) lie on each other over a length of 1,",
    ),
    "back on itself": (
        {"A": (0, 0), "B": (1, 0), "C": (0.4, 0)},
        ["AB", "BC"],
        "beams.1 (from B to C) and beams.0 (from A to B) lie on each other over a length of 0.6",
    ),
    "typed with five digits": (
        {"A": (0, 0), "B": (1, 0.33333), "C": (3, 1)},
        ["AC", "AB"],
        "beams.1 (from A to B) and beams.0 (from A to C) lie on each other over a length of 1.05",
    ),
}


@pytest.mark.parametrize("case", DOUBLED)
def test_beams_on_each_other_are_refused_with_both_names(tmp_path, case):
    nodes, beams, message = DOUBLED[case]
    with pytest.raises(InputError, match=re.escape(message)) as refused:
        FrameRecipe.read(written(tmp_path, nodes, beams))
    assert "leave one out" in str(refused.value)


TOUCHING = {
    "node on a beam": (
        {"A": (0, 0, 0), "B": (2, 0, 0), "C": (1, 0, 0), "D": (1, 1, 0)},
        ["AB", "AD", "DC"],
        2 + np.sqrt(2) + 1,
        "nodes lie on beams without being connected: C on beams.0 (from A to B). If they are joined, let two beams meet at the node.",
    ),
    "beams that cross": (
        {"A": (0, 0, 1), "B": (2, 2, 1), "C": (0, 2, 1), "D": (2, 0, 1)},
        ["AB", "AC", "CD"],
        4 * np.sqrt(2) + 2,
        "beams cross without being connected: beams.0 (from A to B) and beams.2 (from C to D) at (1, 1, 1). If they are joined, put a",
    ),
    "two nodes at one place": (
        {"A": (0, 0, 0), "B": (1, 0, 0), "C": (0, 1, 0), "D": (1, 0, 0)},
        ["AB", "AC", "CD"],
        2 + np.sqrt(2),
        "nodes are at one place without being connected: B and D at (1, 0, 0). If they are one node, give it one name.",
    ),
}


@pytest.mark.parametrize("case", TOUCHING)
def test_what_touches_without_a_common_node_is_told(tmp_path, case, monkeypatch, capsys):
    """As a remark of the first run, and as a warning of every run; the mass is that of all beams."""
    nodes, beams, length, message = TOUCHING[case]
    path, remarks = written(tmp_path, nodes, beams), []
    model = build(path, remarks.append)
    assert [text.startswith(f"frame.toml: {message}") for text in remarks] == [True]
    np.testing.assert_allclose(model.invariants.mass, LINE_MASS * length, rtol=1e-12)
    assert run(monkeypatch, str(path)) == 0
    assert capsys.readouterr().err.count(message) == 1
    assert run(monkeypatch, str(path), "--json") == 0
    again = capsys.readouterr()
    assert not json.loads(again.out)["built"]
    assert json.loads(again.out)["warnings"] == remarks
    assert f"warning: frame.toml: {message}" in again.err


def test_loose_beams_are_refused_with_where_they_touch(tmp_path):
    path = written(tmp_path, {"A": (0, 0), "B": (2, 0), "C": (1, 0), "D": (1, 1)}, ["AB", "CD"])
    with pytest.raises(InputError, match=r"no beams lead from A to C, D.*\(nodes lie on beams .* C on beams.0 \(from A to B\)"):
        FrameRecipe.read(path)


GOOD = {
    "straight line of beams": ({"A": (0, 0, 0), "B": (1, 1, 1), "C": (2, 2, 2), "D": (3, 3, 3)}, ["AB", "CB", "CD"]),
    "collinear with a gap": ({"A": (0, 0), "B": (1, 0), "C": (2, 0), "D": (3, 0), "E": (1.5, 1)}, ["AB", "CD", "BE", "EC"]),
    "beams over each other with a distance": (
        {"A": (0, 0, 0), "B": (2, 2, 0), "C": (0, 2, 0.02), "D": (2, 0, 0.02)},
        ["AB", "AC", "CD"],
    ),
    "parallel beams": ({"A": (0, 0), "B": (2, 0), "C": (2, 0.01), "D": (0, 0.01)}, ["AB", "BC", "CD"]),
    "narrow fork": ({"A": (0, 0), "B": (2, 0.01), "C": (2, -0.01)}, ["AB", "AC"]),
    "short stub": ({"A": (0, 0), "B": (30, 0), "C": (30, 0.02), "D": (60, 0)}, ["AB", "BC", "BD"]),
}


@pytest.mark.parametrize("case", GOOD)
def test_frames_whose_beams_meet_at_nodes_alone_are_read_without_a_word(tmp_path, case):
    recipe = FrameRecipe.read(written(tmp_path, *GOOD[case]))
    assert list(recipe.warnings) == []


def test_random_crossings_are_found_and_beams_that_were_split_there_are_not(tmp_path):
    """Of beams with random ends, whose crossing is known by construction, in the plane and in space."""
    rng = np.random.default_rng(3)
    for dimension in (2, 3):
        for _ in range(20):
            middle, *ways = rng.normal(size=(3, dimension))
            ends = [middle + factor * way for way in ways for factor in (-rng.uniform(0.2, 2), rng.uniform(0.2, 2))]
            nodes = dict(zip("ABCD", ends, strict=True))
            (told,) = FrameRecipe.read(written(tmp_path, nodes, ["AB", "BC", "CD"])).warnings
            assert "beams.0 (from A to B) and beams.2 (from C to D)" in told
            split = written(tmp_path, {**nodes, "M": middle}, ["AM", "MB", "BC", "CM", "MD"])
            assert list(FrameRecipe.read(split).warnings) == []


def test_many_places_are_counted(tmp_path):
    nodes = {"A": (0, 0), "B": (10, 0)} | {name: (2 * k + 1, (-1) ** k) for k, name in enumerate("CDEFG")}
    (told,) = FrameRecipe.read(written(tmp_path, nodes, ["AB", "AC", "CD", "DE", "EF", "FG"])).warnings
    assert told.count(" and beams.") == 3
    assert "and 1 more" in told
