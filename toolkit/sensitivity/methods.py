"""All methods for gradients behind one call."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from toolkit.foundation.errors import NeedsDirectError
from toolkit.scene.scene import Scene
from toolkit.sensitivity.adjoint.adjoint import by_adjoint
from toolkit.sensitivity.choice import choose
from toolkit.sensitivity.clock import Clock, Progress, once
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
    clock: Clock = once,
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
    return by_method(method, Compiled(scene, tuple(design)), kind, progress, keep_states, clock)


def by_method(
    method: str,
    compiled: Compiled,
    kind: Kind,
    progress: Progress | None = None,
    keep_states: bool = False,
    clock: Clock = once,
) -> Run:
    """Responses with gradients of a compiled scene, by a method of `method_names.METHODS`."""
    found = _by_method(method, compiled, kind, progress, keep_states, clock)
    return replace(
        found,
        reframed=partial(_reframed, compiled, kind, found.solution),
        enriched=partial(enriched, compiled, kind, found.solution, partial(by_method, "auto")),
    )


def _by_method(method: str, compiled: Compiled, kind: Kind, progress: Progress | None, keep_states: bool, clock: Clock) -> Run:
    if method == "auto":
        return _chosen(compiled, kind, progress, keep_states, clock)
    if method == "direct":
        return by_direct(compiled, kind, progress, clock)
    if method == "adjoint":
        return by_adjoint(compiled, kind, progress, clock)
    return by_repetition(compiled, kind, method, progress, clock=clock)


def _chosen(compiled: Compiled, kind: Kind, progress: Progress | None, keep_states: bool, clock: Clock) -> Run:
    """Responses with gradients by the cheaper method, or by direct differentiation where the adjoint turns out to need it."""
    name, reason = choose(compiled, kind, keep_states)
    method = by_adjoint if name == "adjoint" else by_direct
    try:
        return replace(method(compiled, kind, progress, clock), reason=reason)
    except NeedsDirectError as refusal:
        reason = f"direct differentiation, because {refusal.why}."
        return replace(by_direct(compiled, kind, progress, clock), reason=reason)


def _reframed(
    compiled: Compiled, kind: Kind, solution: Solution, frames: Mapping[str, Frames]
) -> tuple[Mapping[str, float], Mapping[str, Mapping[str, float]]]:
    """Values and gradients of a compiled scene with other frames and the same steps."""
    other = compiled.reframed(frames)
    if kind == "transient" and (compiled.scene.solver.local_error is not None or solution.halved):
        other = Compiled(frozen(other.scene, solution, compiled.scene.solver.halvings), other.names)
    found = by_method("auto", other, kind)
    return found.values, found.gradients
