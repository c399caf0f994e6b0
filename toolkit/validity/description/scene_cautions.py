"""What the description of a scene alone makes one ask: joints without effect, bodies that nothing holds, numbers in other units."""

from __future__ import annotations

from collections.abc import Iterator

from toolkit.bodies.model_body import ModelBody
from toolkit.compilation.frame_hints import floats_with_its_clamp
from toolkit.foundation.verdict import Caution
from toolkit.joints.joint import Joint
from toolkit.loads.friction import Friction
from toolkit.loads.places import BetweenBodies, BetweenPoints
from toolkit.scene.scene import Scene
from toolkit.validity.description.frame_damping import damping_in_the_frame
from toolkit.validity.description.frame_number import choices_of_frames
from toolkit.validity.description.joint_cautions import cautions_of_joints
from toolkit.validity.description.mesh_cautions import cautions_of_meshes
from toolkit.validity.description.stale_models import stale_models
from toolkit.validity.description.unit_cautions import cautions_of_units


def cautions_of_scene(scene: Scene) -> list[Caution]:
    """All cautions that follow from what is written, in the scene and beside its models, before anything runs."""
    found = [*cautions_of_joints(scene), *_held_by_nothing(scene), *cautions_of_units(scene), *stale_models(scene)]
    found += _between_points_of_one(scene)
    return [*found, *choices_of_frames(scene), *damping_in_the_frame(scene), *cautions_of_meshes(scene)]


def _between_points_of_one(scene: Scene) -> Iterator[Caution]:
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


def _held_by_nothing(scene: Scene) -> Iterator[Caution]:
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
