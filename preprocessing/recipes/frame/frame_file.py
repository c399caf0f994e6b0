"""The file frame.toml: straight spatial beams between named nodes, checked key by key."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from preprocessing.recipes.frame.frame_tables import NAMED, BeamTable, FrameMaterial, FramePoint, FrameSection, Triple
from preprocessing.recipes.tables import BasisTable, Damping, InterfaceName, Table

ALONG = 1e-6
"""Sine of the angle between a beam and the orientation of its section below which it says nothing."""
MOST_ELEMENTS = 500
"""Of the whole frame, whose matrices are dense in the reduction."""


class FrameFile(Table):
    """Schema of frame.toml; all numbers in the units of the named system."""

    units: Literal["mm-t-s", "m-kg-s"]
    nodes: dict[NAMED, Triple]  # name -> x, y, z
    beams: Annotated[list[BeamTable], Field(min_length=1)]
    sections: dict[NAMED, FrameSection]
    materials: dict[NAMED, FrameMaterial]
    damping: Damping = Damping()
    clamp: Annotated[list[str], Field(min_length=1)] | None = None  # names of the nodes that the body's frame is tied to
    interface_points: dict[InterfaceName, FramePoint] = Field(default_factory=dict)
    basis: BasisTable = BasisTable()

    @model_validator(mode="after")
    def _can_be_meant(self) -> FrameFile:
        for complaints in (self._unknown(), self._shapeless(), self._loose(), self._unheld()):
            if complaint := next(complaints, ""):
                raise ValueError(complaint)
        return self

    def _unknown(self) -> Iterator[str]:
        """Names that do not exist."""
        used = [
            (f"beams.{k}.{key}", name, "node")
            for k, b in enumerate(self.beams)
            for key, name in (("from", b.start), ("to", b.end))
        ]
        used += [(f"beams.{k}.section", beam.section, "section") for k, beam in enumerate(self.beams)]
        used += [(f"sections.{name}.material", section.material, "material") for name, section in self.sections.items()]
        used += [("clamp", name, "node") for name in self.clamp or []]
        used += [(f"interface_points.{name}.node", point.node, "node") for name, point in self.interface_points.items()]
        for key, name, kind in used:
            existing = getattr(self, f"{kind}s")
            if name not in existing:
                yield f"{key}: there is no {kind} {name!r}; there are {', '.join(existing) or 'none'}"

    def _shapeless(self) -> Iterator[str]:
        """Beams without a length or with an orientation along them."""
        size = max(np.linalg.norm(np.ptp(list(self.nodes.values()), axis=0)), np.finfo(float).tiny)
        for k, beam in enumerate(self.beams):
            along = np.subtract(self.nodes[beam.end], self.nodes[beam.start])
            length = np.linalg.norm(along)
            if length <= 1e-9 * size:
                yield f"beams.{k}: its ends {beam.start} and {beam.end} are at one place; a beam needs a length"
            if beam.orientation is not None:
                sine = np.linalg.norm(np.cross(along, beam.orientation))
                if sine <= ALONG * length * np.linalg.norm(beam.orientation):
                    yield f"beams.{k}.orientation: {beam.orientation} is zero or runs along the beam; give a direction across it"
        if sum(beam.elements for beam in self.beams) > MOST_ELEMENTS:
            yield f"beams: all together have more than {MOST_ELEMENTS} elements; give them fewer"

    def _loose(self) -> Iterator[str]:
        """Nodes that no beams connect with the others."""
        reached = {self.beams[0].start}
        for _ in self.beams:
            for beam in self.beams:
                reached |= {beam.start, beam.end} if reached & {beam.start, beam.end} else set()
        if lost := [name for name in self.nodes if name not in reached]:
            yield f"nodes: no beams lead from {self.beams[0].start} to {', '.join(lost)}; connect them, or leave them out"
        if unused := set(self.sections) - {beam.section for beam in self.beams}:
            yield f"sections.{min(unused)}: no beam has this section; leave it out"
        if unused := set(self.materials) - {section.material for section in self.sections.values()}:
            yield f"materials.{min(unused)}: no section is made of this material; leave it out"

    def _unheld(self) -> Iterator[str]:
        if complaint := self.basis.complaint("a frame", self.clamp is not None, "clamp", self.interface_points):
            yield complaint
