"""What a study of stability finds: cells, maps, the reference, and all of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from toolkit.foundation import verdict as validity
from toolkit.scene.scene import Scene
from toolkit.studies.stability.map import Map
from toolkit.studies.stability.measure import Measured
from toolkit.studies.stability.verdict import Limits, Verdict


@dataclass(frozen=True)
class Cell:
    """What one cell of a map gave, and what it is called; without variables the gradient has no name."""

    run: Verdict
    gradient: Verdict | None
    measured: Measured | None = None


@dataclass(frozen=True)
class Mapped:
    """A map with its cells by the number of the value on each axis."""

    map: Map
    cells: Mapping[tuple[int, ...], Cell]


@dataclass(frozen=True)
class Reference:
    """The scene's own motion with the finest step that ran in good order, and how far the next coarser one is from it."""

    step: float
    measured: Measured
    next_values: float
    next_slopes: float


@dataclass(frozen=True)
class Study:
    """All maps of a scene; `missing` says why it has none of some kind, `own` what it is as it stands, `verdict` whether to believe it."""

    scene: Scene
    design: list[str]
    limits: Limits
    own: Cell
    reference: Reference | None
    maps: list[Mapped]
    missing: dict[str, str]
    verdict: validity.Verdict
