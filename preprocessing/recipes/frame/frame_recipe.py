"""From frame.toml to the reduced model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from preprocessing.discretisation.discretisation import DesignSpace
from preprocessing.discretisation.fibre_lines import fibre_lines
from preprocessing.recipes.frame.frame_design import frame_beams, frame_space, places
from preprocessing.recipes.frame.frame_file import FrameFile
from preprocessing.recipes.recipe import Recipe, Remark, Seal
from preprocessing.reduction.reduced import reduce

STOCKY = 1.5
"""Width of a rectangle in parts of its thickness below which the polynomial for its torsion is off by more than 1.3 %."""


class FrameRecipe(Recipe[FrameFile]):
    """A frame of spatial beams; remarks name every section whose torsion is only roughly known."""

    name = "frame.toml"
    schema = FrameFile
    seal = Seal("frame, ", lengths_of_files=False)
    parts = ("invariants", "derivatives", "affine", "interfaces", "stress", "surface")

    @classmethod
    def means(cls, content: Mapping[str, Any]) -> bool:
        return "beams" in content or "nodes" in content

    def _named(self) -> list[Path]:
        return []

    def _places(self) -> dict[str, tuple[Any, ...]]:
        return places(self.file)

    def _designs(self, remark: Remark | None) -> DesignSpace:
        for name in self._stocky():
            if remark is not None:
                remark(
                    f"{self.path.name}: the torsion constant of the stocky rectangle {name} is up to 12 % too low. "
                    "State it as a general section."
                )
        return frame_space(self.file)

    def _fields(self, designs: DesignSpace) -> dict[str, Any]:
        file, clamp = self.file, self.file.clamp or []
        clamped = [list(file.nodes).index(node) for node in clamp]
        found = reduce(
            designs, file.basis.choice(), clamped, ("the node " if len(clamp) == 1 else "the nodes ") + ", ".join(clamp)
        )
        return {
            **found.fields(file.units),
            "surface": fibre_lines(frame_beams(file, designs.values), found.basis.z, designs.values),
        }

    def _stocky(self) -> Iterator[str]:
        """Names of rectangles that are hardly wider than thick."""
        for name, section in self.file.sections.items():
            sides = sorted([section.thickness or 0.0, section.width or 0.0])
            if section.kind == "rectangle" and sides[1] < STOCKY * sides[0]:
                yield name
