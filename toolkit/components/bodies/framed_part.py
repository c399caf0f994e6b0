"""One part of a cut body: a flexible body whose frame goes through both of its ends."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from toolkit.components.bodies.body import CENTRE, Placed
from toolkit.components.bodies.model_body import ModelBody
from toolkit.description.description import Scalar
from toolkit.foundation.errors import InputError
from toolkit.foundation.itself import Itself
from toolkit.reduced_model.cut_chain import ChainPlace, PartShapes, node_labels, nodes_of_part, part_shapes, place_at, place_of
from toolkit.reduced_model.cut_part import ChainPart, part_model
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.model import ReducedModel
from toolkit.reduced_model.parts import SURFACE_POSITION, Elements, SpatialElements

REMEMBERED_PARTS = 1000
"""Parts whose shapes are remembered: every complex step asks for them again."""
NODE = "(node {})"
"""Name in place of an interface point: a node of the reduced model by its number there."""


class FramedPart(ModelBody):
    """Part of a cut body `whole`: its elements from `first` up to, but without, `last`, with a floating frame of their own.

    It has the numbers of the whole, and of its own the coordinates: frame and elastic ones.
    """

    kind = ""
    per_node: ClassVar[int]
    """Coordinates of a node, and of an element of the part."""
    frame_coordinates: ClassVar[int]
    """Coordinates of its frame, which moves and turns."""
    assembled: ClassVar[Callable[..., ChainPart]]
    """Function that assembles the part from elements at one design, with the element of every stress point, see `planar_part`."""

    whole: str
    first: int
    last: int
    gripped: tuple[int, ...] = ()
    """Nodes of the whole whose coordinates are kept if others are not."""
    modes_per_frame: int | None = None

    def elastic_names(self, nodes: list[int]) -> Iterator[str]:
        """Names of the elastic coordinates of a part that is not reduced, with the numbers of its nodes as users count them."""
        raise NotImplementedError

    def mass_damping(self, scene: Placed) -> Scalar:
        """Mass-proportional damping alpha of the whole body, in 1/time."""
        return whole_body(scene, self.whole).mass_damping(scene)

    def stiffening(self, scene: Placed) -> np.ndarray | None:
        """None, since a cut body stiffens at its cuts."""
        return None

    @property
    def own(self) -> tuple[int, int, tuple[int, ...], int | None]:
        """Numbers that tell this part from all other parts of the same model."""
        return self.first, self.last, self.gripped, self.modes_per_frame

    def part(self, scene: Placed) -> ChainPart:
        """The part at the scene's parameter values.

        Raises
        ------
        InputError
            A tangent has led to a stiffness that no body has.
        """
        design = whole_design(scene, self.whole)
        key = (ChainPart, *self.own)
        if key not in design.kept:
            stress = design.model.stress
            owners = np.zeros(0, int) if stress is None else stress.element.astype(int)
            shapes = self.shapes(design.model)
            part = self.assembled(elements_at(design), self.first, self.last, owners, shapes)
            design.check_stiffness(part.invariants.stiffness)
            design.kept[key] = part
        found: ChainPart = design.kept[key]
        return found

    def shapes(self, model: ReducedModel) -> PartShapes | None:
        """Shapes that the part is reduced to, by the nominal design of the whole; None if it keeps all coordinates."""
        if self.modes_per_frame is None:
            return None
        assert model.elements is not None
        return _shapes(Itself(model.elements), type(self).assembled, *self.own)

    def size(self, model: ReducedModel) -> int:
        """Number of coordinates of the part."""
        shapes = self.shapes(model)
        return self.frame_coordinates + (self.per_node * (self.last - self.first) if shapes is None else shapes.count)

    def design_point(self, scene: Placed, *parts: str) -> DesignPoint:
        """The part as a reduced model of its own, which holds at this design alone."""
        design = whole_design(scene, self.whole)
        key = (DesignPoint, *self.own)
        if key not in design.kept:
            design.kept[key] = DesignPoint(part_model(self.part(scene), _with_surface(design)))
        found: DesignPoint = design.kept[key]
        return found

    def invariants(self, scene: Placed) -> Any:
        """Invariants of the part, which are sums over its elements."""
        return self.part(scene).invariants

    def some_invariants(self, scene: Placed, *names: str) -> tuple[np.ndarray, ...]:
        """Invariants of the part of the given names."""
        return tuple(getattr(self.part(scene).invariants, name) for name in names)

    def nominal(self, scene: Placed) -> Any:
        """Invariants of the part without imaginary steps."""
        inv = self.part(scene).invariants
        return type(inv)(**{name: np.real(array) for name, array in vars(inv).items()})

    def coordinate_names(self, scene: Placed) -> list[str]:
        """Names of the frame's coordinates, and of the nodal coordinates in the order of the chain."""
        frame = super().coordinate_names(scene)[: self.frame_coordinates]  # type: ignore[safe-super]
        labels = node_labels(connectivity_of(scene, self.whole))
        nodal = [*self.elastic_names([labels[int(node)] for node in self.node_numbers(scene)])]
        shapes = self.shapes(whole_design(scene, self.whole).model)
        if shapes is None:
            return [*frame, *nodal]
        return [*frame, *(nodal[k] for k in shapes.kept), *shapes.names]

    def node_numbers(self, scene: Placed) -> np.ndarray:
        """Numbers of the part's nodes among those of the whole body, (n_nodes,)."""
        return nodes_of_part(connectivity_of(scene, self.whole), self.first, self.last)

    def start_shapes(self, scene: Placed) -> tuple[np.ndarray, np.ndarray]:
        """Zero elastic coordinates and velocities: a part starts undeformed and not deforming."""
        count = self.part(scene).n_f
        return np.zeros(count), np.zeros(count)

    def point(self, scene: Placed, point: str, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Z_P and T_P of a point of the whole body that lies in this part, or of the part's own centre of mass."""
        if point == CENTRE:
            inv = self.invariants(scene)
            return inv.first_moment / inv.mass, self.undeforming_point(inv.first_moment.shape[-1])[1]
        return self.part(scene).at(self.within(scene, place_on(scene, self.whole, point)))

    def within(self, scene: Placed, place: ChainPlace) -> ChainPlace:
        """Place on one of the part's own elements of a node that other parts have too."""
        if self.first <= place.element < self.last:
            return place
        node = connectivity_of(scene, self.whole)[place.element, int(place.ratio)]
        number = int(np.flatnonzero(self.node_numbers(scene) == node)[0])
        last = self.last - self.first
        return ChainPlace(self.first + number, 0.0) if number < last else ChainPlace(self.last - 1, 1.0)


@lru_cache(maxsize=REMEMBERED_PARTS)
def _shapes(
    nominal: Itself[Elements] | Itself[SpatialElements],
    assembled: Callable[..., ChainPart],
    first: int,
    last: int,
    gripped: Sequence[int],
    count: int,
) -> PartShapes:
    """Shapes that a part is reduced to, by the elements of the whole at the nominal design.

    `first` to `count` as in `FramedPart.own`.
    """
    whole = assembled(nominal.item, first, last, np.zeros(0, int))
    inv, nodes = whole.invariants, nodes_of_part(nominal.item.connectivity, first, last)
    kept = whole.kept(len(nodes), [k for k, node in enumerate(nodes) if node in gripped and 0 < k < len(nodes) - 1])
    inertia, weights = inv.inertia_about_origin[1:, 1:] / inv.mass, inv.first_moment[:, 1:].T @ whole.axes()
    return part_shapes(inv.stiffness, inertia, weights, kept, count)


def whole_body(scene: Placed, whole: str) -> ModelBody:
    """The cut body of that name."""
    found = scene.bodies[whole]
    assert isinstance(found, ModelBody)
    return found


def whole_design(scene: Placed, whole: str) -> DesignPoint:
    """The reduced model of a cut body at the scene's parameter values, with its elements."""
    return whole_body(scene, whole).design_point(scene, "elements", "stress", "mesh", "surface", "pieces")


def _with_surface(design: DesignPoint) -> ReducedModel:
    """Model of a design with the surface that the body has there."""
    model = design.model
    if model.surface is None or not design.moves(SURFACE_POSITION):
        return model
    return replace(model, surface=replace(model.surface, position=np.real(design.value(SURFACE_POSITION))))


def connectivity_of(scene: Placed, whole: str) -> np.ndarray:
    """First and second node of every element of a cut body, (n_elements, 2)."""
    elements = whole_design(scene, whole).model.elements
    assert elements is not None
    return elements.connectivity


def elements_at(design: DesignPoint) -> Elements | SpatialElements:
    """Elements of a cut body at a design."""
    if Elements not in design.kept:
        nominal = design.model.elements
        assert nominal is not None
        whole = {name: array for name, array in vars(nominal).items() if array.dtype.kind in "iu"}
        changed = {name: design.value(f"elements.{name}") for name in vars(nominal) if name not in whole}
        design.kept[Elements] = type(nominal)(**whole, **changed)
    found: Elements | SpatialElements = design.kept[Elements]
    return found


def place_on(scene: Placed, whole: str, point: str) -> ChainPlace:
    """Place of a point of the scene on the chain of a cut body.

    Raises
    ------
    InputError
        It is none of its interface points, or lies in two parts.
    """
    design = whole_design(scene, whole)
    elements = elements_at(design)
    node = node_number(scene, point)
    if node is not None:
        return place_at(elements.connectivity, node)
    position = whole_body(scene, whole).point(scene, point, whole)[0][:, 0]
    return place_of(elements, position, f"point {point!r}")


def node_number(scene: Placed, point: str) -> int | None:
    """Number of the node of a point that a cut has brought into the scene; None of other points."""
    written: Any = getattr(scene.interface(point), "interface", "")
    begin, end = NODE.split("{}")
    return int(written[len(begin) : -len(end)]) if written.startswith(begin) else None


def refuse_frame_points(point: str, what: str) -> None:
    """Refuse a point that has no place on any one of the parts.

    Raises
    ------
    InputError
        Always.
    """
    raise InputError(
        f"{what} is asked for its point {point!r}, which a body with several floating frames has not: no frame is that of the whole body. "
        "Use an interface point on the body, or leave `frames` out."
    )
