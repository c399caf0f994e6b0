"""What a study of stability returns: cells with their classes, maps, the reference, and all of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from toolkit.foundation.verdict import Verdict
from toolkit.scene.scene import Scene
from toolkit.studies.stability.cell_outcome import CellOutcome
from toolkit.studies.stability.classifier import CellClass, Limits
from toolkit.studies.stability.map import Map


@dataclass(frozen=True)
class Cell:
    """What one cell of a map gave, and what it is called; without variables the gradient has no name."""

    run: CellClass
    gradient: CellClass | None
    outcome: CellOutcome | None = None


@dataclass(frozen=True)
class MapResult:
    """A map with its cells by the number of the value on each axis."""

    map: Map
    cells: Mapping[tuple[int, ...], Cell]


@dataclass(frozen=True)
class FineReference:
    """The scene's own motion with the finest step that ran in good order, and how far the next coarser one is from it."""

    step: float
    outcome: CellOutcome
    next_values: float
    next_slopes: float


@dataclass(frozen=True)
class StabilityResult:
    """All maps of a scene; `missing` says why it has none of some kind, `own` what it is as it stands, `verdict` whether to believe it."""

    scene: Scene
    design: list[str]
    limits: Limits
    own: Cell
    reference: FineReference | None
    maps: list[MapResult]
    missing: dict[str, str]
    verdict: Verdict
