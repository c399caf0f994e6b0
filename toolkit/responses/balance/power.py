"""Power of a load or of a driver."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Self

import numpy as np
from pydantic import model_validator

from toolkit.bodies.body import CENTRE
from toolkit.description.description import Description
from toolkit.foundation.errors import InputError
from toolkit.loads.gravity import UniformGravity
from toolkit.loads.load import Load
from toolkit.responses.balance.mass import masses
from toolkit.responses.balance.power_of_load import power_of_load
from toolkit.responses.kinematics.marker_formula import one_of
from toolkit.responses.kinematics.marker_motion import MarkerMotion, Motion
from toolkit.responses.kinematics.rates import OfRates
from toolkit.responses.response import Partials
from toolkit.scene.resolution import ResolvedScene
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


class Doer(Description):
    """Base of responses that measure what a load or the driver of a joint does to the scene.

    Attributes
    ----------
    load
        Name of a load.
    joint
        Name of a joint with a driver; give this or a load.
    """

    load: str | None = None
    joint: str | None = None

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.load is None) == (self.joint is None):
            raise ValueError("give one of `load` and `joint`: the load, or the joint with a driver, that does the work")
        return self


class Power(Doer, OfRates):
    """Power of a load or of a driver: what it puts into the scene per time; a damper takes it out, which is negative.

        load: P = f . w,      driver: P = - lam s'(t)

    with the forces f on both markers and their rates w, the driver's multiplier lam and its time curve s.
    """

    kind = "power"
    quantity = "power"

    def check(self, scene: Any) -> None:
        """Refuse a load whose power is not known, and a joint without a driver.

        Raises
        ------
        InputError
            It is a pressure, or a joint without a driver; lists what can be asked for.
        """
        super().check(scene)
        known = [name for name, load in scene.loads.items() if isinstance(load, Load | UniformGravity)]
        if self.load is not None and self.load not in known:
            raise InputError(
                f"the power of load {self.load!r} is not known: it presses on a surface. Loads with a power: {', '.join(known) or 'none'}."
            )
        driven = [name for name, joint in scene.joints.items() if joint.time_curve is not None]
        if self.joint is not None and self.joint not in driven:
            raise InputError(
                f"joint {self.joint!r} has no driver, so it does no work; joints with a driver: {', '.join(driven) or 'none'}."
            )

    def grips(self, scene: ResolvedScene) -> tuple[tuple[str, str], ...]:
        """Pairs of body and centre of mass where gravity acts; empty for other loads, whose points are there anyway."""
        gravity = self.load is not None and isinstance(scene.loads[self.load], UniformGravity)
        return tuple((name, CENTRE) for name in scene.pieces()) if gravity else ()

    def at(self, solution: Solution, step: int) -> Partials:
        """Power and its partial derivatives at a step."""
        return self.instants(solution)(step)

    def instants(self, solution: Solution) -> Callable[[int], Partials]:
        """Power and its partial derivatives, step by step, of a driver, of gravity, or of a load between two markers."""
        if self.joint is not None:
            return _of_driver(solution, self.joint)
        assert self.load is not None
        gravity = isinstance(solution.system.scene.loads[self.load], UniformGravity)
        return (power_of_gravity if gravity else power_of_load)(solution, self.load)


def _of_driver(solution: Solution, joint: str) -> Callable[[int], Partials]:
    system, joints = solution.system, solution.system.plan.joints
    j = list(system.scene.joints).index(joint)
    row, curve = joints.row[j] + joints.n_rows[j] - 1 - system.n_q, joints.curve[j]
    curves, curves_x = system.curves(solution.times)

    def look(step: int) -> Partials:
        lam, rate = solution.multipliers[step], curves[step, curve, 1]
        slope: np.ndarray = np.zeros(len(lam), system.dtype)
        slope[row] = -rate
        design = np.zeros(system.n_x)
        active = system.plan.curve_index == curve
        np.add.at(design, system.plan.curve_variable[active], -np.real(lam[row]) * curves_x[step, active, 1])
        return Partials(-lam[row] * rate, multipliers=slope, design=design)

    return look
