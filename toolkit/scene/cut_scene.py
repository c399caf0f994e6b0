"""A scene whose bodies with several floating frames are cut into parts, which rigid joints tie: what is compiled."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any

from toolkit.bodies.body import Body
from toolkit.bodies.cut.cut_body import CutBody, part_name
from toolkit.bodies.cut.framed_part import NODE
from toolkit.bodies.model_body import ModelBody, refuse_unknown
from toolkit.bodies.planar.chosen_frames import ChosenFrames
from toolkit.bodies.planar.flexible import Flexible
from toolkit.description.point import BodyPoint
from toolkit.foundation.errors import InputError
from toolkit.joints.both.tie import Tie
from toolkit.reduced_model.cut.chain import chain_nodes, place_of
from toolkit.reduced_model.model import ReducedModel
from toolkit.scene.scene import Scene


class CutScene(Scene):
    """The scene of a user, with the points and rigid joints that tie the parts of its cut bodies."""

    def all_bodies(self) -> dict[str, Body]:
        """The bodies, each with its parts behind it, and the ground."""
        return {"ground": self.space.ground, **_with_parts_of(_SameBodies(self.bodies))}

    def body(self, name: str) -> Body:
        """One body, or part of one."""
        found = self.all_bodies()
        return found[name] if name in found else super().body(name)

    def pieces(self, names: Iterable[str] | None = None) -> tuple[str, ...]:
        """The parts of a cut body in its place."""
        written = [(name, self.body(name)) for name in super().pieces(names)]
        return tuple(piece for name, body in written for piece in (body.parts(name) if isinstance(body, CutBody) else [name]))

    def piece(self, body: str, point: str) -> str:
        """The part of a cut body that the point lies in."""
        found = self.body(body)
        return part_name(body, found.part_at(self, point, body)) if isinstance(found, CutBody) else body

    @property
    def written(self) -> Scene:
        """The scene as the user has written it, at its own numbers."""
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
    if isinstance(body, CutBody):
        return body.uncut()
    if isinstance(body, ChosenFrames):
        chosen = {**dict(body), **body.model_values()}
        del chosen["choice"]
        return Flexible.model_construct(**chosen)
    return body


def written(scene: Scene) -> Scene:
    """The scene as the user has written it, with the numbers of frames that were chosen."""
    if isinstance(scene, CutScene):
        return scene.written
    if any(isinstance(body, ChosenFrames) for body in scene.bodies.values()):
        return scene.model_copy(update={"bodies": {name: _uncut(body) for name, body in scene.bodies.items()}})
    return scene


@dataclass(frozen=True, eq=False)
class _SameBodies:
    """Bodies that equal themselves alone, whatever their numbers are."""

    bodies: dict[str, Body]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _SameBodies) and self.bodies is other.bodies

    def __hash__(self) -> int:
        return id(self.bodies)


@lru_cache(maxsize=8)
def _with_parts_of(same: _SameBodies) -> dict[str, Body]:
    """Bodies, each with its parts behind it: many ask for the same ones."""
    found: dict[str, Body] = {}
    for name, body in same.bodies.items():
        found[name] = body
        if isinstance(body, CutBody):
            found |= body.parts(name)
    return found


def with_parts(scene: Scene) -> Scene:
    """The scene with its cut bodies; itself if none is.

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
        cuts = _cuts(scene, name, body, model)
        cut = scene.space.cut_body.model_construct(**{**dict(body), **body.model_values()}, cuts=tuple(cuts))
        held = _clamp(name, model) if body.frame == "grounded" else []
        nodes = [*cuts[1:-1], *held]
        fields["bodies"] = {**fields["bodies"], name: cut}
        fields["points"] = {
            **fields["points"],
            **{tie_name(name, node): BodyPoint(body=name, interface=NODE.format(node)) for node in nodes},
        }
        ties = {tie_name(name, node): (part_name(name, k), part_name(name, k + 1)) for k, node in enumerate(cuts[1:-1])}
        ties |= {tie_name(name, node): ("ground", name) for node in held}
        fields["joints"] = {**fields["joints"], **{tie: scene.space.tie(bodies=pair, point=tie) for tie, pair in ties.items()}}
    return CutScene.model_construct(**fields)


def most_frames(scene: Scene, name: str) -> int:
    """How many frames a body can have at most: one for every element.

    Raises
    ------
    InputError
        It cannot be cut; says why.
    """
    body = scene.bodies[name]
    assert isinstance(body, Flexible)
    elements = _model(scene, name, body).elements
    assert elements is not None
    return len(elements.connectivity)


def can_be_cut(model: ReducedModel) -> bool:
    """Whether a reduced model, loaded with its elements, is a chain of beams with all nodal coordinates."""
    return model.elements is not None and chain_nodes(model.elements.connectivity) is not None


def tie_name(body: str, node: int) -> str:
    """Name of the point and of the joint at a node."""
    return f"{body} at node {node}"


def _model(scene: Scene, name: str, body: Any) -> ReducedModel:
    """The reduced model, if it can be cut."""
    model = scene.model(body.model, "elements", "mesh")
    if model.elements is None:
        raise InputError(
            f"bodies.{name}.frames = {body.frames}: the reduced model {body.model!r} does not keep its elements one by one, from "
            "which parts with frames of their own are made. "
            + (
                "Build it again with ffrf-preprocess."
                if "identity" in model.basis
                else 'It keeps shapes and not all nodal coordinates: build it with kind = "full" in its [basis], or leave `frames` out.'
            )
        )
    if chain_nodes(model.elements.connectivity) is None:
        raise InputError(
            f"bodies.{name}.frames = {body.frames}: the elements of reduced model {body.model!r} are no chain from one end to another, but "
            "branch or close, and only chains can be cut. Leave `frames` out."
        )
    if body.frame not in ("moving", "grounded"):
        raise InputError(
            f'bodies.{name}.frame = "{body.frame}" belongs to a body with one frame, and frames = {body.frames}. Write frame = "moving" '
            "and hold the body by a joint, or leave `frames` out."
        )
    if written := [key for key, wishes in body.deflected.items() if wishes]:
        raise InputError(
            f"bodies.{name}.{written[0]} is the shape of a body with one frame, and frames = {body.frames}. Leave out one of the two."
        )
    return model


def _cuts(scene: Scene, name: str, body: Any, model: ReducedModel) -> list[int]:
    """Numbers of the nodes along the chain where it is cut, both ends among them."""
    assert model.elements is not None
    count = len(model.elements.connectivity)
    if isinstance(body.frames, int):
        if body.frames > count:
            raise InputError(
                f"bodies.{name}.frames = {body.frames}, but its reduced model {body.model!r} has {count} elements, and a frame needs one "
                f"at least. Write at most {count}, or build the model with more elements."
            )
        return [round(k * count / body.frames) for k in range(body.frames + 1)]
    inner = sorted(_node(name, model, place) for place in body.frames)
    for one, other in pairwise([0, *inner, count]):
        if one == other:
            where = "an end of the body" if one in (0, count) else "another cut"
            raise InputError(
                f"bodies.{name}.frames cuts at node {one}, where {where} is already. Name every cut once, and no end."
            )
    return [0, *inner, count]


def _node(name: str, model: ReducedModel, place: int | str) -> int:
    """Number along the chain of a node, which is given by it or by the name of an interface point."""
    assert model.elements is not None
    count = len(model.elements.connectivity)
    if isinstance(place, int):
        if not 0 < place < count:
            raise InputError(
                f"bodies.{name}.frames cuts at node {place}, but the nodes between the ends of the body are 1 to {count - 1}."
            )
        return place
    refuse_unknown(model, place, name)
    point = (model.interfaces or {})[place]
    found = place_of(model.elements, point.here[0][:, 0], f"interface point {place!r}")
    if found.ratio not in (0.0, 1.0):
        raise InputError(
            f"bodies.{name}.frames cuts at interface point {place!r}, which lies inside element {found.element} and not at a node. "
            f"Cut at node {found.element} or {found.element + 1}, or put the point at a node in the file that the model is built from."
        )
    return round(found.station)


def clamped_nodes(model: ReducedModel) -> list[int]:
    """Numbers along the chain of the nodes that the frame of the uncut model is tied to; none if it is tied to no node."""
    order = None if model.elements is None else chain_nodes(model.elements.connectivity)
    if model.elements is None or order is None:
        return []
    held = model.elements.held_nodes(model.mesh)
    return [k for k, node in enumerate(order) if node in held]


def _clamp(name: str, model: ReducedModel) -> list[int]:
    """Numbers along the chain of the nodes that the model clamps."""
    found = clamped_nodes(model)
    if not found:
        raise InputError(
            f"bodies.{name} is grounded with several frames, but no node of its reduced model is clamped ({model.reference_condition}). "
            'Write frame = "moving" and hold the body by joints.'
        )
    return found
