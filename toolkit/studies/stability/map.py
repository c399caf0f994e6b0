"""A map: axes, and the scene of every cell."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from toolkit.scene.scene import Scene

Judge = Literal["reference", "half step", "own units"]


@dataclass(frozen=True)
class Axis:
    """Values of one thing that a map varies.

    `own` is the number of the value that the scene has as it stands. A `factor` multiplies what the scene has: `nominal`, if that is one
    number. Text instead of numbers has no order.
    """

    name: str
    values: tuple[float | str, ...]
    own: int | None = None
    unit: str = ""
    factor: bool = False
    nominal: float | None = None

    def label(self, index: int) -> str:
        """One value, short."""
        value = self.values[index]
        return value if isinstance(value, str) else brief(value)

    def long_label(self, index: int) -> str:
        """One value with its unit; of a factor also the number that comes out."""
        value = self.values[index]
        if isinstance(value, str):
            return value
        if self.factor and self.nominal is not None:
            return f"{brief(value * self.nominal)} {self.unit} (x {brief(value)})".replace("  ", " ")
        return f"x {brief(value)}" if self.factor else f"{brief(value)} {self.unit}".strip()


def brief(value: float) -> str:
    """Three digits of a number, without zeros that say nothing."""
    if value == 0 or 1e-3 <= abs(value) < 1e5:
        return f"{float(f'{value:.3g}') + 0.0:g}"  # no minus before a zero
    digits, power = f"{value:.2e}".split("e")
    return f"{digits.rstrip('0').rstrip('.')}e{int(power)}"


@dataclass(frozen=True)
class Map:
    """Cells over one axis or two; `scenes` has the number of the value on each axis -> scene.

    `judge` says what the responses of a cell are compared with: the scene's own motion with a fine step, where the map varies the
    solver; the same cell with half the step, where it varies the physics; or the scene as it stands, in its own units.
    """

    name: str
    title: str
    axes: tuple[Axis, ...]
    scenes: Mapping[tuple[int, ...], Scene]
    judge: Judge


def over(axes: tuple[Axis, ...], scene_at: Callable[..., Scene]) -> dict[tuple[int, ...], Scene]:
    """Scenes of all cells from the values on the axes."""
    found = {}
    for index in np.ndindex(*(len(axis.values) for axis in axes)):
        found[index] = scene_at(*(axis.values[k] for axis, k in zip(axes, index, strict=True)))
    return found


def scaled(scene: Scene, paths: Mapping[str, float]) -> Scene:
    """The scene with the numbers at some paths multiplied by factors."""
    for path, by in paths.items():
        if by != 1:
            scene = scene.with_number(path, by * scene.number(path))
    return scene


def with_options(scene: Scene, **changes: Any) -> Scene:
    """The scene with other options of the solver."""
    return scene.model_copy(update={"solver": scene.solver.model_copy(update=changes)})
