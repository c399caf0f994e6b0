"""A scene while it is drawn."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tests.random_scenes.draw import Draw
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.scene.scene import Scene


@dataclass
class Draft:
    """Parts of a scene, and what is known of them.

    `period` is about the shortest of the motion's; `places` are the undeformed positions of all points; `variables` are paths that may
    be design variables, and `asked` are responses that make sense, each by its name. `at_rest` says that it may run without inertia,
    `redundant` that joints repeat each other.
    """

    draw: Draw
    directory: Path
    dimension: int
    period: float = np.inf
    points: dict[str, Any] = field(default_factory=dict)
    places: dict[str, np.ndarray] = field(default_factory=dict)
    bodies: dict[str, Any] = field(default_factory=dict)
    joints: dict[str, Any] = field(default_factory=dict)
    loads: dict[str, Any] = field(default_factory=dict)
    variables: list[str] = field(default_factory=list)
    asked: dict[str, Any] = field(default_factory=dict)
    at_rest: bool = False
    redundant: bool = False

    def point(self, place: Any) -> str:
        """A new point of the scene; its name."""
        name = f"P{len(self.points)}"
        numbers = [float(f"{number:.6g}") for number in place]
        self.points[name], self.places[name] = Point(**dict(zip("xyz", numbers, strict=False))), np.array(numbers)
        return name

    def interface(self, body: str, interface: str, place: np.ndarray) -> str:
        """A new point at an interface point of a flexible body; its name."""
        name = f"P{len(self.points)}"
        self.points[name], self.places[name] = BodyPoint(body=body, interface=interface), place
        return name

    def vary(self, *paths: str) -> None:
        """Numbers that may be design variables."""
        self.variables += paths

    def ask(self, **responses: Any) -> None:
        """Responses that make sense."""
        self.asked |= responses

    def faster(self, period: float) -> None:
        """Something in the scene moves with this period."""
        self.period = min(self.period, period)

    def scene(self, options: RunOptions) -> Scene:
        """What was drawn, with some of its variables and responses."""
        names = self.draw.some(self.variables, self.draw.count(2, 3))
        moving = ("energy", "work") if options.quasi_static else ()  # kinetic energy of what has no inertia
        asked = self.draw.some([name for name in self.asked if name not in moving], self.draw.count(3, 6))
        parts: dict[str, Any] = {"points": self.points, "bodies": self.bodies, "joints": self.joints, "loads": self.loads}
        return Scene(
            units="m-kg-s",
            dimension=3 if self.dimension == 3 else 2,
            directory=self.directory,
            design={f"x{k}": path for k, path in enumerate(names)},
            responses={name: self.asked[name] for name in asked},
            solver=options,
            **parts,
        )
