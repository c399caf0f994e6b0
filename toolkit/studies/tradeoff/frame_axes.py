"""The axes of floating frames: into how many parts bodies that deform far are cut, and to how few modes these are reduced."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from toolkit.analyses.sensitivity.chosen_frames import with_frames
from toolkit.foundation.errors import InputError
from toolkit.scene.resolution import cuttable, fewest_cut, most_frames
from toolkit.scene.scene import Scene
from toolkit.studies.tradeoff.setting import ALL_SHAPES, EVERY_ELEMENT, Choice

AXES = {
    "frames": "1/2/4/8/every: floating frames of the bodies that can have several; `every`: one to each element",
    "modes_per_frame": "0/1/2/4/8/all: modes that the parts of these keep; `all`: all coordinates",
}
NUMBERS = ("1", "2", "4", "8", EVERY_ELEMENT)
MODES = ("0", "1", "2", "4", "8", ALL_SHAPES)


def choices(scene: Scene, name: str, given: Sequence[str]) -> list[Choice]:
    """Choices of an axis; the default ones if none are given.

    Raises
    ------
    InputError
        No body can have several frames, or a value is invalid.
    """
    bodies = cuttable(scene)
    if not bodies:
        raise InputError(
            f"--axes: {name} needs a flexible body whose model is made of beams with all nodal coordinates; this scene has none. Leave the "
            "axis out."
        )
    return _of_modes(scene, bodies, given) if name == "modes_per_frame" else _of_frames(scene, bodies, given)


def _of_modes(scene: Scene, bodies: Sequence[str], given: Sequence[str]) -> list[Choice]:
    if wrong := [word for word in given if word != ALL_SHAPES and not word.isdecimal()]:
        raise InputError(f"--axes: modes_per_frame={wrong[0]!r} is invalid; give whole numbers from 0 on, or {ALL_SHAPES}.")
    own = {ALL_SHAPES if (n := _number(scene, body, "modes_per_frame")) is None else n for body in bodies}
    words = given or (list(dict.fromkeys([*map(str, own), *MODES])) if len(own) == 1 else MODES)
    meant = {word: word if word == ALL_SHAPES else int(word) for word in words}
    return [Choice(word, modes=modes, own=own == {modes}) for word, modes in meant.items()]


def refuse_idle(scene: Scene, axes: Collection[str]) -> None:
    """Refuse modes of parts where no body has parts.

    Raises
    ------
    InputError
        The axis of modes is varied, that of frames is not, and no body has several frames.
    """
    if (
        "modes_per_frame" in axes
        and "frames" not in axes
        and all(_number(scene, each, "frames") == 1 for each in cuttable(scene))
    ):
        raise InputError(
            "--axes: modes_per_frame reduces the parts of bodies with several frames, and no body has any. Vary the axis frames too, or "
            "write bodies.NAME.frames."
        )


def _number(scene: Scene, body: str, key: str) -> Any:
    return getattr(scene.bodies[body], key)


def _of_frames(scene: Scene, bodies: Sequence[str], given: Sequence[str]) -> list[Choice]:
    most, least = min(most_frames(scene, name) for name in bodies), max(fewest_cut(scene, name) for name in bodies)
    can_be = {EVERY_ELEMENT, "1", *map(str, range(least, most + 1))}
    if wrong := [word for word in given if word not in can_be]:
        raise InputError(
            f"--axes: frames={wrong[0]!r} is invalid; give {'' if least == 2 else '1, or '}whole numbers from "
            f"{1 if least == 2 else least} to {most}, the elements of the body, or {EVERY_ELEMENT}."
        )
    own = {scene.bodies[name].frames for name in bodies}  # type: ignore[attr-defined]
    words = given or [word for word in NUMBERS if word == EVERY_ELEMENT or (word in can_be and int(word) < most)]
    if not given and len(own) == 1 and isinstance(mine := next(iter(own)), int):
        words = [str(mine), *words]
    return [Choice(word, frames=_meant(word), own=own == {_meant(word)}) for word in dict.fromkeys(words)]


def framed(scene: Scene, frames: int | str | None, modes: int | str | None = None) -> Scene:
    """The scene with so many frames in all bodies that can have them, and modes in their parts; None leaves these unchanged."""
    bodies = cuttable(scene) if frames is not None or modes is not None else []
    if frames is not None:
        scene = with_frames(scene, {name: most_frames(scene, name) if isinstance(frames, str) else frames for name in bodies})
    return scene if modes is None else _with_modes(scene, bodies, None if isinstance(modes, str) else modes)


def _with_modes(scene: Scene, bodies: Sequence[str], modes: int | None) -> Scene:
    """The scene with so many modes in the parts of bodies that have any."""
    parted = {name: body for name in bodies if (body := scene.bodies[name]).frames != 1}  # type: ignore[attr-defined]
    changed = {name: body.model_copy(update={"modes_per_frame": modes}) for name, body in parted.items()}
    return scene.model_copy(update={"bodies": {**scene.bodies, **changed}})


def _meant(word: str) -> int | str:
    return word if word == EVERY_ELEMENT else int(word)
