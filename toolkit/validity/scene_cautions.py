"""What the description of a scene alone makes one ask: joints without effect, bodies that nothing holds, numbers in other units."""

from __future__ import annotations

import hashlib
import os
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path

from toolkit.components.bodies.model_body import MASS_DAMPING, ModelBody
from toolkit.components.joints.cylindrical import Cylindrical
from toolkit.components.joints.joint import Joint
from toolkit.components.joints.revolute import SpatialRevolute
from toolkit.components.joints.spherical import Spherical
from toolkit.components.joints.universal import Universal
from toolkit.components.loads.friction import Friction
from toolkit.components.loads.load import BetweenBodies, BetweenPoints
from toolkit.foundation.errors import listed
from toolkit.foundation.files.safe_files import read_whole
from toolkit.foundation.value_types import TomlTable, TomlValue
from toolkit.foundation.verdict import SCENE, STATES, Caution, check, checks
from toolkit.reduced_model.model import ReducedModel
from toolkit.reduced_model.questions import COARSE_ENERGY_ERROR, COARSE_STRESS_ERROR, face_questions, mesh_questions
from toolkit.responses.local_stress import LocalStress
from toolkit.responses.over_time import OverTime
from toolkit.responses.stress import StressResponse
from toolkit.scene.resolution import ResolvedScene, loaded
from toolkit.scene.scene import Scene
from toolkit.system.redundant_rows import floats_with_its_clamp
from toolkit.system.solution import Solution


@check("coarse-mesh", (SCENE,))
def cautions_of_meshes(scene: Scene) -> Iterator[Caution]:
    """A doubt for every body with a mesh that is too coarse for its stress, if that is asked for, or for its deflections, or with faces
    between its pieces that count."""
    asked = bodies_of_stress(scene)
    for name, body in scene.bodies.items():
        if isinstance(body, ModelBody):
            limit = COARSE_STRESS_ERROR if name in asked else COARSE_ENERGY_ERROR
            yield from mesh_questions(scene.model(body.model), f"body {name!r}", doubt=True, limit=limit)
            yield from face_questions(scene.model(body.model), f"body {name!r}", doubt=True)


def bodies_of_stress(scene: Scene) -> set[str]:
    """Bodies whose stress a response asks for."""
    return {each.body for each in map(_looked_at, scene.responses.values()) if isinstance(each, StressResponse | LocalStress)}


def _looked_at(response: object) -> object:
    return _looked_at(response.source) if isinstance(response, OverTime) else response


LARGEST_INPUT = 2 * 10**9
"""Bytes of a file from which a model was built; a larger one, or what is no file any more, says nothing."""
MOST_NAMED_KEYS = 4
"""Keys that are named."""
GONE = "left out"
"""What stands for a key that one of two texts does not have."""


@check("stale-model", (SCENE,))
def stale_models(scene: Scene) -> list[Caution]:
    """A reduced model is older than what it was built from.

    Limit: any changed number of its files.
    Fix: build it again.

    A doubt for every flexible body whose reduced model is older than the files that it was built from.

    A model holds the SHA-256 of each of these, and the text of the TOML file among them. A file that is not there says nothing: an
    installation that only simulates has the models alone. Nor does a change of comments or of the layout of the TOML file.

    Parameters
    ----------
    scene : the scene that is analysed; its models are read if they have not been

    Returns
    -------
    list of Caution
        With the code "stale-model"; each names the body, the files, what has changed in them as far as that is known, and the command
        that builds the model again. Empty if every model is up to date, or was built from no files.
    """
    bodies: dict[str, list[str]] = {}
    for name, body in scene.bodies.items():
        if isinstance(body, ModelBody):
            bodies.setdefault(body.model, []).append(name)
    found = ((names, scene.model(file)) for file, names in bodies.items())
    return [_caution(names, model, changes) for names, model in found if (changes := list(_changes(model)))]


def _changes(model: ReducedModel) -> Iterator[str]:
    """What has changed since a model was built, in words."""
    for name, stamp in model.inputs.items():
        file = _place(model, name)
        try:
            content = read_whole(file, LARGEST_INPUT)
        except OSError:
            continue
        if hashlib.sha256(content).hexdigest() == stamp:
            continue
        keys = list(_changed_keys(model.source.get(name, ""), content))
        if keys:
            yield f"{name}, where {'; '.join(keys[:MOST_NAMED_KEYS])}{' and more' if len(keys) > MOST_NAMED_KEYS else ''}"
        elif not _same(model.source.get(name, ""), content):
            yield name


def _place(model: ReducedModel, name: str) -> Path:
    return Path(os.path.normpath((model.inputs_from or Path()) / name))


def _caution(bodies: list[str], model: ReducedModel, changes: list[str]) -> Caution:
    command = [f"ffrf-preprocess {_place(model, source)}" for source in model.source]
    command += [f"--parameter {name}={value!r}" for name, value in model.changes.items()]
    if model.path and not any(model.path.name == Path(source).with_suffix(".h5").name for source in model.source):
        command.append(f"--output {model.path}")
    return stale_models.caution(
        f"the reduced model {model.label} of {listed(bodies)} is older than what it was built from: there are changes in "
        f"{' and in '.join(changes)}. These numbers are those of the old files. Fix: build it again, {' '.join(command)}",
    )


def _changed_keys(before: str, now: bytes) -> Iterator[str]:
    """Keys of two TOML texts that differ, with both values; none if one of them is no such text."""
    old, new = _table(before), _table(now.decode(errors="replace"))
    if old is None or new is None:
        return
    ours, theirs = dict(_flat("", old)), dict(_flat("", new))
    for key in dict.fromkeys([*theirs, *ours]):
        if ours.get(key, GONE) != theirs.get(key, GONE):
            yield f"{key} is {theirs.get(key, GONE)} and was {ours.get(key, GONE)}"


def _same(before: str, now: bytes) -> bool:
    """Whether two TOML texts say the same."""
    old = _table(before)
    return bool(before) and old is not None and old == _table(now.decode(errors="replace"))


def _table(text: str) -> TomlTable | None:
    try:
        return tomllib.loads(text) if text else None
    except tomllib.TOMLDecodeError:
        return None


def _flat(prefix: str, table: Mapping[str, TomlValue]) -> Iterator[tuple[str, TomlValue]]:
    """Every value with its key in all tables above it."""
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _flat(f"{prefix}{key}.", value)
        else:
            yield f"{prefix}{key}", value


TURNING = (Spherical, SpatialRevolute, Universal, Cylindrical)
"""Kinds of joints in space that are there to let bodies turn; in the plane every frame that moves also turns."""


@check("joint-cannot-turn", (SCENE,))
def joints_without_turns(scene: ResolvedScene) -> Iterator[Caution]:
    """A joint lets two bodies turn of which neither can turn as a whole.

    Limit: any.
    Fix: a frame that turns, or a joint without rotation.
    """
    for name, joint in scene.joints.items():
        framed = [scene.body(body) for body in joint.bodies if scene.body(body).has_frame]
        if framed and isinstance(joint, TURNING) and not any(scene.body(body).turns for body in joint.bodies):
            yield joints_without_turns.caution(
                f"joint {name!r} lets {_both(joint)} turn against each other, but neither can turn as a whole. The ground cannot, nor can "
                'a frame that is "translating" or "grounded". The joint holds them like one without rotation.',
                doubt=False,
            )


@check("joint-holds-nothing", (SCENE,))
def joints_without_effect(scene: ResolvedScene) -> Iterator[Caution]:
    """A joint ties two points that cannot move; its force is not found.

    Limit: any.
    Fix: `frame = "moving"` for a body that is a part of the mechanism, or no joint.
    """
    for name, joint, deform, _ in _fixed_joints(scene):
        if not any(deform):
            yield joints_without_effect.caution(
                f"joint {name!r} holds nothing: {_both(joint)} cannot move there, because their frames are fixed to the ground. Its force "
                f"is not found. {joints_without_effect.fix}",
            )


@check("joint-ties-to-the-ground", (SCENE,))
def joints_to_the_ground(scene: ResolvedScene) -> Iterator[Caution]:
    """A joint ties a body to a point of another that cannot move, because its frame is fixed to the ground.

    Limit: any.
    Fix: `frame = "moving"` for the other.
    """
    for name, joint, deform, flexible in _fixed_joints(scene):
        if flexible and any(deform) and not all(deform):
            moving, fixed = sorted(zip(deform, joint.bodies, strict=True), reverse=True)
            yield joints_to_the_ground.caution(
                f"joint {name!r} ties {moving[1]!r} to the ground: {fixed[1]!r} cannot move there, because its frame is fixed to the "
                f'ground. Fix: frame = "moving" for {fixed[1]!r} if it is to move with {moving[1]!r}.',
            )


@check("joint-of-grounded-bodies", (SCENE,))
def joints_of_grounded_bodies(scene: ResolvedScene) -> Iterator[Caution]:
    """A joint ties the deformations of two bodies alone, whose frames are both fixed to the ground.

    Limit: any.
    Fix: `frame = "moving"` for a body that is a part of the mechanism.
    """
    for name, joint, deform, flexible in _fixed_joints(scene):
        if flexible and all(deform):
            yield joints_of_grounded_bodies.caution(
                f"joint {name!r} ties the deformations of {_both(joint)} alone: both frames are fixed to the ground, and neither body "
                f"moves as a whole. {joints_of_grounded_bodies.fix}",
                doubt=False,
            )


def _fixed_joints(scene: ResolvedScene) -> Iterator[tuple[str, Joint, list[bool], bool]]:
    """Joints between fixed frames: name, joint, which of both points deform, and whether both bodies are flexible."""
    for name, joint in scene.joints.items():
        if not any(scene.body(body).has_frame for body in joint.bodies):
            flexible = all(isinstance(scene.body(body), ModelBody) for body in joint.bodies)
            yield name, joint, [_moves(scene, *grip) for grip in joint.grips], flexible


def _moves(scene: ResolvedScene, body: str, point: str) -> bool:
    """Whether any coordinate moves a point of a body."""
    return len(scene.body(body).marker(scene, point, body).columns) > 0


def _both(joint: Joint) -> str:
    return f"{joint.bodies[0]!r} and {joint.bodies[1]!r}"


@check("frame-damping", (SCENE,))
def damping_in_the_frame(scene: ResolvedScene) -> Iterator[Caution]:
    """Elements or groups of elements have mass-proportional damping of their own, and the body's frame moves: it acts on motion in the
    frame alone.

    Limit: any above zero.
    Fix: one mass damping for the whole body, or damping that follows the stiffness.
    """
    given = scene.model_parameters()
    for name, body in scene.bodies.items():
        own = any(path.startswith(f"bodies.{name}.{MASS_DAMPING}_") for path in given)
        if own and isinstance(body, ModelBody) and body.has_frame and body.damping_differs(scene):
            yield damping_in_the_frame.caution(
                f"elements of {name} have mass-proportional damping of their own. It acts on what moves in the body's frame alone, so it "
                f"depends on where the frame is tied to the body. {damping_in_the_frame.fix}",
            )


def cautions_of_scene(scene: Scene) -> list[Caution]:
    """All cautions that follow from what is written, in the scene and beside its models, before anything runs."""
    asked = loaded(scene)
    return [caution for each in checks() if SCENE in each.applies_to for caution in each(asked)]


@check("extrapolated", STATES)
def extrapolated_bodies(solution: Solution) -> Iterator[Caution]:
    """Bodies that follow the tangent at their nominal design."""
    for body, names in solution.system.scene.extrapolated().items():
        yield extrapolated_bodies.caution(
            f"bodies.{body} follows the tangent at its nominal design in {', '.join(names)}: an error of second order in the change.",
            doubt=False,
        )


@check("load-within-body", (SCENE,))
def loads_within_bodies(scene: ResolvedScene) -> Iterator[Caution]:
    """A load acts along a line between two points of one rigid body: it has no effect.

    Limit: any.
    Fix: name two bodies.
    """
    for name, load in scene.loads.items():
        if isinstance(load, BetweenPoints) and load.bodies[0] == load.bodies[1]:
            body = load.bodies[0]
            if not isinstance(scene.body(body), ModelBody):
                yield loads_within_bodies.caution(
                    f"loads.{name} acts between two points of {body!r}, which stay as far apart as they are: it has no effect. "
                    f"{loads_within_bodies.fix}",
                )


@check("held-by-nothing", (SCENE,))
def held_by_nothing(scene: ResolvedScene) -> Iterator[Caution]:
    """No joint and no spring holds a flexible body that its model clamps.

    Limit: any.
    Fix: `frame = "grounded"`, which fixes what its model clamps, or a joint.
    """
    holding = [
        each
        for each in (*scene.joints.values(), *scene.loads.values())
        if isinstance(each, (Joint, BetweenPoints, BetweenBodies)) and not isinstance(each, Friction)
    ]
    gripped = {body for each in holding for body in each.bodies}
    for name in scene.bodies:
        if name not in gripped and floats_with_its_clamp(scene, name):
            yield held_by_nothing.caution(
                f"no joint holds {name!r}, which moves freely with its frame. {held_by_nothing.fix}",
                doubt=False,
            )
