"""Writes the elements of a body: given one by one over any lines, or generated; and those that only name its faces."""

from __future__ import annotations

from collections.abc import Sequence

from tests.foreign_decks.abaqus.lattice_bodies import Cell, sides, turned_about
from tests.foreign_decks.abaqus.nodes import NodeWriter
from tests.foreign_decks.abaqus.writing import Chunk

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


class ElementWriter(NodeWriter):
    """Writes the nodes and elements of one body."""

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
        lines = [
            line
            for row in rows
            for line in (self.pen.broken(row, longest) if self.pen.maybe(0.7) or len(row) > 16 else [", ".join(row)])
        ]
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
        masters = [
            cell
            for cell in self.body.cells
            if all(max(p[a] for p in cell.points) == 2 * (self.body.counts[a] > 0) for a in range(3))
        ]
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
