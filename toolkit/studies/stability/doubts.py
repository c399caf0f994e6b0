"""What has to be known before the maps of a study are believed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from toolkit.validity.scene_cautions import cautions_of_scene
from toolkit.validity.stale_models import stale_models
from toolkit.validity.verdict import Caution, Verdict

if TYPE_CHECKING:
    from toolkit.studies.stability.study import Study

ENDS = {"failed": "fails", "refused": "is refused", "not run": "is not run"}
"""Class of the scene itself -> what it does, for those that give no number."""


def verdict_of(study: Study) -> Verdict:
    """Whether the classes of the cells mean what they say, and why not."""
    cautions = [*_of_the_scene_itself(study), *_of_the_reference(study)]
    return Verdict.of([*cautions, *cautions_of_scene(study.scene), *stale_models(study.scene)])


def _of_the_scene_itself(study: Study) -> Iterator[Caution]:
    if study.own.run.name in ENDS:
        text = f"the scene {ENDS[study.own.run.name]} as it stands: {study.own.run.reason}"
        yield Caution("as-it-stands", text, doubt=False)
    if not study.design:
        text = "the scene declares no design variables, so no gradient is judged. Name some with --variables."
        yield Caution("no-gradient", text, doubt=False)


def _of_the_reference(study: Study) -> Iterator[Caution]:
    best, limit = study.reference, study.limits.accuracy
    if not study.scene.responses:
        yield Caution("no-responses", "the scene has no responses, so a wrong motion that ends in good order is not seen.")
    elif not any(each.map.judge == "reference" for each in study.maps):
        return
    elif best is None:
        yield Caution("no-reference", "the scene runs in good order with no step, so maps of the solver have no reference.")
    elif best.next_values > limit or (study.design and best.next_slopes > limit):
        yield Caution(
            "coarse-reference",
            f"the finest step, {best.step:.3g}, differs from the next by {100 * best.next_values:.3g} % in the responses and "
            f"{100 * best.next_slopes:.3g} % in the gradient, so `inaccurate` means little in maps of the solver: the motion may be "
            "chaotic, or needs a smaller solver.step.",
        )
