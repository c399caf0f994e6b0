"""Writes a random body into a part of a deck, or into a deck without parts: nodes, elements, sets, surfaces and masses, with their truth."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from random import Random

import numpy as np
from scipy.spatial.transform import Rotation

from tests.foreign_decks.deck_truth import Concentrated, Content, Member
from tests.foreign_decks.deck_writing import Chunk, Pen
from tests.foreign_decks.lattice_bodies import Body, Cell, Point, random_rotation, sides, turned_about

TYPES = {
    "hexahedron": ("C3D8", "C3D8R", "C3D8I", "C3D8H", "C3D8RH"),
    "hexahedron20": ("C3D20", "C3D20R", "C3D20RH", "C3D20RI"),
    "tetra": ("C3D4", "C3D4H"),
    "tetra10": ("C3D10", "C3D10M", "C3D10HS", "C3D10I"),
    "wedge": ("C3D6", "C3D6H"),
    "wedge15": ("C3D15", "C3D15H"),
}
OF_CALCULIX = ("C3D8", "C3D8R", "C3D8I", "C3D20", "C3D20R", "C3D4", "C3D10", "C3D6", "C3D15")
PLANE_TYPES = {
    "triangle": ("CPS3", "CPE3", "S3", "S3R", "M3D3"),
    "quad": ("CPS4", "CPS4R", "CPE4", "CPE4R", "CPS4I", "S4", "S4R", "M3D4", "M3D4R"),
    "triangle6": ("CPS6", "CPE6", "CPS6M", "STRI65", "M3D6"),
    "quad8": ("CPS8", "CPS8R", "CPE8", "CPE8R", "S8R", "M3D8"),
}
FACE_TYPES = {
    "triangle": ("CPS3", "CPE3", "S3", "S3R", "M3D3", "SFM3D3"),
    "quad": ("CPS4", "CPE4", "S4", "S4R", "M3D4", "SFM3D4", "SFM3D4R"),
    "triangle6": ("CPS6", "CPE6", "STRI65", "M3D6"),
    "quad8": ("CPS8", "CPE8", "S8R", "S8R5", "M3D8"),
    "line": ("T3D2", "T2D2"),
    "line3": ("T3D3", "T2D3"),
}
SHAPES = {"quad": "CAX4P", "triangle": "R3D3", "line": "B31H", "line3": "B33H"}
NAMES = ("TopSide", "SET-1", "_Picked7", '"right end"', "D10", "Fix_x", "outer-half", "q", "EALL2", "nset", '"12"')
"""Names of sets, one of them like a parameter and one like a number."""


class Scope:
    """What is written between *PART and *END PART, *INSTANCE and *END INSTANCE, in the assembly, or in a deck without parts."""

    def __init__(self, rng: Random, pen: Pen, features: set[str]) -> None:
        self.rng, self.pen, self.features = rng, pen, features
        self.content = Content()
        self.chunks: list[Chunk] = []
        self.left_out = Counter[str]()
        self.remarks: list[str] = []
        self.exact = True
        self.free_label = 1
        self.names = [name for name in NAMES if not (pen.calculix and name.startswith('"'))]
        rng.shuffle(self.names)

    def new_name(self) -> str:
        """A name that no set has."""
        return self.names.pop() if self.names and self.rng.random() < 0.7 else f"Set{self.free()}"

    def free(self, count: int = 1) -> int:
        """The first of so many numbers that nothing has."""
        self.free_label += count
        return self.free_label - count

    def write(self, chunk: Chunk, *features: str) -> None:
        """Append a chunk."""
        self.chunks.append(chunk)
        self.features |= set(features)

    def into(self, kind: str, name: str, members: Iterable[Member]) -> tuple[str, str, str]:
        """Add members to a set; its kind, label and spelling for the chunk that names it."""
        label = name.strip('"') if name.startswith('"') else name.upper()
        self.content.sets[kind].setdefault(label, set()).update(members)
        spelled = self.pen.label(name)
        return kind, label, spelled

    def named(self, keyword: str, rows: Sequence[Sequence[str]], kind: str, name: str, members: Iterable[Member], *flags: str, **more: object) -> Chunk:  # fmt: skip
        """A chunk that adds members to a set, by a parameter called as the kind."""
        into = self.into(kind, name, members)
        chunk = self.pen.chunk(keyword, rows, *flags, **{kind: into[2]}, **more)
        chunk.names.append(into)
        return chunk

    def set_chunk(self, kind: str, name: str, members: Iterable[Member], rows: Sequence[Sequence[str]], *flags: str, **more: object) -> Chunk:  # fmt: skip
        """*NSET or *ELSET."""
        return self.named(kind, rows, kind, name, members, *flags, **more)

    def listed(self, members: Sequence[str]) -> list[list[str]]:
        """Members over several lines, some of them twice."""
        texts = [*members]
        if self.rng.random() < 0.1 and texts:
            texts.append(self.rng.choice(texts))
        width = self.rng.choice([1, 4, 8, 16])
        return [texts[k : k + width] for k in range(0, len(texts), width)]

    def surface(self, name: str, faces: list[tuple[str, tuple[Member, ...]]], rows: list[list[str]], of: str) -> None:
        """*SURFACE."""
        more = {} if of == "ELEMENT" and self.rng.random() < 0.3 else {"TYPE": self.pen.label(of)}
        self.write(self.pen.chunk("SURFACE", rows, NAME=name, **more), f"*SURFACE of {of}")
        self.content.surfaces[name.strip('"')] = faces

    def reference_node(self, near: np.ndarray) -> int:
        """A node that no element has."""
        label = self.free()
        self.content.nodes[label] = near + [self.rng.uniform(0.1, 0.9) for _ in range(3)]
        rows = [[str(label), *(repr(float(x)) for x in self.content.nodes[label])]]
        self.write(self.named("NODE", rows, "NSET", "ref", [label]) if self.rng.random() < 0.3 else self.pen.chunk("NODE", rows), "reference node")  # fmt: skip
        return label

    def concentrated(self, node: int, carriers: frozenset[Member], rigid: bool) -> None:
        """MASS and ROTARYI elements on a node, with their properties."""
        mass, zero = self.rng.choice([500.0, 2.5, 1.25e-3]), np.zeros((3, 3))
        label = self.free(2)
        self._concentrated("MASS", label, node, "MASS", [mass])
        self.content.masses.append(Concentrated(node, mass, zero, carriers, rigid))
        if self.rng.random() < 0.5:
            values = [round(self.rng.uniform(1, 3), 3) for _ in range(3)] + [
                round(self.rng.uniform(-0.3, 0.3), 3) for _ in range(3)
            ]
            values = values[: self.rng.choice([3, 6])]
            self._concentrated("ROTARYI", label + 1, node, "ROTARY INERTIA", values)
            xx, yy, zz, xy, xz, yz = [*values, 0, 0, 0][:6]
            tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            self.content.masses.append(Concentrated(node, 0.0, tensor, carriers, rigid))

    def _concentrated(self, name: str, label: int, node: int, keyword: str, values: list[float]) -> None:
        into = self.into("ELSET", f"e-{name}", [])
        chunk = self.pen.chunk("ELEMENT", [[str(label), str(node)]], TYPE=self.pen.label(name), ELSET=into[2])
        chunk.names.append(into)
        self.write(chunk)
        self.content.of_masses[label] = node
        self.content.sets["ELSET"][into[1]].add(label)
        self.write(
            self.pen.chunk(keyword, [[self.pen.number(x) for x in values]], ELSET=self.pen.label(f"e-{name}")), f"*{keyword}"
        )


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


class PartWriter(Scope):
    """Writes one body."""

    def __init__(self, rng: Random, pen: Pen, features: set[str], body: Body, has_sections: bool) -> None:
        super().__init__(rng, pen, features)
        self.body = body
        self.label = self._labels()
        self.free_label = max(self.label.values()) + 1000
        self.content.nodes = {self.label[p]: place for p, place in body.places.items()}
        self.system: tuple[np.ndarray, np.ndarray] | None = None
        self.cell_of: dict[int, Cell] = {}
        self.solid_sections: list[tuple[str, str]] = []  # keyword and ELSET
        self.has_sections = has_sections  # anywhere in the deck

    def _labels(self) -> dict[Point, int]:
        points, rng = [*self.body.places], self.rng
        if self.body.regular:
            n1, n2, _ = self.body.counts
            first, s1 = rng.choice([1, 7, 1001]), rng.choice([1, 2, 10])
            s2 = s1 * (n1 + 1) + rng.choice([0, 3])
            s3 = s2 * (n2 + 1) + rng.choice([0, 40])
            self.steps = (s1, s2, s3)
            return {p: first + sum(s * x // 2 for s, x in zip(self.steps, p, strict=True)) for p in points}
        largest = rng.choice([len(points), 3 * len(points), 10_000, 10_000 if self.pen.calculix else 900_000_000])
        labels = rng.sample(range(1, largest + 1), len(points))
        return dict(zip(points, sorted(labels) if rng.random() < 0.5 else labels, strict=True))

    def all_nodes(self) -> None:
        """Write the nodes, one way or another."""
        if self.body.regular:
            self._generated_nodes()
            return
        labels = [*self.content.nodes]
        if self.pen.odd:
            self.rng.shuffle(labels)
        count = self.rng.choice([1, 1, 2, 3])
        blocks = [labels[k::count] for k in range(count)]
        self.features |= {"several *NODE"} if count > 1 else set()
        if self.pen.maybe(0.3):
            self._wrong_nodes(self.rng.sample(labels, min(3, len(labels))))
        for block in blocks:
            self._system()
            self._node_block(block)
        self._no_system()

    def _wrong_nodes(self, labels: list[int]) -> None:
        """Nodes that are given again later, which counts."""
        rows = [[str(label), "77.5", "1.0", "-3.0"] for label in labels]
        self.write(self.pen.chunk("NODE", rows), "nodes given twice")
        self.remarks.append(f"{len(labels)} nodes of the deck are given more than once")

    def _node_block(self, labels: list[int]) -> None:
        rng, more = self.rng, {}
        cylindrical = not self.pen.calculix and self.pen.maybe(0.15)
        if cylindrical:
            more["SYSTEM"] = rng.choice(["C", "c"])
            self.features.add("SYSTEM=C")
        elif not self.pen.calculix and self.pen.maybe(0.1):
            more["SYSTEM"] = "R"
        rows = [self._node_row(label, cylindrical) for label in labels]
        if rng.random() < 0.4:
            chunk = self.named("NODE", rows, "NSET", rng.choice(["Nall", self.new_name()]), labels, **more)
            self.features.add("NSET on *NODE")
        else:
            chunk = self.pen.chunk("NODE", rows, **more)
        chunk.movable = True
        self.write(chunk)

    def _node_row(self, label: int, cylindrical: bool) -> list[str]:
        place = self.content.nodes[label]
        if self.system is not None:
            axes, origin = self.system
            place = axes.T @ (place - origin)
        if cylindrical:
            place = np.array([np.hypot(*place[:2]), np.rad2deg(np.arctan2(place[1], place[0])), place[2]])
            self.exact = False
        row = [str(label), *self.pen.numbers(place.tolist())]
        if len(row) == 4 and self.pen.maybe(0.02):
            row += ["0.0", "0.6", "-0.8"]  # a normal, of which solids know nothing
        return row

    def _system(self) -> None:
        """Begin a local system, end it, or go on with it."""
        if self.pen.calculix or not self.pen.maybe(0.25):
            return
        self.exact = False
        rng, axes, origin = self.rng, random_rotation(self.rng), np.array([self.rng.uniform(-3, 3) for _ in range(3)])
        form = rng.choice(["a", "ab", "abc", "abc"])
        self.features.add(f"*SYSTEM {form}")
        rows = [origin.tolist()]
        if form == "a":
            axes = np.eye(3)
        elif form == "ab":
            axes = np.asarray(Rotation.from_rotvec([0, 0, rng.uniform(-3, 3)]).as_matrix())
            rows[0] = [*origin, *(origin + rng.uniform(0.5, 2) * axes[:, 0] + [0, 0, rng.choice([0, 0.7])])]
        else:
            rows[0] = [*origin, *(origin + rng.uniform(0.5, 2) * axes[:, 0])]
            rows.append([*(origin + rng.uniform(-2, 2) * axes[:, 0] + rng.uniform(0.5, 2) * axes[:, 1])])
        self.write(self.pen.chunk("SYSTEM", [[repr(float(x)) for x in row] for row in rows]))
        self.system = (axes, origin)

    def _no_system(self) -> None:
        if self.system is not None:
            self.write(self.pen.chunk("SYSTEM"), "*SYSTEM ends")
            self.system = None

    def _at(self, i: int, j: int, k: int) -> int:
        return self.label[2 * i, 2 * j, 2 * k]

    def _plain_nodes(self, labels: list[int], name: str = "") -> None:
        rows = [[str(label), *self.pen.numbers(self.content.nodes[label].tolist())] for label in labels]
        self.write(self.named("NODE", rows, "NSET", name, labels) if name else self.pen.chunk("NODE", rows))

    def _generated_nodes(self) -> None:
        """Rows by *NGEN, a layer by *NFILL, further layers by *NCOPY, or by *NFILL up to the last one."""
        n1, n2, n3 = self.body.counts
        s1, s2, s3 = self.steps
        self.exact = False
        self._plain_nodes([self._at(i, j, 0) for i in (0, n1) for j in (0, n2)])
        for j, name in ((0, "row0"), (n2, "row1")):
            row = [self._at(i, j, 0) for i in range(n1 + 1)]
            line = [str(row[0]), str(row[-1]), *([str(s1)] if s1 != 1 or self.rng.random() < 0.5 else [])]
            self.write(self.named("NGEN", [line], "NSET", name, row), "*NGEN")
        layer = [self._at(i, j, 0) for i in range(n1 + 1) for j in range(n2 + 1)]
        self.write(self.named("NFILL", [[self.pen.label("row0"), self.pen.label("row1"), str(n2), str(s2)]], "NSET", "layer0", layer), "*NFILL")  # fmt: skip
        if not n3:
            return
        last = [self._at(i, j, n3) for i in range(n1 + 1) for j in range(n2 + 1)]
        every = [label for p, label in self.label.items()]
        if not self.body.degrees and self.rng.random() < 0.4:
            self._plain_nodes(last, "layer1")
            self.write(self.named("NFILL", [["layer0", "layer1", str(n3), str(s3)]], "NSET", "Nall", every))
        else:
            self._copied_layers([label for label in every if label not in layer], n3, s3)

    def _copied_layers(self, upper: list[int], times: int, step: int) -> None:
        body = self.body
        rows = [[repr(float(x)) for x in body.shift]]
        if body.degrees:
            rows.append(["0.", "0.", "0.", *(repr(float(x)) for x in body.axis), repr(body.degrees)])
            self.features.add("*NCOPY turned")
        more = {} if times == 1 and self.rng.random() < 0.5 else {"MULTIPLE": times}
        into = self.into("NSET", "upper", upper)
        chunk = self.pen.chunk(
            "NCOPY", rows, "SHIFT", CHANGE_NUMBER=step, OLD_SET=self.pen.label("layer0"), NEW_SET=into[2], **more
        )
        chunk.names.append(into)
        self.write(chunk, "*NCOPY")

    def all_elements(self) -> None:
        """Write the elements of the body, one way or another."""
        if self.body.regular:
            self._generated_elements()
            return
        cells = [*self.body.cells]
        first = self.rng.choice([1, 1, 500])
        labels = [*range(first, first + len(cells))]
        if self.rng.random() < 0.3:
            labels = self.rng.sample(range(1, 10_000 if self.pen.calculix else 900_000_000), len(cells))
            self.features.add("labels with gaps")
        self.free_label = max(self.free_label, *(label % 800_000_000 + 1000 for label in labels))
        self.cell_of = dict(zip(labels, cells, strict=True))
        if self.pen.maybe(0.3) and not self.pen.calculix:  # which takes no number twice
            self._wrong_elements()
        for kind in dict.fromkeys(cell.kind for cell in cells):
            mine = [label for label, cell in self.cell_of.items() if cell.kind == kind]
            count = self.rng.choice([1, 1, 2])
            for block in filter(None, (mine[k::count] for k in range(count))):
                self._element_block(kind, block)

    def type_of(self, kind: str) -> str:
        """A type of elements of the body."""
        names = (PLANE_TYPES if self.body.plane else TYPES)[kind]
        return self.rng.choice([name for name in names if not self.pen.calculix or name in OF_CALCULIX])

    def _wrong_elements(self) -> None:
        """Elements that are given again later, which counts."""
        labels = self.rng.sample([*self.cell_of], 1 + (len(self.cell_of) > 1))
        for label in labels:
            cell = self.rng.choice(self.body.cells)
            nodes = [str(self.label[p]) for p in reversed(turned_about(self.rng, cell).points)]
            self.write(self._of_rows(self.type_of(cell.kind), [[str(label), *nodes]]), "elements given twice")
        self.remarks.append(f"{len(labels)} elements of the deck are given more than once")

    def _of_rows(self, name: str, rows: Sequence[Sequence[str]], into: tuple[str, str, str] | None = None) -> Chunk:
        """*ELEMENT with its rows over any number of lines."""
        longest = self.rng.choice([8, 10, 16])
        lines = [line for row in rows for line in (self.pen.broken(row, longest) if self.pen.maybe(0.7) or len(row) > 16 else [", ".join(row)])]  # fmt: skip
        self.features |= {"elements over several lines"} if len(lines) > len(rows) else set()
        more = {"ELSET": into[2]} if into else {}
        chunk = self.pen.chunk("ELEMENT", [[line] for line in lines], TYPE=self.pen.label(name), **more)
        chunk.names += [into] if into else []
        chunk.movable = True
        return chunk

    def _element_block(self, kind: str, labels: list[int]) -> None:
        name, rng = self.type_of(kind), self.rng
        into = self.into("ELSET", rng.choice(["Eall", "bar", self.new_name()]), labels) if rng.random() < 0.6 else None
        self.features |= {"ELSET on *ELEMENT"} if into else set()
        more = 0
        if name == "C3D8I" and rng.random() < 0.4:  # CalculiX takes three nodes of incompatible modes
            more = 3
            self.features.add("C3D8I with 11 nodes")
        rows = []
        for label in labels:
            nodes = tuple(self.label[p] for p in self.cell_of[label].points)
            self.content.elements[label] = kind, nodes
            rows.append([str(label), *map(str, nodes), *(str(901 + k) for k in range(more))])
        self.write(self._of_rows(name, rows, into), f"type {kind}")
        self.told_of(name)

    def told_of(self, name: str) -> None:
        """Note a type of elements that the reader is to say something of."""
        if self.body.plane and name.startswith("CPE"):
            self.remarks.append("plane strain")
        elif self.body.plane and not name.startswith("C"):
            self.remarks.append("a plate that moves in its plane")

    def _generated_elements(self) -> None:
        """Masters, and the others by *ELGEN, or layers by *ELCOPY."""
        (n1, n2, n3), rng = self.body.counts, self.rng
        masters = [cell for cell in self.body.cells if all(max(p[a] for p in cell.points) == 2 * (self.body.counts[a] > 0) for a in range(3))]  # fmt: skip
        e1 = len(masters) * rng.choice([1, 2])
        e2, first = e1 * n1 + rng.choice([0, 5]), rng.choice([1, 300])
        e3 = e2 * n2 + rng.choice([0, 7])
        copied = n3 > 1 and rng.random() < 0.5
        base, rows = [], []
        for m, cell in enumerate(masters):
            name = self.type_of(cell.kind)
            self.write(self._of_rows(name, [[str(first + m), *(str(self.label[p]) for p in cell.points)]]), f"type {cell.kind}")
            self.told_of(name)
            counts = (n1, n2, 1 if copied or not n3 else n3)
            for i, j, k in ((i, j, k) for i in range(n1) for j in range(n2) for k in range(max(n3, 1))):
                label = first + m + i * e1 + j * e2 + k * e3
                moved = tuple((p[0] + 2 * i, p[1] + 2 * j, p[2] + 2 * k) for p in cell.points)
                self.content.elements[label] = cell.kind, tuple(self.label[p] for p in moved)
                self.cell_of[label] = Cell(cell.kind, moved)
                base += [label] if k < counts[2] else []
            row = [str(first + m)]
            for count, step, of_elements in zip(counts, self.steps, (e1, e2, e3), strict=True):
                row += [str(count), str(step), str(of_elements)]
            while len(row) > 4 and row[-3] == "1" and rng.random() < 0.7:
                row = row[:-3]
            rows.append(row)
        self.write(self.named("ELGEN", rows, "ELSET", "base", base), "*ELGEN")
        for k in range(1, n3 if copied else 1):
            into = self.into("ELSET", f"layer-{k}", [label + k * e3 for label in base])
            chunk = self.pen.chunk(
                "ELCOPY", (), OLD_SET="base", ELEMENT_SHIFT=k * e3, SHIFT_NODES=k * self.steps[2], NEW_SET=into[2]
            )
            chunk.names.append(into)
            self.write(chunk, "*ELCOPY")

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
        label = self.rng.choice(["HALF", *self.content.sets["ELSET"]])
        spelled = label if label in ("HALF",) or label.isupper() and " " not in label and label != "12" else f'"{label}"'
        if spelled.startswith('"') and spelled not in NAMES:
            return
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

    def names_only(self, left_out: set[str]) -> None:
        """Plane, shell, membrane and truss elements on the body, without a section, which only name faces and edges."""
        cells = [*self.cell_of.values()]
        faces = [face for cell in self.rng.sample(cells, min(len(cells), 2)) for _, face in sides(cell)]
        if not self.body.plane and self.rng.random() < 0.3:
            faces = [edge for face in faces for _, edge in sides(face)]
        face = self.rng.choice(faces)
        alike = {frozenset(each.points): each for each in faces if each.kind == face.kind}
        chosen = [*alike.values()][: self.rng.randint(1, 2)]
        name = self.rng.choice([each for each in FACE_TYPES[face.kind] if each not in left_out])
        if not self.has_sections and face.kind in SHAPES and self.rng.random() < 0.4:
            name = SHAPES[face.kind]
        first = self.free(len(chosen))
        labels, rows = [*range(first, first + len(chosen))], []
        for label, each in zip(labels, chosen, strict=True):
            nodes = tuple(self.label[p] for p in each.points)
            self.content.elements[label] = face.kind, nodes
            rows.append([str(label), *map(str, nodes)])
        self.write(self._of_rows(name, rows, self.into("ELSET", "face1", labels)), f"names only: {face.kind}")
        self.left_out[name] += len(chosen)

    def sections(self) -> None:
        """*SOLID SECTION, or that of shells and membranes of the plane."""
        if self.has_sections:
            mine = [*self.cell_of]
            self.write(self.set_chunk("ELSET", "Ebody", mine, self.listed([*map(str, mine)])))
            self.write(self.pen.chunk("SOLID SECTION", [["1.0"]][: self.rng.randint(0, 1)], ELSET=self.pen.label("Ebody"), MATERIAL="steel"), "*SOLID SECTION")  # fmt: skip

    def masses(self) -> None:
        """Concentrated masses on nodes of the body, or on one that moves with some of them."""
        node: int = self.rng.choice([*self.label.values()])
        carriers, rigid = frozenset[Member]([node]), True
        if self.rng.random() < 0.6:
            node = self.reference_node(self.content.nodes[node])
            carriers, rigid = self.tie(node)
        self.concentrated(node, carriers, rigid)

    def tie(self, node: int) -> tuple[frozenset[Member], bool]:
        """Tie a reference node to others: these, and whether they are rigid."""
        way = self.rng.choice(["RIGID BODY", "COUPLING", "KINEMATIC COUPLING"])
        members = self.content.sets["NSET"]["LEFT"]
        if way == "RIGID BODY":
            key = self.rng.choice(["NSET", "TIE_NSET", "PIN_NSET"])
            chunk = self.pen.chunk(way, (), REF_NODE=node, **{key: self.pen.label("left")})
        elif way == "KINEMATIC COUPLING":
            chunk = self.pen.chunk(way, [[self.pen.label("left"), "1", "6"]], REF_NODE=node)
        else:
            return self._coupling(node, members)
        self.left_out[way] += 1
        self.write(chunk, f"*{way}")
        return frozenset(members), True

    def _coupling(self, node: int, members: set[Member]) -> tuple[frozenset[Member], bool]:
        rigid = self.rng.random() < 0.5
        self.surface("coupled", [("vertex", (member,)) for member in members], [[self.pen.label("left")]], "NODE")
        self.left_out["COUPLING"] += 1
        self.left_out["KINEMATIC" if rigid else "DISTRIBUTING"] += 1
        self.write(self.pen.chunk("COUPLING", (), CONSTRAINT_NAME="c1", REF_NODE=node, SURFACE="coupled"))
        self.write(self.pen.chunk("KINEMATIC" if rigid else "DISTRIBUTING"), "*COUPLING rigid" if rigid else "*COUPLING mean")
        return frozenset(members), rigid
