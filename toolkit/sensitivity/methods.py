"""All methods for gradients behind one call."""

from __future__ import annotations

from dataclasses import replace

from toolkit.foundation.errors import NeedsDirectError
from toolkit.scene.scene import Scene
from toolkit.sensitivity.adjoint.adjoint import adjoint
from toolkit.sensitivity.analysis import Kind, Progress, Result, direct
from toolkit.sensitivity.choice import choose
from toolkit.sensitivity.numerical import numerical


def gradients_by(
    method: str, scene: Scene, design: list[str], kind: Kind, progress: Progress | None = None, keep_states: bool = False
) -> Result:
    """Responses with gradients by a method of `method_names.METHODS`.

    "direct" costs little per variable, "adjoint" next to nothing per variable but a backward run for all responses together, "auto" takes
    the cheaper of the two and says why in the result's `reason`; the numerical methods run the whole analysis for every variable.
    `keep_states`: "auto" shall provide derivatives of the states too.

    Raises
    ------
    InputError
        The method is unknown.
    """
    if method == "auto":
        return _chosen(scene, design, kind, progress, keep_states)
    if method == "direct":
        return direct(scene, design, kind, progress)
    if method == "adjoint":
        return adjoint(scene, design, kind, progress)
    return numerical(scene, design, kind, method, progress)


def _chosen(scene: Scene, design: list[str], kind: Kind, progress: Progress | None, keep_states: bool) -> Result:
    """By the cheaper method, or by direct differentiation where the adjoint turns out to need it."""
    choice = choose(scene, design, kind, keep_states)
    method = adjoint if choice.method == "adjoint" else direct
    try:
        return replace(method(scene, design, kind, progress, choice.system), reason=choice.reason)
    except NeedsDirectError as refusal:
        reason = f"direct differentiation, because {refusal.why}."
        return replace(direct(scene, design, kind, progress, choice.system), reason=reason)
