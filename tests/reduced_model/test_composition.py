"""What a reduced model keeps of the mesh that it was made of: bounded when it is written, checked when it is read."""

import json
from dataclasses import replace

import numpy as np
import pytest

from preprocessing.builders.frame_recipe import polygon_beam
from preprocessing.elements.section import Section
from toolkit.api.describe import describe
from toolkit.foundation.errors import ModelFileError
from toolkit.reduced_model.body_summary import NOT_KEPT
from toolkit.reduced_model.composition import (
    LISTS,
    LONGEST_TEXT,
    MOST_ENTRIES,
    Composition,
    KeptLeftOut,
    KeptMass,
    PlaceOfNodes,
    plain_text,
    read_composition,
)
from toolkit.reduced_model.file import load, save
from toolkit.reduced_model.model import ReducedModel
from toolkit.reduced_model.told_body import body_line, body_lines

FULL = Composition(
    nodes=20,
    elements={"hexahedron": 4, "wedge15": 1},
    volume=2.0,
    interface_points={"tip": 4},
    clamp=PlaceOfNodes([0.0, 0.5], 4),
    groups={"Löcher": PlaceOfNodes([4.0, 0.5], 4), "reference": PlaceOfNodes(None, 0)},
    masses=[KeptMass(500.0, [4.0, 1.0], 1, "MASS, line 40")],
    left_out=[KeptLeftOut("M3D9", 12, "faces only")],
    remarks=["The file gives node 5 twice; the last one counts."],
)


@pytest.fixture(scope="module")
def rod() -> ReducedModel:
    section = Section(2e11, 7800.0, 0.02, 0.05)
    return polygon_beam(np.array([[0, 0], [1, 0], [2, 0]]), section, {"root": 0.0, "middle": 0.5, "tip": 2.0})


def test_it_is_read_as_it_was_kept():
    assert read_composition(FULL.attributes(), 2) == FULL
    assert read_composition({}, 2) == Composition()


def test_a_file_keeps_it_and_one_without_it_is_read_as_before(rod, tmp_path):
    save(replace(rod, composition=FULL.attributes()), tmp_path / "rod.h5")
    assert read_composition(load(tmp_path / "rod.h5").composition, 2) == FULL
    save(replace(rod, composition={}), tmp_path / "old.h5")
    body = describe(tmp_path / "old.h5")["body"]
    assert (body["nodes"], body["elements"], body["volume"]) == (None, None, None)
    assert body["interface_points"]["tip"] == {"position": [2.0, 0.0], "nodes": None}
    assert body["mass"] == pytest.approx(7800.0 * 0.02 * 0.05 * 2.0)
    assert body["remarks"] == [NOT_KEPT]


@pytest.mark.parametrize("count", [1, MOST_ENTRIES, MOST_ENTRIES + 7, 20_000])
def test_however_much_a_mesh_file_holds_the_model_keeps_little_of_it_and_says_how_much_more_there_was(rod, tmp_path, count):
    name = "ü" * 90
    many = Composition(
        groups={f"{name}{k}": PlaceOfNodes([1.0 / 3.0, -2e-300], k) for k in range(count)},
        masses=[KeptMass(1.0, [0.0, 0.0], 1, "MASS")] * count,
        left_out=[KeptLeftOut("B31", 1, "x" * 400)] * count,
        remarks=["\u4e2d" * 400] * count,
    )
    found = many.attributes()
    assert all(len(str(each).encode()) <= LONGEST_TEXT for each in found.values())
    kept = read_composition(found, 2)
    for each in LISTS:
        assert len(getattr(kept, each)) + kept.not_listed.get(each, 0) == count
        assert len(getattr(kept, each)) >= min(count, 30)
    save(replace(rod, composition=found), tmp_path / "rod.h5")
    assert load(tmp_path / "rod.h5").composition == found


def test_foreign_texts_cannot_command_a_terminal_and_are_short():
    assert plain_text("tip\x1b[2J\n") == "tip?[2J?"
    assert len(plain_text("x" * 10_000)) == 100


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("nodes", -1),
        ("nodes", 1.5),
        ("nodes", "20"),
        ("volume", 0.0),
        ("volume", float("nan")),
        ("volume", "2"),
        ("elements", 4),
        ("elements", "{"),
        ("elements", "[4]"),
        ("elements", '{"hexahedron": true}'),
        ("elements", '{"hexahedron": -4}'),
        ("elements", '{"hexahedron": 1e400}'),
        ("elements", "[" * 50_000),
        ("elements", json.dumps({"x" * 101: 1})),
        ("elements", json.dumps({"\x1b[2J": 1})),
        ("interface_points", '{"tip": ' + "9" * 5000 + "}"),
        ("clamp", "[[0.0, 0.5, 0.25], 4]"),
        ("clamp", "[[0.0, NaN], 4]"),
        ("clamp", "[4]"),
        ("groups", '{"left": [[0.0, "0.5"], 4]}'),
        ("groups", '{"left": [[0.0, 0.5], null]}'),
        ("masses", "[[1.0, [0.0, 0.0], 1]]"),
        ("left_out", json.dumps([["M3D9", 12, "faces only"]] * (MOST_ENTRIES + 1))),
        ("left_out", '[["M3D9", 12]]'),
        ("remarks", f'["{"x" * 401}"]'),
        ("remarks", f'["{" " * LONGEST_TEXT}"]'),
        ("not_listed", "[]"),
        ("unheard_of", "[]"),
    ],
)
def test_what_no_model_has_kept_is_refused(rod, tmp_path, name, value):
    with pytest.raises(ValueError, match=r"is not what it has to be|no model has"):
        read_composition({name: value}, 2)
    with pytest.raises(ModelFileError, match=r"rod\.h5': composition cannot be right: .* Build it again with ffrf-preprocess\."):
        save(replace(rod, composition={name: value}), tmp_path / "rod.h5")


def test_one_line_and_many_tell_the_same(rod):
    body = describe(replace(rod, composition=FULL.attributes()))["body"]
    line = body_line("rod", body)
    assert line.startswith(
        "rod: 4 hexahedra and 1 wedge with 15 nodes (20 nodes in all), 15.6 kg at (1, 0) m, 2 m^3; root at (0, 0)"
    )
    assert "middle at (0.5, 0); tip at (2, 0), 4 nodes; left out: 12 M3D9 (faces only)." in line
    assert "\n" not in line
    lines = list(body_lines(body))
    assert lines[:2] == ["mass: 15.6 kg", "centre: (1, 0) m"]
    assert "group Löcher: (4, 0.5) m, 4 nodes" in lines
    assert "group reference: nowhere, 0 nodes" in lines
    assert "mass of 500 kg at (4, 1) m, by MASS, line 40" in lines
    assert "left out of the mesh file: 12 M3D9 (faces only)" in lines


def test_a_rod_says_what_it_is(rod):
    """Two beams of 1 m; the root is a node, the middle of the first beam is carried by two."""
    body = describe(rod)["body"]
    mass = 7800.0 * 0.02 * 0.05 * 2.0
    assert body["mass"] == pytest.approx(mass)
    assert body["centre"] == pytest.approx([1.0, 0.0])
    assert body["inertia"] == pytest.approx(mass * (2.0**2 + 0.02**2) / 12, rel=1e-9)
    assert body["volume"] == pytest.approx(0.02 * 0.05 * 2.0)
    assert (body["nodes"], body["elements"]) == (3, {"beam": 2})
    assert {name: point["nodes"] for name, point in body["interface_points"].items()} == {"root": 1, "middle": 2, "tip": 1}
    assert body["clamp"] == {"position": [0.0, 0.0], "nodes": 1}
