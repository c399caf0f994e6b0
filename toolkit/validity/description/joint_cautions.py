"""Joints that hold less, or more, than they seem to: between bodies that cannot move against each other."""

from __future__ import annotations

from collections.abc import Iterator

from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.verdict import Caution
from toolkit.joints.joint import Joint
from toolkit.joints.spatial.cylindrical import Cylindrical
from toolkit.joints.spatial.revolute import SpatialRevolute
from toolkit.joints.spatial.spherical import Spherical
from toolkit.joints.spatial.universal import Universal
from toolkit.scene.scene import Scene

TURNING = (Spherical, SpatialRevolute, Universal, Cylindrical)
"""Kinds of joints in space that are there to let bodies turn; in the plane every frame that moves also turns."""


def cautions_of_joints(scene: Scene) -> Iterator[Caution]:
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


def _between_fixed_frames(scene: Scene, name: str, joint: Joint) -> Iterator[Caution]:
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


def _moves(scene: Scene, body: str, point: str) -> bool:
    """Whether any coordinate moves a point of a body."""
    return len(scene.body(body).marker(scene, point, body).columns) > 0


def _both(joint: Joint) -> str:
    return f"{joint.bodies[0]!r} and {joint.bodies[1]!r}"
