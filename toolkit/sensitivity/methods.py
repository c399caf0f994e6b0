"""All methods for gradients behind one call."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from toolkit.foundation.errors import NeedsDirectError
from toolkit.scene.scene import Scene
from toolkit.sensitivity.adjoint.adjoint import by_adjoint
from toolkit.sensitivity.choice import choose
from toolkit.sensitivity.clock import Progress
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.direct import by_direct, enriched
from toolkit.sensitivity.frames.chosen_frames import Frames
from toolkit.sensitivity.numerical import by_repetition
from toolkit.sensitivity.preparation import Kind, check_kind, check_names, frozen
from toolkit.sensitivity.run import Run
from toolkit.system.solution import Solution


def gradients_by(
    method: str,
    scene: Scene,
    design: list[str],
    kind: Kind,
    progress: Progress | None = None,
    keep_states: bool = False,
    timed: bool = False,
) -> Run:
    """Responses with gradients by a method of `method_names.METHODS`.

    "direct" costs little per variable, "adjoint" next to nothing per variable but a backward run for all responses together, "auto" takes
    the cheaper of the two and says why in the result's `reason`; the numerical methods run the whole analysis for every variable.
    `keep_states`: "auto" shall provide derivatives of the states too.

    Raises
    ------
    InputError
        The method is unknown.
    """
    check_kind(kind)
    check_names(design)
    return by_method(method, Compiled(scene, tuple(design)), kind, progress, keep_states, timed)


def by_method(
    method: str,
    compiled: Compiled,
    kind: Kind,
    progress: Progress | None = None,
    keep_states: bool = False,
    timed: bool = False,
) -> Run:
    """Responses with gradients of a compiled scene, by a method of `method_names.METHODS`."""
    chosen, reason = choose(compiled, kind, keep_states) if method == "auto" else (method, "")
    try:
        if chosen in DIFFERENTIATED:
            found = DIFFERENTIATED[chosen](compiled, kind, progress, timed)
        else:
            found = by_repetition(compiled, kind, method, progress, timed=timed)
    except NeedsDirectError as refusal:
        if method != "auto":
            raise
        found, reason = by_direct(compiled, kind, progress, timed), f"direct differentiation, because {refusal.why}."
    return replace(
        found,
        reason=reason,
        reframed=partial(_reframed, compiled, kind, found.solution),
        enriched=partial(enriched, compiled, kind, found.solution, partial(by_method, "auto")),
    )


DIFFERENTIATED = {"direct": by_direct, "adjoint": by_adjoint}
"""Exact method -> function that solves a scene with gradients by it."""


def _reframed(
    compiled: Compiled, kind: Kind, solution: Solution, frames: Mapping[str, Frames]
) -> tuple[Mapping[str, float], Mapping[str, Mapping[str, float]]]:
    """Values and gradients of a compiled scene with other frames and the same steps."""
    other = compiled.reframed(frames)
    if kind == "transient" and (compiled.scene.solver.local_error is not None or solution.halved):
        other = Compiled(frozen(other.scene, solution, compiled.scene.solver.halvings), other.names)
    found = by_method("auto", other, kind)
    return found.values, found.gradients
