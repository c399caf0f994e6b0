"""What is written in one place of a deck, with the truth of it: sets, surfaces, reference nodes and masses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from random import Random

import numpy as np

from tests.foreign_decks.abaqus.truth import Concentrated, Content, Member
from tests.foreign_decks.abaqus.writing import Chunk, Pen

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

    def named(
        self,
        keyword: str,
        rows: Sequence[Sequence[str]],
        kind: str,
        name: str,
        members: Iterable[Member],
        *flags: str,
        **more: object,
    ) -> Chunk:
        """A chunk that adds members to a set, by a parameter called as the kind."""
        into = self.into(kind, name, members)
        chunk = self.pen.chunk(keyword, rows, *flags, **{kind: into[2]}, **more)
        chunk.names.append(into)
        return chunk

    def set_chunk(
        self, kind: str, name: str, members: Iterable[Member], rows: Sequence[Sequence[str]], *flags: str, **more: object
    ) -> Chunk:
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
        self.write(
            self.named("NODE", rows, "NSET", "ref", [label]) if self.rng.random() < 0.3 else self.pen.chunk("NODE", rows),
            "reference node",
        )
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
