"""Writes the sets and surfaces of a body: by numbers, by ranges, by other sets, in one block or several."""

from __future__ import annotations

from collections.abc import Iterable
from random import Random

from tests.foreign_decks.abaqus.elements import ElementWriter
from tests.foreign_decks.abaqus.lattice_bodies import sides
from tests.foreign_decks.abaqus.scope import NAMES


class SetWriter(ElementWriter):
    """Writes one body with its sets and surfaces."""

    def side(self, axis: int, far: bool) -> list[int]:
        """The nodes on one side of the lattice."""
        level = 2 * self.body.counts[axis] * far
        return [label for p, label in self.label.items() if p[axis] == level]

    def node_sets(self) -> None:
        """Node sets: the sides, and what is chosen at random."""
        wanted = [("left", self.side(0, False)), ("Right", self.side(0, True))]
        for _ in range(self.rng.randint(0, 2)):
            wanted.append((self.new_name(), self.rng.sample([*self.content.nodes], self.rng.randint(1, len(self.content.nodes)))))
        for name, members in wanted:
            self.one_set("NSET", name, members, self.content.nodes)
        if self.rng.random() < 0.3 and not self.pen.calculix:
            self._nodes_of_elements()

    def element_sets(self) -> None:
        """Element sets: the half of the body, and what is chosen at random."""
        half = [label for label, cell in self.cell_of.items() if min(p[0] for p in cell.points) == 0]
        wanted = [("half", half)]
        if self.rng.random() < 0.5:
            wanted.append((self.new_name(), self.rng.sample([*self.cell_of], self.rng.randint(1, len(self.cell_of)))))
        for name, members in wanted:
            self.one_set("ELSET", name, members, self.content.elements)

    def one_set(self, kind: str, name: str, members: list[int], everything: Iterable[int]) -> None:
        """One set by numbers, ranges, sets, or several of them."""
        way = self.rng.choice(["listed", "generate", "blocks", "sets", "grows"])
        flags = [flag for flag, share in (("UNSORTED", 0.1), ("INTERNAL", 0.1)) if self.pen.maybe(share)]
        if way == "generate":
            rows = ranges(self.rng, members, everything, not self.pen.calculix)
            self.write(self.set_chunk(kind, name, members, rows, "GENERATE", *flags), f"{kind} GENERATE")
        elif way == "blocks":
            for part in filter(None, (members[::2], members[1::2])):
                rows = (
                    ranges(self.rng, part, everything, not self.pen.calculix)
                    if (ranged := self.rng.random() < 0.5)
                    else self.listed([*map(str, part)])
                )
                self.write(self.set_chunk(kind, name, part, rows, *(["GENERATE"] if ranged else [])), f"{kind} in blocks")
        elif way in ("sets", "grows"):
            self._set_of_sets(kind, name, members, way == "grows")
        else:
            self.write(self.set_chunk(kind, name, members, self.listed([*map(str, members)]), *flags), f"{kind} listed")

    def _set_of_sets(self, kind: str, name: str, members: list[int], grows: bool) -> None:
        """A set that names others; what these get afterwards is not part of it."""
        parts = [part for part in (members[::3], members[1::3]) if part]
        names = [self.new_name() for _ in parts]
        for each, part in zip(names, parts, strict=True):
            self.write(self.set_chunk(kind, each, part, self.listed([*map(str, part)])))
        inside = {member for each in parts for member in each}
        held = {
            member
            for each in names
            for member in self.content.sets[kind][each.strip('"') if each.startswith('"') else each.upper()]
        }
        texts = [*(self.pen.label(each) for each in names), *(str(member) for member in members[2::3])]
        self.rng.shuffle(texts)
        self.write(self.set_chunk(kind, name, held | {*members}, self.listed(texts)), f"{kind} of sets")
        if grows and inside:
            more = [*(self.content.nodes if kind == "NSET" else self.content.elements)][:2]
            self.write(self.set_chunk(kind, names[0], more, self.listed([*map(str, more)])), f"{kind} that grows afterwards")

    def _nodes_of_elements(self) -> None:
        """*NSET, ELSET=, of a set of elements that does not change any more."""
        quoted = [name for name in NAMES if name.startswith('"')]
        spellings = {
            name.strip('"') if name in quoted else name.upper(): name for name in (*NAMES, "half", "Eall", "bar", "base")
        }
        label = self.rng.choice([label for label in self.content.sets["ELSET"] if label in spellings])
        spelled = spellings[label]
        elements = [self.content.elements[each] for each in self.content.sets["ELSET"][label] if isinstance(each, int)]
        nodes = [node for _, own in elements for node in own]
        self.write(self.set_chunk("NSET", self.new_name(), nodes, (), ELSET=self.pen.label(spelled)), "*NSET, ELSET=")

    def surfaces(self) -> None:
        """Surfaces of faces by elements and element sets, and of nodes."""
        if self.rng.random() < 0.5:
            self._surface_of_nodes()
        if self.rng.random() < 0.7:
            self._surface_of_faces()

    def _surface_of_nodes(self) -> None:
        rows, faces = [], []
        if self.rng.random() < 0.6:
            rows.append([self.pen.label("left")])
            faces += [("vertex", (label,)) for label in self.content.sets["NSET"]["LEFT"]]
        for label in self.rng.sample([*self.content.nodes], 1 + (not rows)):
            rows.append([str(label)])
            faces.append(("vertex", (label,)))
        if self.rng.random() < 0.3:
            rows = [[*row, "1.0"] for row in rows]
            self.features.add("*SURFACE of nodes with areas")
        self.surface("SURF-n", faces, rows, "NODE")

    def _surface_of_faces(self) -> None:
        labels = self.rng.sample([*self.cell_of], min(len(self.cell_of), 2))
        rows, faces = [], []
        for label in labels:
            number, face = self.rng.choice([*sides(self.cell_of[label])])
            kind, nodes = face.kind, tuple(self.label[p] for p in face.points)
            faces.append((kind, nodes))
            rows.append([str(label), self.rng.choice([f"S{number}", f"s{number}"])])
        if self.rng.random() < 0.6 and self.content.sets["ELSET"]:
            number = self.rng.randint(1, 3)
            for each in self.content.sets["ELSET"]["HALF"]:
                face = next(own for k, own in sides(self.cell_of[int(str(each))]) if k == number)
                faces.append((face.kind, tuple(self.label[p] for p in face.points)))
            rows.append([self.pen.label("half"), f"S{number}"])
            self.features.add("*SURFACE of an element set")
        self.surface(self.rng.choice(["SURF-e", '"a surface"']), faces, rows, "ELEMENT")


def ranges(rng: Random, members: Iterable[int], others: Iterable[int], alone: bool) -> list[list[str]]:
    """Lines of GENERATE that have the members and none of the others; numbers that nobody has may be in a range.

    A number that stands alone ends CalculiX 2.20 or keeps it for ever.
    """
    wanted, avoided, found = sorted(members), set(others) - set(members), []
    while wanted:
        first = wanted[0]
        step = wanted[1] - first if len(wanted) > 1 and rng.random() < 0.8 else 1
        last = first
        inside = {first}
        while (bigger := [each for each in wanted if each > last]) and (bigger[0] - first) % step == 0:
            between = range(last + step, bigger[0], step)
            if len(between) > 1000 or any(each in avoided for each in between):
                break
            last = bigger[0]
            inside.add(last)
        wanted = [each for each in wanted if each not in inside]
        if first == last:
            found.append([str(first)] if alone and rng.random() < 0.5 else [str(first), str(first), "1"])
        else:
            found.append([str(first), str(last), *([str(step)] if step != 1 or rng.random() < 0.5 else [""] * rng.randint(0, 1))])
    rng.shuffle(found)
    return found
