"""From frame.toml, or from any polygon, to the reduced model of a body of beams."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterator, Mapping
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from preprocessing.builders.curve_mesh import CurveMesh
from preprocessing.builders.frame_file import FrameFile, frame_beams, frame_space, node_number, places
from preprocessing.builders.recipe import WRITER_VERSION, Recipe, Remark, Seal
from preprocessing.builders.tables import Keys
from preprocessing.elements.beams import PlanarBeam, SpatialBeam
from preprocessing.elements.section import Section, distribute
from preprocessing.reduction.basis import BasisChoice
from preprocessing.reduction.discretisation import DesignSpace, Discretisation
from preprocessing.reduction.pictured_parts import with_fibres
from preprocessing.reduction.reduced import ELEMENT_PARTS, SECTIONS, reduce
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.model import Mesh, ReducedModel


class FrameRecipe(Recipe[FrameFile, DesignSpace]):
    """Recipe of a frame of beams."""

    name = "frame.toml"
    schema = FrameFile
    seal = Seal("frame, ", lengths_of_files=False)

    @classmethod
    def means(cls, content: Mapping[str, object]) -> bool:
        return "beams" in content or "nodes" in content

    @property
    def parts(self) -> tuple[str, ...]:
        picture = "mesh" if self.file.dimension == 2 else "surface"
        basis = self.file.basis
        own = ELEMENT_PARTS + SECTIONS + basis.parts + basis.richer_parts
        return ("invariants", "derivatives", "affine", "interfaces", "stress", picture, *own)

    @property
    def warnings(self) -> list[str]:
        return [f"{self.path.name}: {text}" for text in self.file.warnings]

    def _named(self) -> list[Path]:
        return []

    def _hash_mark(self) -> str:
        return "rotary inertia, " if self.file.dimension == 2 and self.file.rotary_inertia else ""

    def _places(self) -> dict[str, Keys]:
        return places(self.file)

    def _designs(self, remark: Remark | None) -> DesignSpace:
        if remark is not None:
            for text in self.warnings:
                remark(text)
        return frame_space(self.file)

    def _model(self, designs: DesignSpace) -> ReducedModel:
        file, clamp = self.file, self.file.clamp or []
        clamped = [node_number(file, node) for node in clamp]
        found = reduce(
            designs, file.basis.choice(), clamped, ("the node " if len(clamp) == 1 else "the nodes ") + ", ".join(clamp)
        )
        model, beams = found.model(file.units), frame_beams(file, designs.values)
        if isinstance(beams, SpatialBeam):
            return with_fibres(model, found, beams)
        return replace(model, mesh=Mesh(beams.nodes, beams.connectivity, found.basis.z, outline(file), np.zeros((0, 2))))


def outline(file: FrameFile) -> np.ndarray:
    """Line (n, d) along all beams, there and back where they branch."""
    places, left = file.places, list(file.beams)

    def walk(name: str) -> Iterator[np.ndarray]:
        yield places[name]
        while at := [beam for beam in left if name in (beam.start, beam.end)]:
            left.remove(at[0])
            yield from walk(at[0].end if at[0].start == name else at[0].start)
            yield places[name]

    return np.array(list(walk(file.beams[0].start)))


FULL = BasisChoice("full")


LATER = ("chord", "spin_stiffening", "beside_frozen")
"""Choices that the first models did not have: where they are not made the hash is theirs."""


def polygon_beam(
    nodes: np.ndarray,
    section: Section,
    interfaces: Mapping[str, float],
    units: str = "m-kg-s",
    separate: Collection[str] = (),
    basis: BasisChoice = FULL,
    rotary_inertia: bool = True,
) -> ReducedModel:
    """Beam along a polygon, one Euler-Bernoulli element per side.

    Its frame is tied to the first node or, by the basis, to a chord.

    Parameters
    ----------
    nodes : (n_nodes, 2) corners of the polygon in the body's frame
    section : modulus, density, thickness in the plane, width across it and Rayleigh damping, in the named system of units
    interfaces : name -> arc length along the polygon where joints and loads may grip
    units : "m-kg-s" or "mm-t-s"
    separate : quantities of the section that every element has of its own, for example ("thickness",)
    basis : what the elastic coordinates are; all nodal coordinates by default
    rotary_inertia : of the section, m t^2 / 12; without it the mass lies on the middle line

    Raises
    ------
    InputError
        A quantity of the section that is not positive, fewer than two nodes, two neighbours at one place, an interface point off the beam,
        unknown units, or an impossible basis.
    """
    for name, value in asdict(section).items():
        if not np.all(np.real(value) >= 0) or (not name.startswith("damping") and not np.all(np.real(value) > 0)):
            raise InputError(f"{name} = {value} of the section must be {'zero or ' * name.startswith('damping')}positive.")
    nodes = np.asarray(nodes, float)
    mesh, arc_lengths = _mesh(nodes)
    parameters = distribute(asdict(section), {}, separate, len(mesh.connectivity))
    beams = PlanarBeam(mesh.nodes, mesh.connectivity, parameters.patches, rotary_inertia=rotary_inertia)
    discrete = Discretisation(beams, interfaces, arc_lengths)
    space = DesignSpace(parameters.values, parameters.quantities, frozenset(parameters.values), lambda _: discrete)
    found = reduce(space, basis, 0, "the first node")
    chosen = {key: value for key, value in asdict(basis).items() if key not in LATER or value}
    inputs = repr((nodes.tolist(), asdict(section), dict(interfaces), units, sorted(separate), chosen, WRITER_VERSION))
    inputs += ", rotary inertia" if rotary_inertia else ""  # models of files that had no such key keep their hash
    return replace(
        found.model(units),
        input_hash=hashlib.sha256(inputs.encode()).hexdigest(),
        writers={"ffrf-toolkit": WRITER_VERSION, "numpy": np.__version__},
        mesh=Mesh(nodes, mesh.connectivity, found.basis.z, nodes, np.zeros((0, 2))),
    )


def _mesh(nodes: np.ndarray) -> tuple[CurveMesh, np.ndarray]:
    """Elements from node to node, and the arc lengths (n_nodes,) of the nodes."""
    if nodes.ndim != 2 or nodes.shape[1] != 2 or len(nodes) < 2 or not np.all(np.isfinite(nodes)):
        raise InputError(f"a beam needs at least two finite nodes (x, y); got an array of shape {nodes.shape}.")
    sides = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    if sides.min() <= 1e-12 * sides.sum():
        raise InputError(f"nodes {sides.argmin()} and {sides.argmin() + 1} of the beam coincide; leave one out.")
    numbers = np.arange(len(nodes))
    return CurveMesh(nodes, np.column_stack([numbers[:-1], numbers[1:]])), np.append(0.0, np.cumsum(sides))
