"""All methods for gradients behind one call."""

from __future__ import annotations

from toolkit.errors import InputError
from toolkit.scene import Scene
from toolkit.sensitivity.adjoint import adjoint
from toolkit.sensitivity.analysis import Kind, Progress, Result, direct
from toolkit.sensitivity.numerical import METHODS as NUMERICAL
from toolkit.sensitivity.numerical import numerical

METHODS = ("direct", "adjoint", *NUMERICAL)


def gradients_by(method: str, scene: Scene, design: list[str], kind: Kind, progress: Progress | None = None) -> Result:
    """Responses with gradients by a method of `METHODS`.

    "direct" costs little per variable, "adjoint" little per variable but a backward run for all responses together; the numerical
    methods run the whole analysis for every variable.

    Raises
    ------
    InputError
        The method is unknown.
    """
    if method not in METHODS:
        raise InputError(f"unknown method {method!r}; available: {', '.join(METHODS)}.")
    if method == "direct":
        return direct(scene, design, kind, progress)
    if method == "adjoint":
        return adjoint(scene, design, kind, progress)
    return numerical(scene, design, kind, method, progress)
