"""What the description of a scene alone makes one ask: joints without effect, bodies that nothing holds, numbers in other units."""

from __future__ import annotations

from collections.abc import Iterator

from toolkit.bodies.model_body import MASS_DAMPING, ModelBody
from toolkit.compilation.frame_hints import floats_with_its_clamp
from toolkit.foundation.verdict import Caution
from toolkit.joints.joint import Joint
from toolkit.joints.spatial.cylindrical import Cylindrical
from toolkit.joints.spatial.revolute import SpatialRevolute
from toolkit.joints.spatial.spherical import Spherical
from toolkit.joints.spatial.universal import Universal
from toolkit.loads.friction import Friction
from toolkit.loads.places import BetweenBodies, BetweenPoints
from toolkit.scene.resolution import ResolvedScene, loaded
from toolkit.scene.scene import Scene
from toolkit.validity.description.frame_number import choices_of_frames
from toolkit.validity.description.mesh_cautions import cautions_of_meshes
from toolkit.validity.description.stale_models import stale_models
from toolkit.validity.description.unit_cautions import cautions_of_units

TURNING = (Spherical, SpatialRevolute, Universal, Cylindrical)
"""Kinds of joints in space that are there to let bodies turn; in the plane every frame that moves also turns."""


def cautions_of_joints(scene: ResolvedScene) -> Iterator[Caution]:
    """Cautions of all joints of a scene."""
    for name, joint in scene.joints.items():
        if not any(scene.body(body).has_frame for body in joint.bodies):
            yield from _between_fixed_frames(scene, name, joint)
        elif isinstance(joint, TURNING) and not any(scene.body(body).turns for body in joint.bodies):
            yield Caution(
                "joint-cannot-turn",
                f"joint {name!r} lets {_both(joint)} turn against each other, but neither can turn as a whole: the ground cannot, nor can "
                'a frame that is "translating" or "grounded". It holds them like a joint without rotation.',
                doubt=False,
            )


def _between_fixed_frames(scene: ResolvedScene, name: str, joint: Joint) -> Iterator[Caution]:
    """A joint at a point that deforms is legitimate where the other side is the ground; anything else is worth a word."""
    deform = [_moves(scene, *grip) for grip in joint.grips]
    flexible = [isinstance(scene.body(body), ModelBody) for body in joint.bodies]
    if not any(deform):
        yield Caution(
            "joint-holds-nothing",
            f"joint {name!r} holds nothing: {_both(joint)} cannot move there, because their frames are fixed to the ground. Its force is "
            'not found. Write frame = "moving" for a body that is a part of the mechanism, or remove the joint.',
        )
    elif all(flexible) and not all(deform):
        moving, fixed = sorted(zip(deform, joint.bodies, strict=True), reverse=True)
        yield Caution(
            "joint-ties-to-the-ground",
            f"joint {name!r} ties {moving[1]!r} to the ground: {fixed[1]!r} cannot move there, because its frame is fixed to the ground. "
            f'Write frame = "moving" for {fixed[1]!r} if it is to move with {moving[1]!r}.',
        )
    elif all(flexible):
        yield Caution(
            "joint-of-grounded-bodies",
            f"joint {name!r} ties the deformations of {_both(joint)} alone: both frames are fixed to the ground, and neither body moves as "
            'a whole. A body that is a part of the mechanism has frame = "moving".',
            doubt=False,
        )


def _moves(scene: ResolvedScene, body: str, point: str) -> bool:
    """Whether any coordinate moves a point of a body."""
    return len(scene.body(body).marker(scene, point, body).columns) > 0


def _both(joint: Joint) -> str:
    return f"{joint.bodies[0]!r} and {joint.bodies[1]!r}"


def damping_in_the_frame(scene: ResolvedScene) -> Iterator[Caution]:
    """Bodies with a moving frame, whose elements have mass-proportional damping of their own."""
    given = scene.model_parameters()
    for name, body in scene.bodies.items():
        own = any(path.startswith(f"bodies.{name}.{MASS_DAMPING}_") for path in given)
        if own and isinstance(body, ModelBody) and body.has_frame and body.damping_differs(scene):
            yield Caution(
                "frame-damping",
                f"elements of {name} have mass-proportional damping of their own: it acts on what moves in the body's frame alone, so that "
                "it is less the more the frame moves with the body, and depends on where the frame is tied to it. Give the whole body "
                "one mass-proportional damping, which acts on all of its velocity, or damp the elements by their stiffness.",
            )


def cautions_of_scene(scene: Scene) -> list[Caution]:
    """All cautions that follow from what is written, in the scene and beside its models, before anything runs."""
    scene = loaded(scene)
    found = [*cautions_of_joints(scene), *_held_by_nothing(scene), *cautions_of_units(scene), *stale_models(scene)]
    found += _between_points_of_one(scene)
    return [*found, *choices_of_frames(scene), *damping_in_the_frame(scene), *cautions_of_meshes(scene)]


def _between_points_of_one(scene: ResolvedScene) -> Iterator[Caution]:
    """Loads along a line between two points of one body that does not deform."""
    for name, load in scene.loads.items():
        if isinstance(load, BetweenPoints) and load.bodies[0] == load.bodies[1]:
            body = load.bodies[0]
            if not isinstance(scene.body(body), ModelBody):
                yield Caution(
                    "load-within-body",
                    f"loads.{name} acts between two points of {body!r}, which stay as far apart as they are: it has no effect. Name two "
                    "bodies.",
                )


def _held_by_nothing(scene: ResolvedScene) -> Iterator[Caution]:
    """Flexible bodies that no joint and no spring grips, although their model clamps them."""
    holding = [
        each
        for each in (*scene.joints.values(), *scene.loads.values())
        if isinstance(each, (Joint, BetweenPoints, BetweenBodies)) and not isinstance(each, Friction)
    ]
    gripped = {body for each in holding for body in each.bodies}
    for name in scene.bodies:
        if name not in gripped and floats_with_its_clamp(scene, name):
            yield Caution(
                "held-by-nothing",
                f'no joint holds {name!r}, which moves freely with its frame. frame = "grounded" fixes what its reduced model clamps to '
                "the ground.",
                doubt=False,
            )
