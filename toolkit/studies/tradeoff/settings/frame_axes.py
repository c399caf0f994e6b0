"""The axis of floating frames: into how many parts bodies that deform far are cut, without preprocessing."""

from __future__ import annotations

from collections.abc import Sequence

from toolkit.foundation.errors import InputError
from toolkit.scene.cut_scene import cuttable, fewest_cut, most_frames
from toolkit.scene.scene import Scene
from toolkit.sensitivity.frames.chosen_frames import with_frames
from toolkit.studies.tradeoff.settings.setting import EVERY_ELEMENT, Choice

AXES = {"frames": "1/2/4/8/every: floating frames of the bodies that can have several; `every`: one to each element"}
NUMBERS = ("1", "2", "4", "8", EVERY_ELEMENT)


def choices(scene: Scene, given: Sequence[str]) -> list[Choice]:
    """Choices of the axis; those by default if none are given.

    Raises
    ------
    InputError
        No body can have several frames, or a value cannot be meant.
    """
    bodies = cuttable(scene)
    if not bodies:
        raise InputError(
            "--axes: frames needs a flexible body whose model is made of beams with all nodal coordinates; this scene has none. Leave the "
            "axis out."
        )
    most, least = min(most_frames(scene, name) for name in bodies), max(fewest_cut(scene, name) for name in bodies)
    can_be = {EVERY_ELEMENT, "1", *map(str, range(least, most + 1))}
    if wrong := [word for word in given if word not in can_be]:
        raise InputError(
            f"--axes: frames={wrong[0]!r} cannot be meant; give {'' if least == 2 else '1, or '}whole numbers from "
            f"{1 if least == 2 else least} to {most}, the elements of the body, or {EVERY_ELEMENT}."
        )
    own = {scene.bodies[name].frames for name in bodies}  # type: ignore[attr-defined]
    words = given or [word for word in NUMBERS if word == EVERY_ELEMENT or (word in can_be and int(word) < most)]
    if not given and len(own) == 1 and isinstance(mine := next(iter(own)), int):
        words = [str(mine), *words]
    return [Choice(word, frames=_meant(word), own=own == {_meant(word)}) for word in dict.fromkeys(words)]


def framed(scene: Scene, frames: int | str | None) -> Scene:
    """The scene with so many frames in all bodies that can have them; None leaves it as it is."""
    if frames is None:
        return scene
    return with_frames(scene, {name: most_frames(scene, name) if isinstance(frames, str) else frames for name in cuttable(scene)})


def _meant(word: str) -> int | str:
    return word if word == EVERY_ELEMENT else int(word)
