"""Random valid decks of Abaqus and CalculiX whose content is known by construction, in any dress that the reader calls readable.

    python -m tests.foreign_decks.abaqus_decks --seeds 0:20000

reads so many of them, and says which are read wrong or refused.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from random import Random

import numpy as np
from scipy.spatial.transform import Rotation

from preprocessing.foreign_files.abaqus.reader import read_deck
from tests.foreign_decks.abaqus.files import Folded, folded
from tests.foreign_decks.abaqus.lattice_bodies import random_body, random_rotation
from tests.foreign_decks.abaqus.parts import PartWriter
from tests.foreign_decks.abaqus.scope import Scope
from tests.foreign_decks.abaqus.truth import Content, Member, Placed, Truth, difference
from tests.foreign_decks.abaqus.writing import HEADINGS, Chunk, Pen
from toolkit.foundation.errors import InputError

MATERIALS = (
    ("MATERIAL", {"NAME": "steel"}, []),
    ("ELASTIC", {}, [["210e9", "0.3"]]),
    ("DENSITY", {}, [["7800."]]),
    ("AMPLITUDE", {"NAME": "ramp"}, [["0.", "0.", "1.", "1."]]),
    ("ORIENTATION", {"NAME": "ori"}, [["1.", "0.", "0.", "0.", "1.", "0."], ["3", "0."]]),
    ("BOUNDARY", {}, [["left", "1", "3"]]),
    ("INITIAL CONDITIONS", {"TYPE": "TEMPERATURE"}, [["left", "20."]]),
    ("PHYSICAL CONSTANTS", {"ABSOLUTE_ZERO": "-273.15"}, []),
)
STEP = (
    ("STEP", {}, []),
    ("STATIC", {}, [["0.1", "1.0"]]),
    ("CLOAD", {}, [["Right", "3", "-1."]]),
    ("DLOAD", {}, [["half", "GRAV", "9.81", "0.", "0.", "-1."]]),
    ("NODE FILE", {}, [["U", "RF"]]),
    ("EL PRINT", {"ELSET": "half"}, [["EVOL"]]),
    ("OUTPUT", {"FIELD": None}, []),
    ("ELEMENT OUTPUT", {"DIRECTIONS": "YES"}, [["S", "E"]]),
    ("END STEP", {}, []),
)
CARRIERS = {
    "S4R": (4, "SHELL SECTION", [["0.1"]]),
    "S3": (3, "SHELL SECTION", [["0.1"]]),
    "B31": (2, "BEAM SECTION", [["0.1", "0.2"], ["0.", "0.", "1."]]),
    "T3D2": (2, "SOLID SECTION", [["0.01"]]),
    "SPRINGA": (2, "SPRING", [[""], ["1000."]]),
    "CONN3D2": (2, "CONNECTOR SECTION", [["BEAM"]]),
    "M3D4": (4, "MEMBRANE SECTION", [["0.1"]]),
}
"""Type of elements that carry mass or stiffness beside solids -> number of nodes, keyword of its section and data lines of that."""


@dataclass
class Deck:
    """A deck and what it holds."""

    files: Folded
    truth: Truth
    leave_out: frozenset[str]
    features: set[str]
    chunks: list[Chunk]  # before they were put into files
    odd: bool
    solid: bool  # whether it is of space
    some_nodes: list[int]  # numbers of nodes of its last part, in an order of chance

    def written(self, folder: Path) -> Path:
        """Write all files into a folder; the deck itself."""
        for name, content in self.files.contents.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        return folder / self.files.main


class DeckWriter:
    """Writes one deck from a seed."""

    def __init__(self, seed: int) -> None:
        self.rng = Random(seed)
        self.odd = self.rng.choice([0.0, 0.5, 1.0])
        self.pen = Pen(self.rng, self.odd)
        self.features: set[str] = set()
        self.chunks: list[Chunk] = []
        self.scopes: list[Scope] = []
        self.placed: list[Placed] = []
        self.leave_out: set[str] = set()
        self.exact = True
        self.volume: float | None = None
        self.solid, self.some_nodes = True, list[int]()
        self.has_sections = self.rng.random() < 0.7

    def deck(self) -> Deck:
        """The deck."""
        if self.rng.random() < 0.6:
            self.chunks.append(Chunk(self.pen.head("HEADING"), self.rng.sample(HEADINGS, self.rng.randint(0, 3))))
        structure = self.rng.choice(
            [self.flat, self.flat, self.one_part, self.one_instance, self.within_instance, self.twice, self.two_parts]
        )
        self.features.add(structure.__name__)
        structure()
        self.others(STEP if self.rng.random() < 0.7 else ())
        self._first_spellings()
        left_out, remarks = Counter[str](), list[str]()
        for scope in self.scopes:
            left_out += scope.left_out
            remarks += scope.remarks
        exact = self.exact and all(scope.exact for scope in self.scopes)
        truth = Truth(self.placed, left_out, remarks, exact, self.volume)
        files = folded(self.rng, self.chunks, self.odd, self.features)
        return Deck(
            files, truth, frozenset(self.leave_out), self.features, self.chunks, bool(self.odd), self.solid, self.some_nodes
        )

    def others(self, keywords: tuple[tuple[str, dict[str, str | None], list[list[str]]], ...]) -> None:
        """Materials, loads and steps, which say nothing of the body."""
        for keyword, parameters, rows in keywords:
            if keyword in ("STEP", "END STEP", "MATERIAL") or self.rng.random() < 0.7:
                flags = [name for name, value in parameters.items() if value is None]
                more = {name: value for name, value in parameters.items() if value is not None}
                self.chunks.append(self.pen.chunk(keyword, rows, *flags, **more))

    def _first_spellings(self) -> None:
        """Sets are told by the spelling of the line that names them first."""
        for chunk in self.chunks:
            for scope in self.scopes:
                for kind, label, spelled in chunk.names if chunk in scope.chunks else ():
                    scope.content.spelled.setdefault((kind, label), spelled.strip('"'))

    def body(self, plane: float = 0.2) -> PartWriter:
        """A body with its sets, in a scope of its own; of the plane in so many of all cases."""
        rng = self.rng
        scope = PartWriter(
            rng, self.pen, self.features, random_body(rng, rng.random() < 0.25, rng.random() < plane), self.has_sections
        )
        scope.all_nodes()
        scope.all_elements()
        scope.element_sets()
        scope.node_sets()
        scope.surfaces()
        if rng.random() < 0.4:
            scope.names_only(self.leave_out)
        scope.sections()
        if rng.random() < 0.3:
            scope.masses()
        if rng.random() < 0.2 and not scope.body.plane and self.has_sections:
            self._carriers(scope)
        if rng.random() < 0.15:
            scope.write(self.pen.chunk("EQUATION", [["2"], ["1", "1", "1.", "2", "1", "-1."]]), "*EQUATION")
            scope.left_out["EQUATION"] += 1
        self._reordered(scope)
        self.volume, self.solid = scope.body.volume, not scope.body.plane
        self.some_nodes = self.rng.sample([*scope.label.values()], len(scope.label))
        self.scopes.append(scope)
        return scope

    def _reordered(self, scope: Scope) -> None:
        """Sets by numbers alone may stand ahead of what they name."""
        for chunk in [each for each in scope.chunks if self.pen.maybe(0.1) and is_plain_set(each)]:
            if not used_by_others(chunk, scope.chunks):
                scope.chunks.remove(chunk)
                scope.chunks.insert(self.rng.randint(0, 1), chunk)
                self.features.add("a set ahead of its members")

    def _carriers(self, scope: PartWriter) -> None:
        """Elements that carry mass or stiffness and are left out on purpose."""
        told = {name for each in (scope, *self.scopes) for name in each.left_out}
        name = self.rng.choice([each for each in CARRIERS if each not in told])
        count, keyword, rows = CARRIERS[name]
        labels, first = [*scope.label.values()], scope.free(2)
        lines = [[str(first + k), *map(str, self.rng.sample(labels, count))] for k in range(self.rng.randint(1, 2))]
        into = scope.into("ELSET", "left_out", [first + k for k in range(len(lines))])
        chunk = self.pen.chunk("ELEMENT", lines, TYPE=name, ELSET=into[2])
        chunk.names.append(into)
        scope.write(chunk, f"left out: {name}")
        scope.write(self.pen.chunk(keyword, rows, ELSET="left_out"))
        scope.left_out[name] += len(lines)
        self.leave_out.add(name)

    def flat(self) -> None:
        """A deck without parts."""
        scope = self.body()
        self.others(MATERIALS)
        self._placed("", scope.content)
        self.chunks += scope.chunks

    def part(self, name: str, plane: float = 0.2) -> PartWriter:
        """*PART to *END PART."""
        scope = self.body(plane)
        self.chunks += [self.pen.chunk("PART", NAME=name), *scope.chunks, self.pen.chunk("END PART")]
        return scope

    def one_part(self) -> None:
        """A part without an assembly."""
        self._placed("", self.part("bar").content)
        self.others(MATERIALS)

    def _placed(self, name: str, content: Content, rotation: np.ndarray | None = None, shift: np.ndarray | None = None) -> None:
        self.placed.append(
            Placed(name, content, np.eye(3) if rotation is None else rotation, np.zeros(3) if shift is None else shift)
        )

    def one_instance(self) -> None:
        """A part that an assembly puts somewhere."""
        scope = self.part("bar")
        self.assembly([("bar-1", "bar", scope, [])])

    def within_instance(self) -> None:
        """An instance that holds all there is, of a part that is empty."""
        self.chunks += [self.pen.chunk("PART", NAME="bar"), self.pen.chunk("END PART")]
        scope = self.body()
        self.assembly([("bar-1", "bar", scope, scope.chunks)])

    def twice(self) -> None:
        """A part that stands at two places."""
        scope = self.part("bar")
        self.assembly([("bar-1", "bar", scope, []), ('"second one"', "bar", scope, [])])

    def two_parts(self) -> None:
        """Two parts whose numbers and names are alike."""
        first, second = self.part("bar", 0.0), self.part("plate", 0.0)
        self.volume = None
        self.assembly([("bar-1", "bar", first, []), ("PLATE-1", "plate", second, [])])

    def assembly(self, instances: list[tuple[str, str, PartWriter, list[Chunk]]]) -> None:
        """*ASSEMBLY to *END ASSEMBLY with instances, sets, and a reference node."""
        root = Scope(self.rng, self.pen, self.features)
        root.free_label = self.rng.choice([1, 5000])
        self._placed("", root.content)
        self.chunks.append(self.pen.chunk("ASSEMBLY", NAME="whole"))
        for k, (name, part, scope, own) in enumerate(instances):
            rotation, shift, rows = self._placement(k)
            self._placed(name.strip('"'), scope.content, rotation, shift)
            self.chunks += [
                self.pen.chunk("INSTANCE", rows, NAME=name, PART=self.pen.label(part)),
                *own,
                self.pen.chunk("END INSTANCE"),
            ]
        self.scopes.append(root)
        self._assembly_sets(root, [(name, scope) for name, _, scope, _ in instances])
        self.chunks += [*root.chunks, self.pen.chunk("END ASSEMBLY")]
        if len(instances) > 1:
            self._twice_told(instances)
        self.others(MATERIALS)

    def _twice_told(self, instances: list[tuple[str, str, PartWriter, list[Chunk]]]) -> None:
        """What a part leaves to its names is told of each instance."""
        if instances[0][2] is instances[1][2]:
            scope, ties = (
                instances[0][2],
                ("RIGID BODY", "COUPLING", "KINEMATIC", "DISTRIBUTING", "KINEMATIC COUPLING", "EQUATION"),
            )
            for name in [name for name in scope.left_out if name not in ties and name not in self.leave_out]:
                scope.left_out[name] *= 2

    def _placement(self, number: int) -> tuple[np.ndarray, np.ndarray, list[list[str]]]:
        """Rotation, shift and data lines of an instance; of the second one far from the first."""
        if number == 0 and self.rng.random() < 0.3:
            return np.eye(3), np.zeros(3), []
        self.exact = False
        moved = np.array([self.rng.uniform(-9, 9) + 100 * number, self.rng.choice([0.0, 1.5]), 0.0])
        rows = [self.pen.numbers(moved.tolist()) or ["0."]]
        if self.rng.random() < 0.4:
            self.features.add("*INSTANCE moved")
            return np.eye(3), moved, rows
        a, axis, degrees = (
            np.array([self.rng.uniform(-2, 2) for _ in range(3)]),
            random_rotation(self.rng)[:, 2],
            self.rng.choice([90.0, -30.0, 123.4]),
        )
        rows.append([repr(float(x)) for x in (*a, *(a + self.rng.uniform(0.5, 2.0) * axis), degrees)])
        turn = np.asarray(Rotation.from_rotvec(axis * np.deg2rad(degrees)).as_matrix())
        self.features.add("*INSTANCE turned")
        return turn, turn @ (moved - a) + a, rows

    def _assembly_sets(self, root: Scope, instances: list[tuple[str, PartWriter]]) -> None:
        """Sets of the assembly by INSTANCE=, by instance.number and by instance.set; a mass on a reference node."""
        name, scope = self.rng.choice(instances)
        key, spelled = name.strip('"'), self.pen.label(name)
        kind, everything = self.rng.choice([("NSET", [*scope.content.nodes]), ("ELSET", [*scope.cell_of])])
        members = self.rng.sample(everything, min(4, len(everything)))
        rows = root.listed([*map(str, members)])
        root.write(
            root.set_chunk(kind, "a-set", [(key, label) for label in members], rows, INSTANCE=spelled), "INSTANCE= of sets"
        )
        side = [(key, label) for label in scope.side(0, True)]
        root.write(root.set_chunk("NSET", "end", side, [[f"{spelled}.{self.pen.label('Right')}"]]), "instance.set")
        node = self.rng.choice([*scope.content.nodes])
        root.write(
            root.set_chunk("NSET", "some", [(key, node), *side], root.listed([f"{spelled}.{node}", "end"])), "instance.number"
        )
        if self.rng.random() < 0.5:
            self._assembly_surface(root, key, spelled, scope)
        if self.rng.random() < 0.4:
            place = next(each for each in self.placed if each.name == key)
            reference = root.reference_node(place.rotation @ scope.content.nodes[node] + place.shift)
            self._mass_of_assembly(root, reference, side)

    def _assembly_surface(self, root: Scope, key: str, spelled: str, scope: PartWriter) -> None:
        members = [(key, label) for label in scope.side(0, False)]
        root.surface("SURF-a", [("vertex", (member,)) for member in members], [[f"{spelled}.left"]], "NODE")
        self.features.add("*SURFACE of an instance's set")

    def _mass_of_assembly(self, root: Scope, node: int, side: list[Member]) -> None:
        """A reference node of the assembly that a rigid body ties to a side."""
        root.write(self.pen.chunk("RIGID BODY", (), REF_NODE=node, TIE_NSET=self.pen.label("end")), "*RIGID BODY of the assembly")
        root.left_out["RIGID BODY"] += 1
        root.concentrated(node, frozenset(side), True)


def is_plain_set(chunk: Chunk) -> bool:
    """Whether a chunk is a set by numbers alone."""
    keyword = chunk.head[0].strip(" *").split(",")[0].strip().upper()
    return (
        keyword in ("NSET", "ELSET")
        and bool(chunk.data)
        and not any(c.isalpha() or c == '"' for line in chunk.data for c in line)
    )


def used_by_others(chunk: Chunk, chunks: list[Chunk]) -> bool:
    """Whether a set that a chunk adds to is named by others, which take it as it is then."""
    labels = [label.upper() for _, label, _ in chunk.names]
    texts = [line.upper() for each in chunks if each is not chunk for line in each.lines]
    return any(label in text for label in labels for text in texts)


def random_deck(seed: int) -> Deck:
    """The deck of a seed."""
    return DeckWriter(seed).deck()


def wrong(seed: int, folder: Path) -> str:
    """What of the deck of a seed is read wrong, or why it is refused; empty if it is read right."""
    deck = random_deck(seed)
    try:
        return difference(deck.truth, read_deck(deck.written(folder), deck.leave_out))
    except InputError as error:
        return f"refused: {error}"


def main(arguments: list[str] | None = None) -> int:
    """Read decks of many seeds; the number of those that are read wrong or refused."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--seeds", default="0:20000", help="first:after the last")
    first, after = map(int, parser.parse_args(arguments).seeds.split(":"))
    bad, began = 0, time.process_time()
    for seed in range(first, after):
        with tempfile.TemporaryDirectory() as folder:
            if what := wrong(seed, Path(folder)):
                bad += 1
                print(f"seed {seed}: {what[:1000]}")
    print(f"{after - first} decks, {bad} of them wrong or refused, {time.process_time() - began:.0f} s")
    return bad


if __name__ == "__main__":
    sys.exit(bool(main()))
