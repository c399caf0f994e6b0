"""Resolution of floating frames, once, before a scene is compiled: bodies that have several are cut into parts, which rigid joints tie."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from itertools import pairwise
from typing import Any, Self, TypeVar

import numpy as np
from pydantic import PrivateAttr

from toolkit.components.bodies.body import Body
from toolkit.components.bodies.cut_body import CutBody, part_name, part_number
from toolkit.components.bodies.cuttable_body import CuttableBody
from toolkit.components.bodies.flexible import Flexible, SpatialFlexible
from toolkit.components.bodies.framed_part import NODE, place_on
from toolkit.components.bodies.model_body import FRAME, ModelBody, refuse_unknown
from toolkit.components.joints.rigid_joint import Tie
from toolkit.description.design import BodyPoint, Point
from toolkit.foundation.errors import InputError
from toolkit.foundation.itself import Itself
from toolkit.foundation.value_types import Scalar
from toolkit.reduced_model.cut_chain import breaks, chain_nodes, node_labels, place_at, place_of
from toolkit.reduced_model.model import ReducedModel, place_parameter
from toolkit.scene.scene import Scene, known

T = TypeVar("T")

FRAMES = ("moving", "grounded")
"""Frames that a body which is cut can have."""
MESHED = "scikit-fem"
"""Writer of the models of solids."""


class ResolvedScene(Scene):
    """A scene whose floating frames are resolved: what is compiled, and what all that looks at solutions asks.

    Bodies with several frames are cut into parts, and rigid joints tie these. Points, models and parts are looked up once, so that many can
    ask for them; a copy at other numbers keeps the models, and the parts of bodies that are the same.
    """

    _answers: dict[Hashable, Any] = PrivateAttr(default_factory=dict)
    _models: dict[str, ReducedModel] = PrivateAttr(default_factory=dict)
    _parts: dict[str, tuple[Body, dict[str, Body]]] = PrivateAttr(default_factory=dict)

    def model_copy(self, *, update: Mapping[str, object] | None = None, deep: bool = False) -> Self:
        """A copy with other fields, whose answers are its own unless only what is asked or how it is solved differs."""
        found = super().model_copy(update=update, deep=deep)
        if not (update or {}).keys() <= {"solver", "responses"}:
            found._answers, found._parts = {}, dict(self._parts)
        if found.directory != self.directory:
            found._models = {}
        return found

    def once(self, key: Hashable, make: Callable[[], T]) -> T:
        """Result of `make`, which depends on the scene alone, made when it is first asked for under this key."""
        answers = self.__pydantic_private__["_answers"]  # type: ignore[index]  # by its name it takes five times as long
        if key not in answers:
            answers[key] = make()
        found: T = answers[key]
        return found

    def model(self, path: str, *parts: str) -> ReducedModel:
        """Parts of the reduced model in a file, see `Scene.model`; read once for all numbers of the scene."""
        models = self.__pydantic_private__["_models"]  # type: ignore[index]
        known: ReducedModel | None = models.get(path)
        if known is None or not known.bytes_read.keys() >= set(parts):
            models[path] = known = super().model(path, *parts)
        return known

    def all_bodies(self) -> dict[str, Body]:
        """Bodies of the scene, each with its parts behind it, and the ground."""
        return self.once("all bodies", self._all_bodies)

    def _all_bodies(self) -> dict[str, Body]:
        found: dict[str, Body] = {"ground": self.space.ground}
        for name, body in self.bodies.items():
            found |= {name: body, **(self.parts(name) if isinstance(body, CutBody) else {})}
        return found

    def parts(self, name: str) -> dict[str, Body]:
        """Parts of a cut body by their names: the same ones at all numbers of the scene that leave the body alone."""
        body = self.bodies[name]
        if name not in self._parts or self._parts[name][0] is not body:
            assert isinstance(body, CutBody)
            self._parts[name] = body, body.parts(name)
        return self._parts[name][1]

    def body(self, name: str) -> Body:
        """Body of that name, part of one, or the ground.

        Raises
        ------
        InputError
            There is none of that name; lists all bodies.
        """
        found = self.all_bodies().get(name)
        if found is None:
            known(name, (*self.bodies, "ground"), "the scene", "body")
            raise AssertionError(name)
        return found

    def pieces(self, names: Iterable[str] | None = None) -> tuple[str, ...]:
        """Bodies with coordinates and mass of their own: these names, or all, with the parts of a cut body in its place."""
        wanted = self.bodies if names is None else names
        return tuple(piece for name in wanted for piece in (self.parts(name) if isinstance(self.body(name), CutBody) else [name]))

    def piece(self, body: str, point: str) -> str:
        """Name of the one of the `pieces` that a point of a body lies in."""
        found = self.body(body)
        return part_name(body, found.part_at(self, point, body)) if isinstance(found, CutBody) else body

    def interface(self, point: str) -> Point | BodyPoint:
        """Description of a point as it was written.

        Raises
        ------
        InputError
            There is no point of that name; lists all.
        """
        known(point, self.points, "the scene", "point")
        return self.points[point]

    def position(self, point: str) -> np.ndarray:
        """Undeformed global position of a point, shape (d,).

        Raises
        ------
        InputError
            There is no such point, or it is an interface point of a body that has none.
        """
        return self.once(("position", point), lambda: self._position(point))

    def _position(self, point: str) -> np.ndarray:
        written = self.interface(point)
        if isinstance(written, Point):
            return written.position()
        body = self.bodies[written.body]
        if not isinstance(body, ModelBody):
            raise InputError(f"points.{point} is an interface point of body {written.body!r}, which is not flexible.")
        return body.position_at_rest(self, point, written.body)

    def arc_lengths(self, body: Body) -> dict[str, Scalar]:
        """Interface points of a body that the scene puts elsewhere along it: name in the reduced model -> arc length.

        Raises
        ------
        InputError
            Another point sits at the same interface point of a body whose shapes follow its place.
        """
        return self.once(("arc lengths", Itself(body)), lambda: self._arc_lengths(body))

    def _arc_lengths(self, body: Body) -> dict[str, Scalar]:
        mine = {name: p for name, p in self.points.items() if isinstance(p, BodyPoint) and self.bodies.get(p.body) is body}
        found: dict[str, Scalar] = {}
        for name, point in mine.items():
            if point.arc_length is not None:
                twin = next((n for n, other in mine.items() if other.interface == point.interface and n != name), None)
                if twin and isinstance(body, ModelBody) and place_parameter(point.interface) in self.model(body.model).nominal:
                    raise InputError(
                        f"points.{name} and points.{twin} sit at the same interface point, whose place the shapes of body "
                        f"{point.body!r} follow: one cannot move without the other. Use one of them."
                    )
                found[point.interface] = point.arc_length
        return found

    def of_body(self, body: Body, what: Hashable, make: Callable[[], T]) -> T:
        """Result of a computation for one body, made once."""
        return self.once((what, Itself(body)), make)

    @property
    def size(self) -> float:
        """Model size: extent of the points or of the largest body, the length that displacements are compared with."""
        return self.once("size", self._size)

    def _size(self) -> float:
        positions = np.real([self.position(point) for point in self.points])
        extent = np.ptp(positions, axis=0) if len(positions) else np.zeros(self.dimension)
        return float(max(*extent, *(body.radius_of_gyration(self) for body in self.bodies.values())))

    def extrapolated(self) -> dict[str, list[str]]:
        """Flexible bodies that follow a tangent away from their nominal design -> in which parameters."""
        bodies = {name: body for name, body in self.bodies.items() if isinstance(body, ModelBody)}
        found = {name: body.design_point(self).extrapolated() for name, body in bodies.items()}
        return {name: parameters for name, parameters in found.items() if parameters}

    @property
    def cuts(self) -> dict[str, tuple[tuple[int, ...], ...]]:
        """Cut body -> where it is cut, the nodes that it keeps, and how many coordinates come before each of its parts."""
        cut = {name: body for name, body in self.bodies.items() if isinstance(body, CutBody)}
        return {name: (body.cuts, body.gripped, body.starts) for name, body in cut.items()}

    @property
    def ties(self) -> list[str]:
        """Names of the joints that are no joints of the user."""
        return [name for name, joint in self.joints.items() if isinstance(joint, Tie)]

    @property
    def written(self) -> Scene:
        """Scene as the user has written it, at its own numbers and with the numbers of frames that were chosen."""
        ties = set(self.ties)
        fields = dict(self)
        for group in ("points", "joints"):
            fields[group] = {name: item for name, item in fields[group].items() if name not in ties}
        fields["bodies"] = {name: _written(body) for name, body in self.bodies.items()}
        return Scene.model_construct(self.model_fields_set, **fields)


def _written(body: Body) -> Body:
    """Body as the user has written it; with one frame, chosen, it is without `modes_per_frame`, as it has no parts to reduce."""
    if isinstance(body, CutBody):
        return body.uncut()
    if isinstance(body, CuttableBody) and body.choice is not None:
        return type(body).model_construct(**{**dict(body), **({} if body.parted else {"modes_per_frame": None})})
    return body


def loaded(scene: Scene) -> ResolvedScene:
    """The scene whose points and models can be asked, with bodies as they are written, whatever frames they are to have."""
    if isinstance(scene, ResolvedScene):
        return scene
    return ResolvedScene.model_construct(scene.model_fields_set, **dict(scene))


def resolve(scene: Scene, beside: ResolvedScene | None = None) -> ResolvedScene:
    """The scene with its floating frames resolved: bodies, parts, ties, and the way back to what the user has written.

    Parameters
    ----------
    beside
        The same scene at other numbers, whose models are taken.

    Raises
    ------
    InputError
        A body cannot be cut so; says where and what would be right.
    """
    found = loaded(scene)
    if beside is not None:
        found._models = beside._models
    for name, body in scene.bodies.items():
        if isinstance(body, Flexible | SpatialFlexible) and body.parted and not isinstance(body, CutBody):
            found = _with_parts(found, name, body)
    return found


def _with_parts(scene: ResolvedScene, name: str, body: Flexible | SpatialFlexible) -> ResolvedScene:
    """The scene with one more body cut into parts."""
    model = _model(scene, name)
    if body.frames == "auto":
        raise InputError(f'bodies.{name}.frames = "auto" is chosen by runs, and nobody has chosen it here. Write a number.')
    cuts = cuts_of(name, body, model)
    gripped = () if body.modes_per_frame is None else _gripped(scene, name, model)
    cut = scene.space.cut_body.of(body, cuts, gripped)
    cut = cut.model_copy(update={"starts": cut.part_starts(name, model)})
    held = _clamp(name, model) if body.frame == "grounded" else []
    tied = {tie_name(name, model, node): (node, parts) for node, parts in _meetings(name, model, cuts, held).items()}
    points = {tie: BodyPoint(body=name, interface=NODE.format(node)) for tie, (node, _) in tied.items()}
    return scene.model_copy(
        update={
            "bodies": {**scene.bodies, name: cut},
            "points": {**scene.points, **points},
            "joints": {**scene.joints, **dict(_ties(scene, tied))},
        }
    )


def _gripped(scene: ResolvedScene, name: str, model: ReducedModel) -> tuple[int, ...]:
    """Nodes of the elements that points of the scene lie in, and those that they lie at."""
    assert model.elements is not None
    found: set[int] = set()
    for point, written in scene.points.items():
        if isinstance(written, BodyPoint) and written.body == name and written.interface != FRAME:
            place = place_on(scene, name, point)
            ends = model.elements.connectivity[place.element]
            found |= {int(ends[int(place.ratio)])} if place.at_node else {int(node) for node in ends}
    return tuple(sorted(found))


def _meetings(name: str, model: ReducedModel, cuts: list[int], held: list[int]) -> dict[int, list[str]]:
    """Node -> the parts whose ends meet there, which are to be tied.

    At nodes that are held it lists the ground, and the body in the place of the part that holds the node.
    """
    assert model.elements is not None
    found: dict[int, list[str]] = {}
    for k, (first, last) in enumerate(pairwise(cuts)):
        for node in (model.elements.connectivity[first, 0], model.elements.connectivity[last - 1, 1]):
            found.setdefault(int(node), []).append(part_name(name, k))
    meeting = {node: parts for node, parts in found.items() if len(parts) > 1 and node not in held}
    for node in held:
        gripped = part_name(name, part_number(cuts, place_at(model.elements.connectivity, node)))
        meeting[node] = ["ground", name, *(part for part in found.get(node, []) if part != gripped)]
    return meeting


def _ties(scene: ResolvedScene, tied: Mapping[str, tuple[int, list[str]]]) -> Iterator[tuple[str, Tie]]:
    """Rigid joints that tie all bodies at every node to the first one, with their names."""
    for tie, (_, (first, *others)) in tied.items():
        for k, other in enumerate(others):
            yield f"{tie}, {k + 1}" if k else tie, scene.space.tie(bodies=(first, other), point=tie)


def most_frames(scene: Scene, name: str) -> int:
    """Largest number of frames of a body of beams: one for every element.

    Raises
    ------
    InputError
        It cannot be cut; says why.
    """
    elements = _model(scene, name).elements
    assert elements is not None
    return len(elements.connectivity)


def fewest_cut(scene: Scene, name: str) -> int:
    """Least number of frames of a body that has more than one: two, or one for every chain where its elements branch."""
    elements = _model(scene, name).elements
    assert elements is not None
    return max(2, len(breaks(elements.connectivity)) + 1)


def branches(scene: Scene, name: str) -> bool:
    """Whether the elements of a body of beams are no chain, because they branch, close or turn round."""
    elements = _model(scene, name).elements
    return elements is not None and chain_nodes(elements.connectivity) is None


def cuttable(scene: Scene) -> list[str]:
    """Names of the bodies that can have several frames."""
    return [
        name
        for name, body in scene.bodies.items()
        if isinstance(body, Flexible | SpatialFlexible)
        and body.frame in FRAMES
        and not any(body.deflected.values())
        and can_be_cut(scene.model(body.model, "elements"))
    ]


def can_be_cut(model: ReducedModel) -> bool:
    """Whether a reduced model, loaded with its elements, is made of beams or pieces."""
    return model.elements is not None


def tie_name(body: str, model: ReducedModel, node: int) -> str:
    """Name of the point and of the joint at a node."""
    assert model.elements is not None
    return f"{body} at node {node_labels(model.elements.connectivity)[node]}"


def _model(scene: Scene, name: str) -> ReducedModel:
    """Reduced model of a body, if it can be cut."""
    body = scene.bodies[name]
    assert isinstance(body, Flexible | SpatialFlexible)
    model = scene.model(body.model, "elements", "mesh")
    if model.elements is None:
        raise InputError(
            f"bodies.{name}.frames = {body.frames}: the reduced model {body.model!r} does not keep its elements one by one, from "
            "which parts with frames of their own are made. " + _kept_by(model)
        )
    if body.frame not in FRAMES:
        raise InputError(
            f'bodies.{name}.frame = "{body.frame}" belongs to a body with one frame, and frames = {body.frames}. Write frame = "moving" '
            "and hold the body by a joint, or leave `frames` out."
        )
    if written := [key for key, wishes in body.deflected.items() if wishes]:
        raise InputError(
            f"bodies.{name}.{written[0]} is the shape of a body with one frame, and frames = {body.frames}. Leave out one of the two."
        )
    return model


def _kept_by(model: ReducedModel) -> str:
    """Sentence on how a reduced model would keep its elements."""
    if MESHED in model.writers:
        toml = next(iter(model.source), "the file that it is built from")
        return (
            f"A solid in space is cut into groups of elements: name groups of its mesh in [pieces] of {toml} and build it again, or leave "
            "`frames` out, as solids in the plane must."
        )
    return "Build it again with ffrf-preprocess, or leave `frames` out."


def clamped_nodes(model: ReducedModel) -> list[int]:
    """Numbers along the chain of the nodes that the frame of the uncut model is tied to.

    They are none if it is tied to no node, or is no chain.
    """
    order = None if model.elements is None else chain_nodes(model.elements.connectivity)
    if model.elements is None or order is None:
        return []
    held = model.elements.held_nodes(model.mesh)
    return [k for k, node in enumerate(order) if node in held]


def _clamp(name: str, model: ReducedModel) -> list[int]:
    """Nodes that the reduced model clamps."""
    assert model.elements is not None
    found = [int(node) for node in model.elements.held_nodes(model.mesh)]
    if not found:
        raise InputError(
            f"bodies.{name} is grounded with several frames, but no node of its reduced model is clamped ({model.reference_condition}). "
            'Write frame = "moving" and hold the body by joints.'
        )
    return found


def cuts_of(name: str, body: Flexible | SpatialFlexible, model: ReducedModel) -> list[int]:
    """First elements of all parts, and the number of all elements.

    Where chains of elements meet there is always a cut.
    """
    assert model.elements is not None
    count, forced, what = len(model.elements.connectivity), breaks(model.elements.connectivity), model.elements_called
    if isinstance(body.frames, int):
        if body.frames > count:
            raise InputError(
                f"bodies.{name}.frames = {body.frames}, but its reduced model {body.model!r} has {count} {what}, and a frame needs one "
                f"at least. Write at most {count}, or build the model with more {what}."
            )
        if body.frames <= len(forced):
            raise InputError(
                f"bodies.{name}.frames = {body.frames}, but the elements of its reduced model {body.model!r} branch, close or turn round: "
                f"they are {len(forced) + 1} chains, and each needs a frame. Write at least {len(forced) + 1}."
            )
        return _shared([0, *forced, count], body.frames)
    inner = sorted(_node(name, model, place) for place in body.frames)
    for one, other in pairwise([0, *inner, count]):
        if one == other:
            where = "an end of the body" if one in (0, count) else "another cut"
            raise InputError(
                f"bodies.{name}.frames cuts at node {one}, where {where} is already. Name every cut once, and no end."
            )
    return sorted({0, *inner, *forced, count})


def _shared(ends: list[int], frames: int) -> list[int]:
    """First elements of parts, a number of frames, shared among chains that begin and end at `ends`.

    The longest parts always get one more.
    """
    sizes = np.diff(ends)
    shares = np.ones(len(sizes), int)
    for _ in range(frames - len(sizes)):
        shares[np.argmax(sizes / shares)] += 1
    cuts = [
        first + round(k * size / share) for first, size, share in zip(ends, sizes, shares, strict=False) for k in range(share)
    ]
    return [*map(int, cuts), ends[-1]]


def _node(name: str, model: ReducedModel, place: int | str) -> int:
    """Number of the element that begins at a node, given by its number along a chain or by the name of an interface point."""
    assert model.elements is not None
    connectivity = model.elements.connectivity
    count = len(connectivity)
    if isinstance(place, int):
        if chain_nodes(connectivity) is None:
            raise InputError(
                f"bodies.{name}.frames cuts at node {place}, but the elements of reduced model {model.label} branch, close or turn round, "
                "so that nodes have no numbers along them. Name interface points, or write a number of frames."
            )
        if not 0 < place < count:
            raise InputError(
                f"bodies.{name}.frames cuts at node {place}, but the nodes between the ends of the body are 1 to {count - 1}."
            )
        return place
    refuse_unknown(model, place, name)
    point = (model.interfaces or {})[place]
    found = place_of(model.elements, point.here[0][:, 0], f"interface point {place!r}")
    if not found.at_node:
        raise InputError(
            f"bodies.{name}.frames cuts at interface point {place!r}, which lies inside element {found.element} and not at a node. "
            f"Cut at node {found.element} or {found.element + 1}, or put the point at a node in the file that the model is built from."
        )
    return _begun_at(name, connectivity, int(connectivity[found.element, int(found.ratio)]))


def _begun_at(name: str, connectivity: np.ndarray, node: int) -> int:
    """Number of the element that begins at a node and does not end the body there."""
    begun = np.flatnonzero(connectivity[:, 0] == node)
    if np.count_nonzero(connectivity == node) < 2:
        where = node_labels(connectivity)[node]
        raise InputError(
            f"bodies.{name}.frames cuts at node {where}, where an end of the body is already. Name every cut once, and no end."
        )
    return int(begun[begun > 0][0]) if np.any(begun > 0) else breaks(connectivity)[0]
