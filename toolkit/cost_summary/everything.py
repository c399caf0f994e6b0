"""A scene with everything put back that its compilation drops: the same motion, at the price of a program that drops nothing."""

from __future__ import annotations

from toolkit.bodies.model_body import FRAME, ModelBody
from toolkit.description.point import BodyPoint
from toolkit.foundation.errors import NoDerivativeError
from toolkit.reduced_model.file import PARTS
from toolkit.scene.scene import Scene
from toolkit.sensitivity.preparation import prepare
from toolkit.solvers.start.initial_conditions import closed
from toolkit.system.system import System


def grounded_bodies(scene: Scene) -> dict[str, ModelBody]:
    """Flexible bodies whose frame has no coordinates."""
    bodies = {name: body for name, body in scene.bodies.items() if isinstance(body, ModelBody)}
    return {name: body for name, body in bodies.items() if not body.has_frame and not body.parted}


def with_frames(scene: Scene) -> Scene:
    """Scene with the frames of its grounded bodies: they may move, and a rigid joint to the ground holds each where it was.

    Frames in space that only turn, or only move, stay what they are.
    """
    grounded = {f"frame of {name}": name for name in grounded_bodies(scene)}
    moving = {name: scene.bodies[name].model_copy(update={"frame": "moving"}) for name in grounded.values()}
    points = {point: BodyPoint(body=name, interface=FRAME) for point, name in grounded.items()}
    rigid = scene.space.kinds["joints"]["rigid"]
    joints = {point: rigid.model_validate({"bodies": (name, "ground"), "point": point}) for point, name in grounded.items()}
    return scene.model_copy(
        update={
            "points": {**scene.points, **points},
            "bodies": {**scene.bodies, **moving},
            "joints": {**scene.joints, **joints},
        }
    )


def prepare_everything(scene: Scene) -> System:
    """Compile a scene with all frames, all groups of its files, and the derivative blocks of all its numbers.

    Of these the joints exclude some: axes of a universal joint that have to stay at right angles, points of joints that repeat each other.
    By them the motion has no derivative, so that no program could keep it.
    """
    for body in scene.bodies.values():
        if isinstance(body, ModelBody):
            scene.model(body.model, *PARTS)
    whole, paths = with_frames(scene), scene.available_paths()
    while True:
        try:
            system = prepare(whole, paths)
            closed(system, *system.start()[::2], 0.0)
        except NoDerivativeError as error:
            paths = [path for path in paths if path not in error.variables]
        else:
            return system
