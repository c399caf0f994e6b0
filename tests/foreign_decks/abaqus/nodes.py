"""Writes the nodes of a body: given one by one, in local systems and cylindrical coordinates, or generated."""

from __future__ import annotations

from random import Random

import numpy as np
from scipy.spatial.transform import Rotation

from tests.foreign_decks.abaqus.lattice_bodies import Body, Cell, Point, random_rotation
from tests.foreign_decks.abaqus.scope import Scope
from tests.foreign_decks.abaqus.writing import Pen


class NodeWriter(Scope):
    """Writes the nodes of one body."""

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
        self.write(
            self.named("NFILL", [[self.pen.label("row0"), self.pen.label("row1"), str(n2), str(s2)]], "NSET", "layer0", layer),
            "*NFILL",
        )
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
