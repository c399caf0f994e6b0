"""CalculiX itself says what random decks hold: nodes, elements, sets and volumes, in the words that it knows."""

import re
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from preprocessing.foreign_files.abaqus.reader import read_deck
from tests.foreign_decks.abaqus.files import folded
from tests.foreign_decks.abaqus.lattice_bodies import random_body
from tests.foreign_decks.abaqus.parts import PartWriter
from tests.foreign_decks.abaqus.truth import Truth, difference
from tests.foreign_decks.abaqus.writing import Chunk, Pen
from tests.foreign_decks.abaqus_decks import Deck, DeckWriter

pytestmark = pytest.mark.robustness
DECKS = 100
TYPES = {"hexahedron": 8, "wedge": 6, "tetra": 4, "hexahedron20": 20, "wedge15": 15, "tetra10": 10}


class CalculixWriter(DeckWriter):
    """Writes decks without parts, local systems and generated nodes, with a step that prints all sets."""

    def deck(self) -> Deck:
        self.pen = Pen(self.rng, self.odd, calculix=True)
        body = random_body(self.rng, False, False)
        body.places = {point: place.round(6) for point, place in body.places.items()}  # CalculiX takes 20 characters a field
        scope = PartWriter(self.rng, self.pen, self.features, body, True)
        for step in (scope.all_nodes, scope.all_elements, scope.element_sets, scope.node_sets, scope.sections):
            step()
        self.scopes.append(scope)
        self._placed("", scope.content)
        self.chunks += [
            *scope.chunks,
            *(
                Chunk([head], data)
                for head, data in (("*MATERIAL, NAME=steel", []), ("*ELASTIC", ["210e9, 0.3"]), ("*DENSITY", ["7800."]))
            ),
            Chunk(["*BOUNDARY"], ["left, 1, 3"]),
            Chunk(["*STEP"]),
            Chunk(["*STATIC"]),
            *(Chunk([f"*NODE PRINT, NSET={name}"], ["U"]) for name in scope.content.sets["NSET"]),
            *(Chunk([f"*EL PRINT, ELSET={name}"], ["EVOL"]) for name in scope.content.sets["ELSET"]),
            Chunk(["*NODE FILE"], ["U"]),
            Chunk(["*END STEP"]),
        ]
        self._first_spellings()
        truth = Truth(self.placed, Counter(), scope.remarks, scope.exact, scope.body.volume)
        files = folded(self.rng, self.chunks, 0.0, self.features, plain=True)
        return Deck(files, truth, frozenset(), self.features, self.chunks, False, True, [])


@pytest.mark.parametrize("seed", range(DECKS))
def test_calculix_sees_what_the_deck_holds_by_construction(seed, tmp_path):
    if shutil.which("ccx") is None:
        pytest.skip("CalculiX (ccx) is not installed")
    deck = CalculixWriter(seed).deck()
    path = deck.written(tmp_path)
    assert difference(deck.truth, read_deck(path, frozenset())) == ""
    said = subprocess.run(["ccx", path.stem], cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert "Job finished" in said.stdout, said.stdout[-2000:]
    content = deck.truth.placed[0].content
    nodes, elements = _mesh(path.with_suffix(".frd"))
    used = {label for _, own in content.elements.values() for label in own}
    assert set(nodes) >= used
    for label in used:
        assert nodes[label] == pytest.approx(content.nodes[label], rel=1e-5, abs=1e-5)  # six digits are written
    assert elements == {label: frozenset(own) for label, (_, own) in content.elements.items()}
    sets, volumes = _printed(path.with_suffix(".dat"))
    for kind in ("NSET", "ELSET"):
        for label, members in content.sets[kind].items():
            there = used if kind == "NSET" else {*elements}
            assert sets[kind, label] & there == members & there  # CalculiX keeps numbers of a range that nobody has
    assert sum(volumes["EBODY"].values()) == pytest.approx(deck.truth.volume, rel=1e-5)


def _mesh(path: Path) -> tuple[dict[int, np.ndarray], dict[int, frozenset[int]]]:
    """Places of nodes, and the nodes of elements, of a results file of CalculiX."""
    nodes, elements, block, element = {}, {}, "", 0
    for line in path.read_text(errors="replace").splitlines():
        block = line[4:6].strip() if line.startswith(("    2C", "    3C")) else "" if line.startswith(" -3") else block
        if block == "2C" and line.startswith(" -1"):
            nodes[int(line[3:13])] = np.array([float(line[13 + 12 * k : 25 + 12 * k]) for k in range(3)])
        elif block == "3C" and line.startswith(" -1"):
            element = int(line[3:13])
            elements[element] = frozenset()
        elif block == "3C" and line.startswith(" -2"):
            elements[element] |= {int(line[k : k + 10]) for k in range(3, len(line.rstrip()), 10)}
    return nodes, elements


def _printed(path: Path) -> tuple[dict[tuple[str, str], set[int]], dict[str, dict[int, float]]]:
    """Members of every set that is printed, and volumes of the elements of element sets, which may be printed twice."""
    sets: dict[tuple[str, str], set[int]] = {}
    volumes: dict[str, dict[int, float]] = {}
    key = ("", "")
    for line in path.read_text(errors="replace").splitlines():
        if found := re.search(r"for set (\S+) and time", line):
            key = ("ELSET" if line.lstrip().startswith("volume") else "NSET", found[1])
            sets[key] = set()
        elif line.strip():
            fields = line.split()
            sets[key].add(int(fields[0]))
            if key[0] == "ELSET":
                volumes.setdefault(key[1], {})[int(fields[0])] = float(fields[1])
    return sets, volumes
