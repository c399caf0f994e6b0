"""The file frame.toml: straight beams between named nodes, in the plane or in space, checked key by key."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from preprocessing.recipes.frame.frame_nodes import hanging_in_the_air, positions
from preprocessing.recipes.frame.frame_tables import (
    NAMED,
    BeamTable,
    Coordinates,
    FrameMaterial,
    FramePoint,
    FrameSection,
    PolarNode,
)
from preprocessing.recipes.frame.member_lines import doubled, loose_contacts
from preprocessing.recipes.tables import BasisTable, Damping, InterfaceName, Table

ALONG = 1e-6
"""Sine of the angle between a beam and the orientation of its section below which it says nothing."""
MOST_ELEMENTS = 500
"""Largest number of elements of a frame, whose matrices are dense in the reduction."""


class FrameFile(Table):
    """Schema of frame.toml; all numbers in the units of the named system."""

    units: Literal["mm-t-s", "m-kg-s"]
    dimension: Literal[2, 3] = 3  # of space
    rotary_inertia: bool = True  # of the sections; false, in the plane alone: their mass lies on the middle line
    shear: bool = False  # whether shear deforms the beams (Timoshenko), which their dimensions are then no polynomials of
    nodes: dict[NAMED, Coordinates]  # name -> x, y and, in space, z
    polar_nodes: dict[NAMED, PolarNode] = Field(default_factory=dict)  # in the plane, nodes at a length and an angle from others
    beams: Annotated[list[BeamTable], Field(min_length=1)]
    sections: dict[NAMED, FrameSection]
    materials: dict[NAMED, FrameMaterial]
    damping: Damping = Damping()
    clamp: Annotated[list[str], Field(min_length=1)] | None = None  # names of the nodes that the body's frame is tied to
    interface_points: dict[InterfaceName, FramePoint] = Field(default_factory=dict)
    basis: BasisTable = BasisTable()

    @model_validator(mode="after")
    def _can_be_meant(self) -> FrameFile:
        for complaints in (self._unknown(), self._misplaced(), self._shapeless(), self._doubled(), self._loose(), self._unheld()):
            if complaint := next(complaints, ""):
                raise ValueError(complaint)
        return self

    @property
    def places(self) -> dict[str, np.ndarray]:
        """Place (d,) of every node, by name."""
        return positions(self.nodes, self.polar_nodes)

    @property
    def warnings(self) -> list[str]:
        """Warnings of beams and nodes that touch without being connected, which may be intended or forgotten."""
        return loose_contacts(self.beams, self.places)

    def _unknown(self) -> Iterator[str]:
        """Complaints about names that do not exist."""
        used = [
            (f"beams.{k}.{key}", name, "node")
            for k, b in enumerate(self.beams)
            for key, name in (("from", b.start), ("to", b.end))
        ]
        used += [(f"beams.{k}.section", beam.section, "section") for k, beam in enumerate(self.beams)]
        used += [(f"sections.{name}.material", section.material, "material") for name, section in self.sections.items()]
        used += [("clamp", name, "node") for name in self.clamp or []]
        used += [(f"interface_points.{name}.node", point.node, "node") for name, point in self.interface_points.items()]
        used += [(f"polar_nodes.{name}.from", each.start, "node") for name, each in self.polar_nodes.items()]
        for key, name, kind in used:
            existing = [*self.nodes, *self.polar_nodes] if kind == "node" else getattr(self, f"{kind}s")
            if name not in existing:
                yield f"{key}: there is no {kind} {name!r}; there are {', '.join(existing) or 'none'}"

    def _misplaced(self) -> Iterator[str]:
        """Complaints about keys that belong to the plane or to space alone."""
        plane = self.dimension == 2
        for name, place in self.nodes.items():
            if len(place) != self.dimension:
                where = "in the plane" if plane else "in space"
                yield f"nodes.{name}: a frame {where} (dimension = {self.dimension}) has {self.dimension} coordinates (given: {place})"
        if self.polar_nodes and not plane:
            yield "polar_nodes: nodes at one angle lie in the plane; write dimension = 2, or give them coordinates in nodes"
        if not plane and not self.rotary_inertia:
            yield "rotary_inertia: beams in space (dimension = 3) have it, as they twist; leave the key out"
        if both := set(self.nodes) & set(self.polar_nodes):
            yield f"polar_nodes.{min(both)}: this node has coordinates in nodes already; leave it out of one of them"
        if lost := hanging_in_the_air(self.nodes, self.polar_nodes):
            yield f"polar_nodes: {', '.join(lost)} start from each other; let one of them start from a node with coordinates"
        for name, material in self.materials.items():
            if plane and not self.shear and material.poisson_ratio is not None:
                yield f"materials.{name}.poisson_ratio: beams in the plane (dimension = 2) do not twist; leave it out"
            if (self.shear or not plane) and material.poisson_ratio is None:
                why = "shear deforms the beams" if plane else "beams in space twist"
                yield f"materials.{name}.poisson_ratio: this key is missing; add it, because {why}"
        for name, section in self.sections.items():
            if plane and section.kind != "rectangle":
                yield f'sections.{name}: beams in the plane (dimension = 2) have sections of kind "rectangle" (given: {section.kind!r})'
        yield from self._shear_factors()
        for k, beam in enumerate(self.beams):
            if plane and beam.orientation is not None:
                yield f"beams.{k}.orientation: the thickness of a beam in the plane (dimension = 2) lies in the plane; leave it out"

    def _shear_factors(self) -> Iterator[str]:
        """Complaints about shear factors that are not needed, or that are missing."""
        for name, section in self.sections.items():
            if self.shear and section.kappa is None:
                yield f"sections.{name}.shear_factor: this key is missing; a {section.kind} has no factor that goes for all of them"
            if not self.shear and section.shear_factor is not None:
                yield f"sections.{name}.shear_factor: shear does not deform these beams; write shear = true, or leave the key out"

    def _shapeless(self) -> Iterator[str]:
        """Complaints about beams without a length or with an orientation along them."""
        places = self.places
        size = max(np.linalg.norm(np.ptp(list(places.values()), axis=0)), np.finfo(float).tiny)
        for k, beam in enumerate(self.beams):
            along = places[beam.end] - places[beam.start]
            length = np.linalg.norm(along)
            if length <= 1e-9 * size:
                yield f"beams.{k}: its ends {beam.start} and {beam.end} are at one place; a beam needs a length"
            if beam.orientation is not None:
                sine = np.linalg.norm(np.cross(along, beam.orientation))
                if sine <= ALONG * length * np.linalg.norm(beam.orientation):
                    yield f"beams.{k}.orientation: {beam.orientation} is zero or runs along the beam; give a direction across it"
        if sum(beam.elements for beam in self.beams) > MOST_ELEMENTS:
            yield f"beams: all together have more than {MOST_ELEMENTS} elements; give them fewer"

    def _doubled(self) -> Iterator[str]:
        """Complaints about beams that lie on each other."""
        yield from doubled(self.beams, self.places)

    def _loose(self) -> Iterator[str]:
        """Complaints about nodes that no beams connect with the others."""
        reached = {self.beams[0].start}
        for _ in self.beams:
            for beam in self.beams:
                reached |= {beam.start, beam.end} if reached & {beam.start, beam.end} else set()
        if lost := [name for name in [*self.nodes, *self.polar_nodes] if name not in reached]:
            touching = "".join(f" ({text.removesuffix('.')})" for text in self.warnings)
            yield f"nodes: no beams lead from {self.beams[0].start} to {', '.join(lost)}; connect them, or leave them out{touching}"
        if unused := set(self.sections) - {beam.section for beam in self.beams}:
            yield f"sections.{min(unused)}: no beam has this section; leave it out"
        if unused := set(self.materials) - {section.material for section in self.sections.values()}:
            yield f"materials.{min(unused)}: no section is made of this material; leave it out"

    def _unheld(self) -> Iterator[str]:
        if complaint := self.basis.complaint("a frame", self.clamp is not None, "clamp", self.interface_points):
            yield complaint
