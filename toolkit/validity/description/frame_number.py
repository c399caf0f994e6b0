"""Numbers of floating frames that were chosen, and the error that decided."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from toolkit.bodies.cut.cuttable_body import ChosenFrames, CuttableBody
from toolkit.foundation.verdict import SCENE, Caution, check
from toolkit.scene.scene import Scene

ANALYSES = {"static": "equilibrium", "transient": "motion"}


def frames_chosen(scene: Scene) -> dict[str, Any]:
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
