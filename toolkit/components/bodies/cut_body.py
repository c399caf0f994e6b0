"""A flexible body that is cut at nodes, in the plane and in space: to the scene one body, inside parts with floating frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import accumulate, pairwise
from typing import Any, ClassVar, Self

import numpy as np

from toolkit.components.bodies.body import (
    CENTRE,
    QUATERNION,
    Body,
    ConstantNumbers,
    Placed,
    no_constants,
)
from toolkit.components.bodies.cuttable_body import CuttableBody
from toolkit.components.bodies.flexible import Flexible, SpatialFlexible
from toolkit.components.bodies.framed_part import (
    FramedPart,
    elements_at,
    node_number,
    place_on,
    refuse_frame_points,
    whole_body,
    whole_design,
)
from toolkit.components.bodies.model_body import FRAME, ModelBody
from toolkit.reduced_model.cut_chain import ChainPlace
from toolkit.reduced_model.cut_part import SpatialPart, planar_part, pressed, spatial_part
from toolkit.reduced_model.model import ReducedModel
from toolkit.reduced_model.parts import PieceLoads, SurfaceLoad


class CutBody(CuttableBody):
    """A cut body as a scene writes it, with the number of the first element of each part and the number of all elements.

    It has no coordinates of its own: those of its parts follow it, so that its markers count from the first coordinate of the first part.
    """

    kind = ""
    uncut_kind: ClassVar[type[ModelBody]]
    """Class of the body that the scene has in its place before it is cut."""
    part_kind: ClassVar[type[FramedPart]]
    """Class of the body's parts."""

    cuts: tuple[int, ...]
    gripped: tuple[int, ...] = ()
    """Nodes of the reduced model whose coordinates reduced parts keep between their ends."""
    starts: tuple[int, ...] = ()
    """Coordinates before every part, and of all."""

    @property
    def has_frame(self) -> bool:
        """Whether the body has a floating frame: always, as each of its parts has one."""
        return True

    @classmethod
    def of(cls, body: CuttableBody, cuts: Sequence[int], gripped: Sequence[int]) -> Self:
        """A body as the scene has written it, cut at nodes; with the nodes whose coordinates reduced parts keep."""
        return cls.model_construct(**dict(body), cuts=tuple(cuts), gripped=tuple(gripped)).as_chosen(body.choice)

    def uncut(self) -> ModelBody:
        """Body as the scene has written it, without cuts."""
        written = dict(self)
        for own in ("cuts", "gripped", "starts"):
            written.pop(own, None)
        return self.uncut_kind.model_construct(**written)

    def parts(self, name: str) -> dict[str, Body]:
        """Parts of the body by their names, made anew at every call; `ResolvedScene.parts` keeps them."""
        written = {**dict(self.uncut()), "frame": "moving"}
        return {
            part_name(name, k): self.part_kind.model_construct(
                **written, whole=name, first=first, last=last, gripped=self.gripped
            )
            for k, (first, last) in enumerate(pairwise(self.cuts))
        }

    def coordinate_names(self, scene: Placed) -> list[str]:
        """No names, since all coordinates belong to the parts."""
        return []

    def initial_state(self, scene: Placed) -> tuple[np.ndarray, np.ndarray]:
        """Empty coordinates and velocities, since all coordinates belong to the parts."""
        return np.zeros(0), np.zeros(0)

    def coordinate_lengths(self, scene: Placed) -> np.ndarray:
        """No lengths, since all coordinates belong to the parts."""
        return np.zeros(0)

    def constant(self, scene: Placed, gravity: np.ndarray) -> ConstantNumbers:
        """No constant terms, since all terms belong to the parts."""
        return no_constants(0)

    def floating(self, scene: Placed) -> None:
        """None, since the parts have the invariants of floating frames."""

    def drag(self, scene: Placed) -> None:
        """None, since the parts have the mass-proportional damping."""

    def position_at_rest(self, scene: Placed, point: str, name: str) -> np.ndarray:
        """Undeformed global position of an interface point, or of a node that parts the body, (d,)."""
        node = node_number(scene, point)
        if node is None:
            return super().position_at_rest(scene, point, name)  # type: ignore[safe-super]
        nodes = elements_at(whole_design(scene, name)).nodes
        found: np.ndarray = np.array(self.position) + self.placement @ nodes[node]  # type: ignore[attr-defined]
        return found

    def part_at(self, scene: Placed, point: str, name: str) -> int:
        """Number of the part that a point lies in."""
        return part_number(self.cuts, place_on(scene, name, point))

    def marker(self, scene: Placed, point: str, name: str, *axes: np.ndarray | None) -> Any:
        """Marker at an interface point, on the part that the point lies in."""
        if point in (FRAME, CENTRE) or getattr(scene.interface(point), "interface", "") == FRAME:
            refuse_frame_points(point, f"body {name!r}")
        number = self.part_at(scene, point, name)
        found = self.parts(name)[part_name(name, number)].marker(scene, point, name, *axes)
        return found._replace(columns=self.starts[number] + found.columns)

    def stress_operator(self, scene: Placed) -> np.ndarray:
        """Stress per elastic coordinate of all parts, whose elastic coordinates follow one after the other."""
        name = next(name for name, body in scene.bodies.items() if body is self)
        parts = [part.part(scene) for part in self.parts(name).values()]  # type: ignore[attr-defined]
        operators = [part.invariants.stress_operator for part in parts]
        rows, columns = (sum(each.shape[axis] for each in operators) for axis in (0, -1))
        found: np.ndarray = np.zeros((rows, *operators[0].shape[1:-1], columns), np.result_type(*operators))
        column = 0
        for part, operator in zip(parts, operators, strict=True):
            found[part.stress_rows, ..., column : column + operator.shape[-1]] = operator
            column += operator.shape[-1]
        return found

    @property
    def elastic_places(self) -> np.ndarray:
        """Places of the elastic coordinates of all parts among the coordinates of the body."""
        spans = pairwise(self.starts)
        return np.concatenate([np.arange(first + self.part_kind.frame_coordinates, end) for first, end in spans])

    def part_starts(self, name: str, model: ReducedModel) -> tuple[int, ...]:
        """Number of coordinates before every part, and of all, by the reduced model with its elements."""
        sizes = [part.size(model) for part in self.parts(name).values()]  # type: ignore[attr-defined]
        return tuple(accumulate(sizes, initial=0))


def part_number(cuts: Sequence[int], place: ChainPlace) -> int:
    """Number of the part that holds the element of a place."""
    return int(np.searchsorted(cuts, place.element, side="right")) - 1


def part_name(whole: str, number: int) -> str:
    """Name of a part; parts count from 1."""
    return f"{whole}[{number + 1}]"


class PlanarFramedPart(FramedPart, Flexible):
    """Part of a cut body in the plane, whose floating frame has two coordinates and an angle."""

    kind = ""
    per_node: ClassVar[int] = 3
    frame_coordinates: ClassVar[int] = 3
    assembled = staticmethod(planar_part)

    def elastic_names(self, nodes: list[int]) -> Iterator[str]:
        """Names of the elastic coordinates: the first node only turns, and the last one turns and moves along the chord."""
        yield f"rotation of node {nodes[0]}"
        yield from (f"{axis} of node {k}" for k in nodes[1:-1] for axis in ("x", "y", "rotation"))
        yield from (f"{axis} of node {nodes[-1]}" for axis in ("displacement along the chord", "rotation"))


class PlanarCutBody(CutBody, Flexible):
    """A flexible body in the plane that is cut into parts, which move and turn in the plane."""

    kind = ""
    uncut_kind: ClassVar[type[ModelBody]] = Flexible
    part_kind: ClassVar[type[FramedPart]] = PlanarFramedPart


class SpatialFramedPart(FramedPart, SpatialFlexible):
    """Part of a cut body in space, whose floating frame has three coordinates and a quaternion."""

    kind = ""
    per_node: ClassVar[int] = 6
    frame_coordinates: ClassVar[int] = 7
    assembled = staticmethod(spatial_part)

    def surface_load(self, scene: Placed, surface: str) -> SurfaceLoad:
        """Load of a unit pressure on the pieces of a surface that belong to this part."""
        design = whole_body(scene, self.whole).design_point(scene, "elements", "piece_loads")
        part, loads = self.part(scene), PieceLoads(*(design.value(f"piece_loads.{surface}.{key}") for key in ("force", "moment")))
        assert isinstance(part, SpatialPart)
        return pressed(part, loads)

    def elastic_names(self, nodes: list[int]) -> Iterator[str]:
        """Names of the elastic coordinates of a part that is not reduced.

        Its ends turn across the chord and twist against each other, and the last one moves along it.
        """
        across = [f"rotation {which} across the chord" for which in ("one", "two")]
        every = ["x", "y", "z", *(f"rotation about {axis}" for axis in "xyz")]
        yield from (f"{name} of node {nodes[0]}" for name in across)
        yield from (f"{name} of node {k}" for k in nodes[1:-1] for name in every)
        yield from (f"{name} of node {nodes[-1]}" for name in ("displacement along the chord", *across, "twist"))


class SpatialCutBody(CutBody, SpatialFlexible):
    """A flexible body in space that is cut into parts, which move and turn in space."""

    kind = ""
    uncut_kind: ClassVar[type[ModelBody]] = SpatialFlexible
    part_kind: ClassVar[type[FramedPart]] = SpatialFramedPart

    @property
    def moves(self) -> int:
        """Number of coordinates of the frame's origin in each part."""
        return 3

    @property
    def turns(self) -> int:
        """Number of coordinates of the frame's orientation in each part, those of a quaternion."""
        return QUATERNION
