"""A scene whose bodies with several floating frames are cut into parts, which rigid joints tie: what is compiled."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from itertools import pairwise
from typing import Any

from toolkit.bodies.body import Body
from toolkit.bodies.cut.chosen_frames import ChosenFrames
from toolkit.bodies.cut.cut_body import CutBody, part_name, part_number
from toolkit.bodies.cut.cuttable_body import CuttableBody
from toolkit.bodies.cut.framed_part import NODE, place_on
from toolkit.bodies.model_body import FRAME, ModelBody
from toolkit.description.point import BodyPoint
from toolkit.foundation.errors import InputError
from toolkit.foundation.itself import Itself
from toolkit.joints.both.tie import Tie
from toolkit.reduced_model.cut.chain import breaks, chain_nodes, node_labels, place_at
from toolkit.reduced_model.model import ReducedModel
from toolkit.scene.cuts import cuts_of
from toolkit.scene.scene import Scene

FRAMES = ("moving", "grounded")
"""Frames that a body which is cut can have."""
MESHED = "scikit-fem"
"""Writer of the models of solids."""


class CutScene(Scene):
    """A user's scene with the points and rigid joints that tie the parts of its cut bodies."""

    def all_bodies(self) -> dict[str, Body]:
        """Bodies of the scene, each with its parts behind it, and the ground."""
        return {"ground": self.space.ground, **_with_parts_of(Itself(self.bodies))}

    def body(self, name: str) -> Body:
        """Body of that name, or part of one."""
        found = _with_parts_of(Itself(self.bodies))
        return found[name] if name in found else super().body(name)

    def pieces(self, names: Iterable[str] | None = None) -> tuple[str, ...]:
        """Bodies with coordinates of their own, with the parts of a cut body in its place."""
        written = [(name, self.body(name)) for name in super().pieces(names)]
        return tuple(piece for name, body in written for piece in (body.parts(name) if isinstance(body, CutBody) else [name]))

    def piece(self, body: str, point: str) -> str:
        """Name of the part of a cut body that the point lies in, or of the body where it is not cut."""
        found = self.body(body)
        return part_name(body, found.part_at(self, point, body)) if isinstance(found, CutBody) else body

    @property
    def written(self) -> Scene:
        """Scene as the user has written it, at its own numbers."""
        ties = set(self.ties)
        fields = dict(self)
        for group in ("points", "joints"):
            fields[group] = {name: item for name, item in fields[group].items() if name not in ties}
        fields["bodies"] = {name: _uncut(body) for name, body in self.bodies.items()}
        return Scene.model_construct(**fields)

    @property
    def ties(self) -> list[str]:
        """Names of the joints that are no joints of the user."""
        return [name for name, joint in self.joints.items() if isinstance(joint, Tie)]


def _uncut(body: Body) -> Body:
    return body.uncut() if isinstance(body, CutBody | ChosenFrames) else body


def written(scene: Scene) -> Scene:
    """Scene as the user has written it, with the numbers of frames that were chosen."""
    if isinstance(scene, CutScene):
        return scene.written
    if any(isinstance(body, ChosenFrames) for body in scene.bodies.values()):
        return scene.model_copy(update={"bodies": {name: _uncut(body) for name, body in scene.bodies.items()}})
    return scene


@lru_cache(maxsize=8)
def _with_parts_of(same: Itself[dict[str, Body]]) -> dict[str, Body]:
    """Bodies, each with its parts behind it; kept because many ask for the same ones."""
    found: dict[str, Body] = {}
    for name, body in same.item.items():
        found[name] = body
        if isinstance(body, CutBody):
            found |= body.parts(name)
    return found


def with_parts(scene: Scene) -> Scene:
    """Scene with its cut bodies as parts; the scene itself if none is cut.

    Raises
    ------
    InputError
        A body cannot be cut so; says where and what would be right.
    """
    wanted = {name: body for name, body in scene.bodies.items() if isinstance(body, ModelBody) and body.parted}
    if not wanted or isinstance(scene, CutScene):
        return scene
    fields: dict[str, Any] = dict(scene)
    body: Any
    for name, body in wanted.items():
        model = _model(scene, name, body)
        if body.frames == "auto":
            raise InputError(f'bodies.{name}.frames = "auto" is chosen by runs, and nobody has chosen it here. Write a number.')
        cuts = cuts_of(name, body, model)
        gripped = () if body.modes_per_frame is None else _gripped(scene, name, model)
        written = {**dict(body), **body.model_values()}
        cut = scene.space.cut_body.model_construct(**written, cuts=tuple(cuts), gripped=gripped)
        cut = cut.model_copy(update={"starts": cut.part_starts(name, model)})
        held = _clamp(name, model) if body.frame == "grounded" else []
        fields["bodies"] = {**fields["bodies"], name: cut}
        tied = {tie_name(name, model, node): (node, parts) for node, parts in _meetings(name, model, cuts, held).items()}
        points = {tie: BodyPoint(body=name, interface=NODE.format(node)) for tie, (node, _) in tied.items()}
        fields["points"] = {**fields["points"], **points}
        fields["joints"] = {**fields["joints"], **dict(_ties(scene, tied))}
    return CutScene.model_construct(**fields)


def _gripped(scene: Scene, name: str, model: ReducedModel) -> tuple[int, ...]:
    """Nodes of the elements that points of the scene lie in, and those that they lie at."""
    assert model.elements is not None
    found: set[int] = set()
    for point, written in scene.points.items():
        if isinstance(written, BodyPoint) and written.body == name and written.interface != FRAME:
            place = place_on(scene, name, point)
            ends = model.elements.connectivity[place.element]
            found |= {int(ends[int(place.ratio)])} if place.at_node else {int(node) for node in ends}
    return tuple(sorted(found))


def parts_of(scene: Scene) -> dict[str, tuple[tuple[int, ...], ...]]:
    """Cut body -> where it is cut, the nodes that it keeps, and how many coordinates come before each of its parts."""
    cut = {name: body for name, body in scene.bodies.items() if isinstance(body, CutBody)}
    return {name: (body.cuts, body.gripped, body.starts) for name, body in cut.items()}


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


def _ties(scene: Scene, tied: Mapping[str, tuple[int, list[str]]]) -> Iterator[tuple[str, Tie]]:
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
    elements = _model(scene, name, scene.bodies[name]).elements
    assert elements is not None
    return len(elements.connectivity)


def fewest_cut(scene: Scene, name: str) -> int:
    """Least number of frames of a body that has more than one: two, or one for every chain where its elements branch."""
    elements = _model(scene, name, scene.bodies[name]).elements
    assert elements is not None
    return max(2, len(breaks(elements.connectivity)) + 1)


def branches(scene: Scene, name: str) -> bool:
    """Whether the elements of a body of beams are no chain, because they branch, close or turn round."""
    elements = _model(scene, name, scene.bodies[name]).elements
    return elements is not None and chain_nodes(elements.connectivity) is None


def cuttable(scene: Scene) -> list[str]:
    """Names of the bodies that can have several frames."""
    return [
        name
        for name, body in scene.bodies.items()
        if isinstance(body, CuttableBody)
        and body.frame in FRAMES  # type: ignore[attr-defined]
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


def _model(scene: Scene, name: str, body: Any) -> ReducedModel:
    """Reduced model of a body, if it can be cut."""
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
