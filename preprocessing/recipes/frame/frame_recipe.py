"""From frame.toml to the reduced model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from preprocessing.discretisation.discretisation import DesignSpace
from preprocessing.elements.kinds.beams import PlanarBeam, SpatialBeam
from preprocessing.recipes.beam_surface import beam_surface
from preprocessing.recipes.frame.frame_design import frame_beams, frame_space, node_number, places
from preprocessing.recipes.frame.frame_file import FrameFile
from preprocessing.recipes.recipe import Recipe, Remark, Seal
from preprocessing.reduction.reduced import ELEMENT_PARTS, SECTIONS, Reduced, reduce
from toolkit.reduced_model.model import Mesh


class FrameRecipe(Recipe[FrameFile]):
    """Recipe of a frame of beams."""

    name = "frame.toml"
    schema = FrameFile
    seal = Seal("frame, ", lengths_of_files=False)

    @classmethod
    def means(cls, content: Mapping[str, Any]) -> bool:
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

    def _places(self) -> dict[str, tuple[Any, ...]]:
        return places(self.file)

    def _designs(self, remark: Remark | None) -> DesignSpace:
        if remark is not None:
            for text in self.warnings:
                remark(text)
        return frame_space(self.file)

    def _fields(self, designs: DesignSpace) -> dict[str, Any]:
        file, clamp = self.file, self.file.clamp or []
        clamped = [node_number(file, node) for node in clamp]
        found = reduce(
            designs, file.basis.choice(), clamped, ("the node " if len(clamp) == 1 else "the nodes ") + ", ".join(clamp)
        )
        return {**found.fields(file.units), **_picture(found, frame_beams(file, designs.values), outline(file))}


def _picture(found: Reduced, beams: SpatialBeam | PlanarBeam, line: np.ndarray) -> dict[str, Any]:
    """Field of the reduced model for pictures: the mesh in the plane, the surface in space."""
    if isinstance(beams, SpatialBeam):
        return beam_surface(found, beams)
    return {"mesh": Mesh(beams.nodes, beams.connectivity, found.basis.z, line, np.zeros((0, 2)))}


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
