"""This toolkit's settings: what a user would write, through the public call."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import ffrf
from tests.benchmarks.peers.contest import Maker

SETTINGS = {
    f"{formulation}, {newton} Newton": {"formulation": formulation, "newton": newton}
    for formulation in ("index-1", "index-3")
    for newton in ("full", "modified")
}


def makers(scene: ffrf.Scene, end_time: float, rho_inf: float, result: Callable[[ffrf.Run], np.ndarray]) -> dict[str, Maker]:
    """Two formulations with both kinds of Newton iteration; `result` reads what is compared from a run."""

    def maker(setting: dict[str, str]) -> Maker:
        def make(step: float) -> Callable[[], np.ndarray]:
            options = scene.solver.model_copy(update={"end_time": end_time, "step": step, "rho_inf": rho_inf, **setting})
            model = ffrf.compile(scene.model_copy(update={"solver": options}))
            _ = model._compiled.analysed_by("transient").primal.evaluator  # what the first motion would compile
            return lambda: result(model.simulate())

        return make

    return {f"ffrf, {name}": maker(setting) for name, setting in SETTINGS.items()}
