"""Writes a body into a part of a deck, or into a deck without parts, with sections, masses and what these move with."""

from __future__ import annotations

from tests.foreign_decks.abaqus.sets import SetWriter
from tests.foreign_decks.abaqus.truth import Member


class PartWriter(SetWriter):
    """Writes one body with all that belongs to it."""

    def sections(self) -> None:
        """*SOLID SECTION, or that of shells and membranes of the plane."""
        if self.has_sections:
            mine = [*self.cell_of]
            self.write(self.set_chunk("ELSET", "Ebody", mine, self.listed([*map(str, mine)])))
            self.write(
                self.pen.chunk(
                    "SOLID SECTION", [["1.0"]][: self.rng.randint(0, 1)], ELSET=self.pen.label("Ebody"), MATERIAL="steel"
                ),
                "*SOLID SECTION",
            )

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
