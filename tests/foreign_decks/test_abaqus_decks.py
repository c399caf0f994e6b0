"""Random decks of Abaqus and CalculiX are read as they were made, and refused by the line that has a defect."""

import re
from collections import Counter
from pathlib import Path
from random import Random

import numpy as np
import pytest

from preprocessing.foreign_files.abaqus.reader import read_deck
from preprocessing.mesh.mesh_file import read_mesh
from tests.foreign_decks.abaqus.defects import DEFECTS, SECRET, Defect, broken
from tests.foreign_decks.abaqus_decks import CARRIERS, random_deck, wrong
from toolkit.foundation.errors import InputError

FEW, MANY = 150, 2000
"""Seeds of every run of the tests, and of a long one."""
FEATURES = {
    "flat", "one_part", "one_instance", "within_instance", "twice", "two_parts", "*INSTANCE moved", "*INSTANCE turned",
    "several *NODE", "NSET on *NODE", "nodes given twice", "SYSTEM=C", "*SYSTEM a", "*SYSTEM ab", "*SYSTEM abc", "*SYSTEM ends",
    "*NGEN", "*NFILL", "*NCOPY", "*NCOPY turned", "*ELGEN", "*ELCOPY", "labels with gaps", "C3D8I with 11 nodes",
    "elements given twice", "elements over several lines", "ELSET on *ELEMENT", "INPUT=", "*INCLUDE", "*INCLUDE nested",
    "*INCLUDE of data lines", "a set ahead of its members", "*NSET, ELSET=", "INSTANCE= of sets", "instance.set", "instance.number",
    "*SURFACE of NODE", "*SURFACE of ELEMENT", "*SURFACE of an element set", "*SURFACE of nodes with areas",
    "*SURFACE of an instance's set", "reference node", "*RIGID BODY", "*RIGID BODY of the assembly", "*KINEMATIC COUPLING",
    "*COUPLING rigid", "*COUPLING mean", "*MASS", "*ROTARY INERTIA", "*SOLID SECTION", "*EQUATION",
    *(f"{kind} {way}" for kind in ("NSET", "ELSET") for way in ("listed", "GENERATE", "in blocks", "of sets", "that grows afterwards")),
    *(f"type {kind}" for kind in ("tetra", "tetra10", "wedge", "wedge15", "hexahedron", "hexahedron20")),
    *(f"type {kind}" for kind in ("triangle", "triangle6", "quad", "quad8")),
    *(f"names only: {kind}" for kind in ("line", "line3", "triangle", "triangle6", "quad", "quad8")),
    *(f"left out: {name}" for name in CARRIERS),
}  # fmt: skip
"""All that decks are made of here."""


@pytest.mark.parametrize("seed", range(FEW))
def test_a_random_deck_is_read_as_it_was_made(seed, tmp_path):
    assert wrong(seed, tmp_path) == ""


@pytest.mark.robustness
def test_many_random_decks_are_read_as_they_were_made(tmp_path):
    found = {}
    for seed in range(FEW, FEW + MANY):
        (folder := tmp_path / str(seed)).mkdir()
        if what := wrong(seed, folder):
            found[seed] = what
    assert found == {}


def test_random_decks_have_every_feature():
    times = Counter(feature for seed in range(2 * FEW) for feature in random_deck(seed).features)
    assert set(times) == FEATURES


def test_a_difference_is_seen(tmp_path):
    """The comparison itself: the truth of another deck is not what this one holds, nor is one with a node that is elsewhere."""
    from tests.foreign_decks.abaqus.truth import difference

    deck = random_deck(1)
    found = read_deck(deck.written(tmp_path), deck.leave_out)
    assert difference(deck.truth, found) == ""
    assert difference(random_deck(2).truth, found)
    for content in (each.content for each in deck.truth.placed if each.content.nodes):
        first = next(iter(content.nodes))
        content.nodes[first] = content.nodes[first] + [0.0, 0.0, 1e-6]
    assert "places of nodes" in difference(deck.truth, found)


@pytest.mark.usefixtures("read_here")
def test_the_volume_is_that_of_the_body_by_construction(tmp_path):
    """The volume of a sheared block is its extents times the determinant; that of a mesh, the sum of its tetrahedra."""
    tried = 0
    for seed in range(40):
        deck = random_deck(seed)
        if (
            deck.truth.volume is None
            or not deck.solid
            or len(deck.truth.placed) > 2
            or deck.features & {"two_parts", "type wedge15"}
        ):
            continue
        (folder := tmp_path / str(seed)).mkdir()
        mesh = read_mesh(deck.written(folder), leave_out=[*deck.leave_out])
        volume = sum(_volume(kind, mesh.nodes[block]) for kind, block in mesh.blocks.items())
        assert volume == pytest.approx(deck.truth.volume, rel=1e-12)
        tried += 1
    assert tried > 5


TETRAHEDRA = {
    "tetra": [(0, 1, 2, 3)],
    "wedge": [(0, 1, 2, 3), (1, 2, 3, 4), (2, 3, 4, 5)],
    "hexahedron": [(0, 1, 3, 4), (1, 2, 3, 6), (1, 3, 4, 6), (1, 4, 5, 6), (3, 4, 6, 7)],
}
"""Kind -> tetrahedra that fill it where its faces are plane."""


def _volume(kind: str, places: np.ndarray) -> float:
    name = next(each for each in TETRAHEDRA if kind.startswith(each))
    edges = [places[:, [b, c, d]] - places[:, [a]] for a, b, c, d in TETRAHEDRA[name]]
    return float(sum(np.abs(np.linalg.det(each)).sum() for each in edges)) / 6


@pytest.mark.parametrize("defect", DEFECTS, ids=lambda defect: defect.name)
def test_a_deck_with_a_defect_is_refused_by_its_line(defect, tmp_path):
    assert refused(defect, range(60), 2, tmp_path) == 2


@pytest.mark.robustness
@pytest.mark.parametrize("defect", DEFECTS, ids=lambda defect: defect.name)
def test_many_decks_with_a_defect_are_refused_by_its_line(defect, tmp_path):
    assert refused(defect, range(1000, 1200), 20, tmp_path) >= 5


def refused(defect: Defect, seeds: range, most: int, folder: Path) -> int:
    """How many decks with a defect were refused as they are to be, up to so many."""
    tried = 0
    for seed in seeds:
        deck = broken(Random(seed), random_deck(seed), defect)
        if deck is None:
            continue
        (own := folder / str(seed)).mkdir()
        with pytest.raises(InputError, match=defect.match) as error:
            read_deck(deck.written(own), deck.leave_out)
        assert SECRET not in str(error.value).lower()
        lines = [f"{str(own / name)!r}, line {k}" for name, marked in deck.files.marked.items() for k in marked]
        assert not lines or any(re.search(rf"{re.escape(line)}\b", str(error.value)) for line in lines)
        tried += 1
        if tried == most:
            break
    return tried
