"""A flexible body that is cut at nodes: to the scene one body, inside parts with floating frames."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.body import CENTRE, Body, ConstantNumbers, Placed, no_constants
from toolkit.bodies.model_body import FRAME
from toolkit.bodies.planar.body import FloatingNumbers, MarkerNumbers
from toolkit.bodies.planar.chosen_frames import FrameChoice
from toolkit.bodies.planar.cut.framed_part import (
    FramedPart,
    elements_at,
    node_number,
    place_on,
    refuse_frame_points,
    whole_design,
)
from toolkit.bodies.planar.flexible import Flexible
from toolkit.kinematics.planar import rotation


class CutBody(Flexible):
    """What a scene writes of the body, with the numbers of the nodes that part it, both ends of the chain among them.

    It has no coordinates of its own: those of its parts follow it, so that its markers count from the first coordinate of the first part.
    """

    kind = ""

    cuts: tuple[int, ...]
    choice: FrameChoice | None = None

    @property
    def has_frame(self) -> bool:
        """All of its parts have one."""
        return True

    def parts(self, name: str) -> dict[str, Body]:
        """Its parts by name."""
        written = {**dict(self), **self.model_values(), "frame": "moving"}
        del written["cuts"], written["choice"]
        pairs = zip(self.cuts, self.cuts[1:], strict=False)
        return {
            part_name(name, k): FramedPart.model_construct(**written, whole=name, first=first, last=last)
            for k, (first, last) in enumerate(pairs)
        }

    def coordinate_names(self, scene: Placed) -> list[str]:
        """None."""
        return []

    def initial_state(self, scene: Placed) -> tuple[np.ndarray, np.ndarray]:
        """Empty."""
        return np.zeros(0), np.zeros(0)

    def coordinate_lengths(self, scene: Placed) -> np.ndarray:
        """Empty."""
        return np.zeros(0)

    def constant(self, scene: Placed, gravity: np.ndarray) -> ConstantNumbers:
        """Nothing."""
        return no_constants(0)

    def floating(self, scene: Placed) -> FloatingNumbers | None:
        """Nothing."""
        return None

    def position_at_rest(self, scene: Placed, point: str, name: str) -> np.ndarray:
        """Undeformed global position of an interface point, or of a node that parts the body, (2,)."""
        node = node_number(scene, point)
        if node is None:
            return super().position_at_rest(scene, point, name)
        elements = elements_at(whole_design(scene, name))
        number = np.append(elements.connectivity[:, 0], elements.connectivity[-1, 1])[node]
        return np.array(self.position) + rotation(self.angle) @ elements.nodes[number]

    def part_at(self, scene: Placed, point: str, name: str) -> int:
        """Number of the part that a point lies in."""
        station = place_on(scene, name, point).station
        return min(int(np.searchsorted(self.cuts, station, side="right")) - 1, len(self.cuts) - 2)

    def marker(self, scene: Placed, point: str, name: str) -> MarkerNumbers:
        """An interface point, on the part that it lies in."""
        if point in (FRAME, CENTRE) or getattr(scene.interface(point), "interface", "") == FRAME:
            refuse_frame_points(point, f"body {name!r}")
        number = self.part_at(scene, point, name)
        found = self.parts(name)[part_name(name, number)].marker(scene, point, name)
        return found._replace(columns=self.first_coordinate(number) + found.columns)

    def stress_operator(self, scene: Placed) -> np.ndarray:
        """That of all parts, on their elastic coordinates one after the other."""
        name = next(name for name, body in scene.bodies.items() if body is self)
        parts = [part.part(scene) for part in self.parts(name).values()]  # type: ignore[attr-defined]
        operators = [part.invariants.stress_operator for part in parts]
        size = sum(len(each) for each in operators), sum(each.shape[1] for each in operators)
        found: np.ndarray = np.zeros(size, np.result_type(*operators))
        column = 0
        for part, operator in zip(parts, operators, strict=True):
            found[part.stress_rows, column : column + operator.shape[1]] = operator
            column += operator.shape[1]
        return found

    @property
    def elastic_places(self) -> np.ndarray:
        """Where the elastic coordinates of all parts are among those of the body."""
        spans = [(self.first_coordinate(k), self.first_coordinate(k + 1)) for k in range(len(self.cuts) - 1)]
        return np.concatenate([np.arange(first + 3, end) for first, end in spans])

    def first_coordinate(self, number: int) -> int:
        """Coordinates of the parts before one."""
        return 3 * (self.cuts[number] - self.cuts[0]) + 3 * number


def part_name(whole: str, number: int) -> str:
    """Name of a part, which counts from 1."""
    return f"{whole}[{number + 1}]"
