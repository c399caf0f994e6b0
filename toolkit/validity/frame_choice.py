"""Which reference condition a flexible body should have, and numbers of floating frames that were chosen.

Which reference condition a flexible body should have, by the joints that hold it.

Forces between two points of a body act along the line through both. In a frame that is tied to one end, this line turns with the
deformation, and linear FFRF lets the forces turn with the frame instead: their lever arms are wrong by as much as the deflection itself. A
frame on the chord goes with the line, and no force along it bends the body. A body that is clamped at one end has its forces in the frame
of this end.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from toolkit.components.bodies.cut_body import CutBody
from toolkit.components.bodies.cuttable_body import ChosenFrames, CuttableBody
from toolkit.components.bodies.model_body import ModelBody
from toolkit.components.joints.joint import Joint
from toolkit.foundation.errors import quoted
from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.value_types import Record
from toolkit.foundation.verdict import SCENE, Caution, check
from toolkit.reduced_model.model import MEAN_AXES, Chord, chord_of
from toolkit.scene.scene import Scene


@dataclass(frozen=True)
class FrameChoice:
    """Reference condition that the joints of a scene ask for in the frame of one body."""

    condition: str  # of its model, in words
    reason: str
    advice: str  # empty if the model has the frame that its joints ask for
    chord: Chord | None = None  # that its joints ask for

    @property
    def words(self) -> str:
        """A phrase with the condition, the reason and the advice."""
        return f"{self.condition}; {self.reason}" + (f": {self.advice}" if self.advice else ", as it should be")


def frame_choices(scene: Scene) -> dict[str, FrameChoice]:
    """Flexible bodies with a frame that turns -> the choice that their joints ask for; bodies without one are left out."""
    return {
        name: found
        for name, body in scene.bodies.items()
        if isinstance(body, ModelBody) and not isinstance(body, CutBody) and (found := _choice(scene, name, body))
    }


def advice_of_frame(scene: Scene, body: str) -> str:
    """Sentence with advice on the frame of one body, to be appended; empty if there is nothing to do."""
    found = frame_choices(scene).get(body)
    return f" It is {found.reason}: {found.advice}." if found and found.advice else ""


def _choice(scene: Scene, name: str, body: ModelBody) -> FrameChoice | None:
    if not body.turns:
        return None
    condition = scene.model(body.model).reference_condition
    held = dict(_held(scene, name))
    clamped = [point for point, whole in held.items() if whole]
    if not clamped and len(held) > 1:
        return _on_chord(scene, body, condition, list(held))
    if len(clamped) == 1 and len(held) == 1:
        return _at_end(condition, clamped[0])
    return None


def _held(scene: Scene, name: str) -> Iterator[tuple[str, bool]]:
    """Interface points of a body that joints grip, and whether these hold all its rotations there."""
    turns, interfaces = Counter[str](), scene.model(scene.bodies[name].model).interfaces or {}  # type: ignore[attr-defined]
    for joint in (each for each in scene.joints.values() if isinstance(each, Joint)):
        for grip, point in joint.grips:
            interface = getattr(scene.points[point], "interface", None)
            if grip == name and interface in interfaces:
                turns[interface] += sum(quantity == "angle" for _, quantity in joint.rows)
    rotations = scene.dimension * (scene.dimension - 1) // 2
    yield from ((interface, count >= rotations) for interface, count in turns.items())


def _on_chord(scene: Scene, body: ModelBody, condition: str, held: list[str]) -> FrameChoice | None:
    """Advice for a frame on the chord through those two points held by joints that are farthest apart."""
    interfaces = scene.model(body.model).interfaces or {}
    pairs = [Chord(one, other) for k, one in enumerate(held) for other in held[k + 1 :]]
    place = {name: interfaces[name].here[0][:, 0] for name in held}
    apart = np.array([np.linalg.norm(place[one] - place[other]) for one, other in pairs])
    if not apart.max() > 0:
        return None
    chord, now = pairs[first_largest(apart)], chord_of(condition)
    good = condition == MEAN_AXES or (now is not None and set(now) <= set(held))
    return FrameChoice(
        condition,
        f"held at {quoted(held)} by joints that let it turn",
        ""
        if good
        else f"a frame through these points leaves out much less of their forces, basis.chord = {_list(chord)} in the file that its model "
        "is built from",
        chord,
    )


def _at_end(condition: str, point: str) -> FrameChoice:
    return FrameChoice(
        condition,
        f"clamped at {point!r} alone",
        "a frame that is clamped there leaves out less of its forces, clamp instead of basis.chord in the file that its model is built from"
        if chord_of(condition)
        else "",
    )


def _list(names: Chord) -> str:
    return f'["{names.first}", "{names.second}"]'


ANALYSES = {"static": "equilibrium", "transient": "motion"}


def frames_chosen(scene: Scene) -> Record:
    """Body -> its number of frames and the error it was chosen by, for the bodies whose number was chosen."""
    return {
        name: {"frames": number, "kept_run": choice.kept_run}
        if choice.kept_run
        else {
            "frames": number,
            "wanted_error": choice.wanted,
            "estimated_error": choice.error,
            "relative_to": "the largest displacement of the body",
            "tried": list(choice.numbers),
            "analysis": ANALYSES[choice.analysis],
            **({"for_gradients": [{"frames": n, "estimated_error": e} for n, e in choice.gradients]} if choice.gradients else {}),
        }
        for name, (number, choice) in choices_in(scene).items()
    }


@check("frames", (SCENE,))
def choices_of_frames(scene: Scene) -> Iterator[Caution]:
    """What number of floating frames `frames = "auto"` has chosen, and by what.

    Limit: always.
    Fix: writing the number spares the runs that choose it.
    """
    for name, (number, choice) in choices_in(scene).items():
        if choice.kept_run:
            yield choices_of_frames.caution(
                f'{name} has {number} floating {"frame" if number == 1 else "frames"}, by frames = "auto": those of the run that '
                f"{choice.kept_run} keeps, which the scene starts in. How far they suffice was told there.{_unreduced(scene, name)}",
                doubt=False,
            )
            continue
        if choice.failed:
            continue
        runs = " and ".join(filter(None, [", ".join(map(str, choice.numbers[:-1])), str(choice.numbers[-1])]))
        yield choices_of_frames.caution(
            f'{name} has {number} floating {"frame" if number == 1 else "frames"}, by frames = "auto": the {ANALYSES[choice.analysis]} of '
            f"the scene as it is written, with {runs} frames, leaves about {choice.error:.1%} of its largest displacement "
            f"({choice.wanted:.3g} is wanted; the error falls with the square of the number).{_of_gradients(number, choice)} "
            f"frames = {number} spares these runs.{_unreduced(scene, name)}",
            doubt=False,
        )


@check("frames-not-known", (SCENE,))
def unknown_choices(scene: Scene) -> Iterator[Caution]:
    """A trial of `frames = "auto"` failed, so that what more frames would change is not known, or only estimated.

    Limit: a doubt if the estimated error exceeds `geometric_error`.
    Fix: that number of frames, written, to see why it fails; or a smaller step.
    """
    for name, (number, choice) in choices_in(scene).items():
        if not choice.failed or choice.kept_run:
            continue
        by = "by comparison with fewer" if len(choice.numbers) > 1 else "by the meter of large deformation alone"
        yield unknown_choices.caution(
            f'{name} has {number} floating {"frame" if number == 1 else "frames"}, by frames = "auto", and whether they suffice is not '
            f"known: a run with {choice.failed} failed. They leave about {choice.error:.1%} of its largest displacement, {by} "
            f"({choice.wanted:.3g} is wanted). Write frames = {choice.failed} to see why that fails, or a smaller solver.step."
            f"{_unreduced(scene, name)}",
            doubt=not choice.error <= choice.wanted,
        )


def _unreduced(scene: Scene, name: str) -> str:
    """Sentence that one frame leaves `modes_per_frame` no parts to reduce; empty where it does."""
    body = scene.bodies[name]
    if not isinstance(body, CuttableBody) or body.choice is None or body.frames != 1 or body.modes_per_frame is None:
        return ""
    return (
        " With one frame the body keeps all coordinates, and modes_per_frame reduces nothing: leave it out, or write frames = [], which "
        "is one part on a chord, reduced."
    )


def _of_gradients(number: int, choice: ChosenFrames) -> str:
    """Sentence on the errors of gradients with the numbers that were tried; empty without gradients."""
    if not choice.gradients:
        return ""
    tried = [f"{frames} would leave {error:.1%}" for frames, error in choice.gradients if frames != number]
    reached = [f"{number} leaves {error:.1%}" for frames, error in choice.gradients if frames == number]
    return f" Of the worst of the gradients {', '.join([*tried, *reached])}, by comparison with twice as many."


def choices_in(scene: Scene) -> dict[str, tuple[int, ChosenFrames]]:
    """Body -> its number of frames and the choice, for the bodies whose number was chosen."""
    found = {}
    for name, body in scene.bodies.items():
        if isinstance(body, CuttableBody) and body.choice is not None:
            assert isinstance(body.frames, int)
            found[name] = (body.frames, body.choice)
    return found
