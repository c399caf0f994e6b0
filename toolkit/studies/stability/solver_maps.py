"""Maps over settings of the solver: step and rho_inf, constants of the stabilisation."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from toolkit.description.run_options import Baumgarte
from toolkit.description.time_grid import time_grid
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import unit
from toolkit.scene.scene import Scene
from toolkit.studies.stability.map import Axis, Map, over, with_options

FINER, COARSER = (100, 30, 10, 3), (3, 10, 30, 100, 300, 1000)
"""Steps, as divisors and multiples of the scene's own: half a decade apart; finer ones are whole parts, so that times stay on the grid."""
FINER_ERROR = (10, 3)
"""Likewise where the run chooses its steps: the local error falls by the cube."""
FEWEST_STEPS = 3
RADII = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
FACTORS = (0.0, 0.01, 0.1, 0.3, 1.0, 10.0, 100.0)
"""Constants of the stabilisation, in 1/step."""
DAMPING, STIFFNESS = 1.0, np.sqrt(2)
"""What they are by default."""


def refined(scene: Scene, parts: int) -> Scene:
    """The scene with every step in parts; error control with a local error that such steps would have, of third order in the step."""
    options = scene.solver
    changes: dict[str, Any] = {"step": options.step / parts}
    if options.local_error is not None:
        changes["local_error"] = options.local_error / parts**3
    if options.times is not None:
        split = [np.linspace(a, b, parts, endpoint=False) for a, b in pairwise(options.times)]
        changes["times"] = (*map(float, np.concatenate(split)), options.times[-1])
    return with_options(scene, **changes)


def finest_first(scene: Scene) -> list[Scene]:
    """Candidates for the reference: the scene refined, as it stands, and with coarser steps."""
    coarser = [with_options(scene, step=step) for step in coarser_steps(scene)] if scene.solver.times is None else []
    parts = FINER if scene.solver.local_error is None else FINER_ERROR
    return [*(refined(scene, each) for each in (*parts, 1)), *coarser]


def coarser_steps(scene: Scene) -> list[float]:
    """Multiples of the scene's step."""
    own, end = scene.solver.step, scene.solver.end_time
    return [own * times for times in COARSER if own * times <= end / FEWEST_STEPS]


def steps_needed(scene: Scene) -> int:
    """Steps of a scene, by its times or its (largest) step."""
    options = scene.solver
    return len(options.times) - 1 if options.times else int(np.ceil(options.end_time / options.step * (1 - 1e-9)))


def step_map(scene: Scene, most_steps: int) -> Map:
    """Step x rho_inf, with steps of which at most `most_steps` are needed.

    Raises
    ------
    InputError
        The scene gives its times, or none of the steps is allowed.
    """
    if scene.solver.times is not None:
        raise InputError("the scene gives its times, so that no step can be chosen")
    rho, own = scene.solver.rho_inf, scene.solver.step
    wanted = (*(own / parts for parts in FINER), own, *coarser_steps(scene))
    steps = tuple(step for step in wanted if steps_needed(with_options(scene, step=step)) <= most_steps)
    if not steps:
        raise InputError(f"every step needs more than {most_steps} steps (--most-steps)")
    radii = tuple(sorted({*RADII, rho}))
    axes = (
        Axis("step", steps, steps.index(own) if own in steps else None, unit=unit(scene.units, "time")),
        Axis("rho_inf", radii, radii.index(rho)),
    )
    scenes = over(axes, lambda step, radius: with_options(scene, step=step, rho_inf=radius))
    return Map("step", "step x rho_inf", axes, scenes, "reference")


def baumgarte_map(scene: Scene) -> Map:
    """Damping x stiffness of the stabilisation of the joints, in 1/step.

    Raises
    ------
    InputError
        The scene has no joints, or its formulation needs no stabilisation.
    """
    if not scene.joints:
        raise InputError("the scene has no joints, so nothing is stabilised")
    if scene.solver.formulation != "index-1":
        raise InputError("the scene's formulation keeps positions on the joints without stabilisation")
    step = float(time_grid(scene.solver)[1])
    written = scene.solver.baumgarte
    own = [
        default if value is None else float(value) * step
        for value, default in ((written.damping, DAMPING), (written.stiffness, STIFFNESS))
    ]
    names = ("damping x step", "stiffness x step")
    values = [tuple(sorted({*FACTORS, round(value, 12)})) for value in own]
    axes = tuple(Axis(name, found, found.index(round(value, 12))) for name, found, value in zip(names, values, own, strict=True))
    scenes = over(axes, lambda a, b: with_options(scene, baumgarte=Baumgarte(damping=a / step, stiffness=b / step)))
    return Map("baumgarte", "stabilisation (Baumgarte): damping x stiffness", axes, scenes, "reference")
