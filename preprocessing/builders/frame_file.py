"""The file frame.toml, straight beams between named nodes, and all designs of the frame that it describes.

The parameters are named by what they are and what owns them: `youngs_modulus_steel`, `width_leg`, `x_A` of a node A, `length_B` and
`angle_B` of a node at a length and an angle from another, and `damping_mass` and `damping_stiffness` of the whole frame. By Poisson's
ratios and nodes there are derivatives, and by the dimensions of sections that shear deforms; by all others the matrices are polynomials.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial, reduce
from operator import getitem
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from preprocessing.builders.frame_tables import (
    AXES,
    DIMENSIONS,
    NAMED,
    POLAR,
    BeamTable,
    Coordinates,
    FrameMaterial,
    FramePoint,
    FrameSection,
    PolarNode,
    doubled,
    hanging_in_the_air,
    loose_contacts,
    positions,
)
from preprocessing.builders.tables import BasisTable, Damping, InputTable, InterfaceName, Keys
from preprocessing.elements.beams import BeamPatch, PlanarBeam, SpatialBeam
from preprocessing.elements.section import Patch, Sheared
from preprocessing.reduction.discretisation import DesignSpace, Discretisation

PARALLEL_SINE = 1e-6
"""Sine of the angle between a beam and the orientation of its section below which it says nothing."""
MOST_ELEMENTS = 500
"""Largest number of elements of a frame, whose matrices are dense in the reduction."""


class FrameFile(InputTable):
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
                if sine <= PARALLEL_SINE * length * np.linalg.norm(beam.orientation):
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


_MATERIAL = {"youngs_modulus": "stress", "density": "density", "poisson_ratio": "none"}
_DAMPING = {"mass": "rate", "stiffness": "time"}
_OF_NODES = ("nodes", "polar_nodes")
_ABOVE = np.array([0.0, 0.0, 1.0])


def places(file: FrameFile) -> dict[str, Keys]:
    """Keys in frame.toml that lead to each parameter."""
    found: dict[str, Keys] = {f"{key}_{name}": ("materials", name, key) for name in file.materials for key in _material(file)}
    found |= {f"{key}_{name}": ("sections", name, key) for name, each in file.sections.items() for key in DIMENSIONS[each.kind]}
    found |= {f"damping_{key}": ("damping", key) for key in _DAMPING}
    found |= {
        f"{axis}_{name}": ("nodes", name, number) for name in file.nodes for number, axis in enumerate(AXES[: file.dimension])
    }
    return found | {f"{key}_{name}": ("polar_nodes", name, key) for name in file.polar_nodes for key in POLAR}


def _material(file: FrameFile) -> dict[str, str]:
    """Constants of a material: beams in the plane do not twist, but shear may deform them."""
    return {key: quantity for key, quantity in _MATERIAL.items() if file.dimension == 3 or file.shear or key != "poisson_ratio"}


def quantities(file: FrameFile) -> dict[str, str]:
    """Physical quantity of each parameter, for its unit."""
    found = {name: {**_MATERIAL, **_DAMPING, **POLAR}.get(str(keys[-1]), "length") for name, keys in places(file).items()}
    return found | {f"{key}_{name}": what for name, each in file.sections.items() for key, what in DIMENSIONS[each.kind].items()}


def frame_space(file: FrameFile) -> DesignSpace:
    """Design space of the frame."""
    values = _values(file)
    tables = (*_OF_NODES, "sections") if file.shear else _OF_NODES
    by_steps = {name for name, (table, *rest) in places(file).items() if table in tables or rest[-1] == "poisson_ratio"}
    return DesignSpace(values, quantities(file), frozenset(values) - by_steps, partial(frame_elements, file))


def frame_elements(file: FrameFile, design: Mapping[str, complex]) -> Discretisation:
    """Finite elements at one design, which gives every parameter a value, real or complex."""
    beams = frame_beams(file, design)
    at_nodes = {name: node_number(file, point.node) for name, point in file.interface_points.items()}
    return Discretisation(beams, at_nodes=at_nodes)


def node_number(file: FrameFile, name: str) -> int:
    """Number of a named node among all nodes of the elements."""
    return list(file.places).index(name)


def frame_beams(file: FrameFile, design: Mapping[str, complex]) -> SpatialBeam | PlanarBeam:
    """Named nodes, then those between the ends of each beam; elements in the order of the beams."""
    places = positions(file.nodes, file.polar_nodes, design)
    names, corners = list(places), np.array(list(places.values()))
    nodes, connectivity, count = [corners], [], len(corners)
    for beam in file.beams:
        one, two = names.index(beam.start), names.index(beam.end)
        ratio = (np.arange(1, beam.elements) / beam.elements)[:, None]
        nodes.append(corners[one] + ratio * (corners[two] - corners[one]))
        chain = np.array([one, *range(count, count + beam.elements - 1), two])
        connectivity.append(np.column_stack([chain[:-1], chain[1:]]))
        count += beam.elements - 1
    mesh = np.vstack(nodes), np.vstack(connectivity)
    if file.dimension == 2:
        sheared = [_sheared(file, name, design) for name, _ in _sections(file)]
        known = [each for each in sheared if each is not None]
        return PlanarBeam(*mesh, [patch for _, patch in _sections(file)], 1.0, file.rotary_inertia, known)
    given = file.places
    directions = [_orientation(beam, given[beam.end] - given[beam.start]) for beam in file.beams]
    orientation = np.repeat(directions, [beam.elements for beam in file.beams], axis=0)
    return SpatialBeam(*mesh, orientation, _patches(file, design))


def _orientation(beam: BeamTable, along: np.ndarray) -> np.ndarray:
    """Orientation of a beam: as given, or else z; x of beams along z."""
    if beam.orientation is not None:
        return np.array(beam.orientation)
    return np.roll(_ABOVE, 1) if np.linalg.norm(np.cross(along, _ABOVE)) <= PARALLEL_SINE * np.linalg.norm(along) else _ABOVE


def _values(file: FrameFile) -> dict[str, float]:
    """Value of each parameter in the file."""
    content: Any = file.model_dump(by_alias=True)
    return {parameter: reduce(getitem, keys, content) for parameter, keys in places(file).items()}


def _patches(file: FrameFile, design: Mapping[str, complex]) -> list[BeamPatch]:
    """Patches of the elements of every section in space, which also twist."""
    found = []
    for name, patch in _sections(file):
        shear = 1 / (2 * (1 + design[f"poisson_ratio_{file.sections[name].material}"]))
        found.append(BeamPatch(patch, file.sections[name].shape, shear, sheared=_sheared(file, name, design)))
    return found


def _sheared(file: FrameFile, name: str, design: Mapping[str, complex]) -> Sheared | None:
    """Dimensions of a section as numbers, if shear deforms it."""
    section = file.sections[name]
    if not file.shear or section.kappa is None:
        return None
    flexibility = 2 * (1 + design[f"poisson_ratio_{section.material}"]) / section.kappa
    return Sheared({key: design[f"{key}_{name}"] for key in section.dimensions}, flexibility)


def _sections(file: FrameFile) -> Iterator[tuple[str, Patch]]:
    """Sections with their elements, and the parameters that they take their quantities from."""
    section_of = np.repeat([beam.section for beam in file.beams], [beam.elements for beam in file.beams])
    for name, section in file.sections.items():
        own = {key: f"{key}_{name}" for key in section.dimensions}
        own |= {key: f"{key}_{section.material}" for key in ("youngs_modulus", "density")}
        own |= {f"damping_{key}": f"damping_{key}" for key in _DAMPING}
        yield name, Patch(np.flatnonzero(section_of == name), own)
