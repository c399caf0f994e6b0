"""Power of gravity: of the weights of all bodies at their centres of mass."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from toolkit.bodies.body import CENTRE
from toolkit.loads.gravity import UniformGravity
from toolkit.responses.balance.mass import masses
from toolkit.responses.kinematics.marker_formula import one_of
from toolkit.responses.kinematics.marker_motion import MarkerMotion, Motion
from toolkit.responses.response import Partials
from toolkit.system.solution import Solution


def power_of_gravity(solution: Solution, name: str) -> Callable[[int], Partials]:
    """Power P = sum m_b g . r_b' of the gravity load of that name, step by step."""
    system, scene = solution.system, solution.system.scene
    names, load, d = scene.pieces(), scene.loads[name], scene.dimension
    assert isinstance(load, UniformGravity)
    values, by_x = masses(system, names)
    motion, g = MarkerMotion.of(system, [(body, CENTRE) for body in names]), np.array(load.acceleration)
    by_g = [
        (x, _place(path), factor)
        for x, variable in enumerate(system.design)
        for path, factor in zip(variable.paths, variable.factors, strict=True)
        if path.startswith(f"loads.{name}.")
    ]

    def look(step: int) -> Partials:
        motions = motion.at(solution, step)
        rates = np.array([each.rate[:d] for each in motions])
        along: np.ndarray = np.zeros((1, len(motions[0].y)), system.dtype)
        along[0, :d] = g
        design = (np.real(rates @ g) @ by_x)[None]
        for x, k, factor in by_g:
            design[0, x] += factor * np.real(values @ rates)[k]
        slopes = [Motion(rate=mass * along) for mass in values]
        return one_of(motion.partials(np.array([values @ rates @ g]), slopes, design), 0, solution, step)

    return look


def _place(path: str) -> int:
    """Number of the component of a vector that a path leads to."""
    last = path.rpartition(".")[2]
    return "xyz".index(last) if last in "xyz" else int(last)
