"""What has to be known before the maps of a study are believed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from toolkit.foundation.verdict import Caution, Verdict
from toolkit.scene.scene import Scene
from toolkit.studies.stability.found import Cell, Mapped, Reference
from toolkit.studies.stability.solver_maps import finest_first, steps_needed
from toolkit.studies.stability.verdict import Limits
from toolkit.validity.description.scene_cautions import cautions_of_scene

ENDS = {"failed": "fails", "refused": "is refused", "not run": "is not run"}
"""Class of the scene itself -> what it does, for those that give no number."""


def verdict_of(
    scene: Scene,
    design: Sequence[str],
    limits: Limits,
    own: Cell,
    reference: Reference | None,
    maps: Sequence[Mapped],
    most_steps: int,
) -> Verdict:
    """Whether the classes of the cells mean what they say, and why not; the arguments are fields of `found.Study`, and of `stability`."""
    cautions = [*_of_the_scene_itself(own, design), *_of_the_reference(scene, design, limits, reference, maps)]
    if scene.responses and any(each.map.judge == "reference" for each in maps):
        cautions += _of_what_was_cut_off(scene, reference, most_steps)
    return Verdict.of([*cautions, *cautions_of_scene(scene)])


def _of_the_scene_itself(own: Cell, design: Sequence[str]) -> Iterator[Caution]:
    if own.run.name in ENDS:
        yield Caution("as-it-stands", f"the scene {ENDS[own.run.name]} as it stands: {own.run.reason}", doubt=False)
    if not design:
        text = "the scene declares no design variables, so no gradient is judged. Name some with --variables."
        yield Caution("no-gradient", text, doubt=False)


def _of_the_reference(
    scene: Scene, design: Sequence[str], limits: Limits, best: Reference | None, maps: Sequence[Mapped]
) -> Iterator[Caution]:
    if not scene.responses:
        yield Caution("no-responses", "the scene has no responses, so a wrong motion that ends in good order is not seen.")
    elif not any(each.map.judge == "reference" for each in maps):
        return
    elif best is None:
        yield Caution("no-reference", "no two steps that were tried run in good order, so maps of the solver have no reference.")
    elif best.next_values > limits.accuracy or (design and best.next_slopes > limits.accuracy):
        yield Caution(
            "coarse-reference",
            f"the finest step, {best.step:.3g}, differs from the next by {100 * best.next_values:.3g} % in the responses and "
            f"{100 * best.next_slopes:.3g} % in the gradient, so `inaccurate` means little in maps of the solver: the motion may be "
            "chaotic, or needs a smaller solver.step.",
        )


def _of_what_was_cut_off(scene: Scene, best: Reference | None, most_steps: int) -> Iterator[Caution]:
    """Runs for the reference that were left out because of their steps; a doubt where it is no finer than the scene."""
    wanted = [each for each in finest_first(scene) if steps_needed(each) > most_steps]
    if wanted:
        known = f"so that the reference has the step {best.step:.3g}" if best else "so that there is no reference"
        yield Caution(
            "cut-reference",
            f"steps down to {wanted[0].solver.step:.3g} were wanted for the reference, but those up to {wanted[-1].solver.step:.3g} need "
            f"more than {most_steps:g} steps (--most-steps), {known}.",
            doubt=best is None or best.step >= scene.solver.step,
        )
