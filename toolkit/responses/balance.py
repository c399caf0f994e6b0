"""Mass of bodies, and power and work of loads and drivers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal, Self

import numpy as np
from pydantic import field_validator, model_validator

from toolkit.components.bodies.body import CENTRE
from toolkit.components.loads.gravity import UniformGravity
from toolkit.components.loads.load import Load
from toolkit.description.description import Description
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import LABELLED, Dimension, unit
from toolkit.responses.marker_formula import MarkerMotion, Motion, one_of, place_of, refuse_component
from toolkit.responses.over_time import Integral
from toolkit.responses.point_motion import OfRates
from toolkit.responses.response import Instant, Partials
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.dependence import items_of
from toolkit.system.numbering import grips_of
from toolkit.system.quantities import STEP, named_loads
from toolkit.system.solution import Solution
from toolkit.system.system import System

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Scalar
    from toolkit.scene.resolution import ResolvedScene


class OfBodies(Instant):
    """Base of responses of the whole scene, or of some of its bodies.

    Attributes
    ----------
    bodies
        Names of the bodies; all of the scene by default.
    """

    bodies: tuple[str, ...] | None = None

    @field_validator("bodies")
    @classmethod
    def _some_once(cls, bodies: tuple[str, ...] | None) -> tuple[str, ...] | None:
        if bodies is not None and (len(set(bodies)) < len(bodies) or not bodies or "ground" in bodies):
            raise ValueError(
                "`bodies` names one or more bodies, each once, and not the ground, which has no mass; leave it out for all"
            )
        return bodies

    def names(self, scene: ResolvedScene) -> tuple[str, ...]:
        """Names of the bodies that the response counts."""
        return scene.pieces(self.bodies)


class Mass(OfBodies):
    """Mass of the scene, or of some of its bodies."""

    kind = "mass"
    quantity = "mass"

    def at(self, solution: Solution, _step: int) -> Partials:
        """Sum of the bodies' masses; it depends on the design, but on no state."""
        values, by_x = masses(solution.system, self.names(solution.system.scene))
        return Partials(values.sum(), design=by_x.sum(axis=0))


class CentreOfMass(OfBodies):
    """Position of the centre of mass of the scene, or of some of its bodies, in global axes: one component.

    Attributes
    ----------
    bodies
        Names of the bodies; all of the scene by default.
    component
        Which component, or the distance from the origin of the global axes.
    """

    kind = "centre-of-mass"
    quantity = "length"

    component: Literal["x", "y", "z", "magnitude"]

    def grips(self, scene: ResolvedScene) -> tuple[tuple[str, str], ...]:
        """Pairs of body and centre of mass, for every body that the response counts."""
        return tuple((name, CENTRE) for name in self.names(scene))

    def check(self, scene: ResolvedScene) -> None:
        """Refuse a z component in a planar scene."""
        super().check(scene)
        refuse_component(self.component, scene, self.kind)

    def at(self, solution: Solution, step: int) -> Partials:
        """One component of sum m_b r_b / sum m_b at a step, with its partial derivatives."""
        return self.instants(solution)(step)

    def instants(self, solution: Solution) -> Callable[[int], Partials]:
        """One component of the centre of mass, step by step; masses are found once for all steps."""
        scene, system = solution.system.scene, solution.system
        values, by_x = masses(system, self.names(scene))
        motion, d, shares = MarkerMotion.of(system, self.grips(scene)), scene.dimension, values / values.sum()

        def look(step: int) -> Partials:
            motions = motion.at(solution, step)
            places = np.array([each.y[:d] for each in motions])
            centre = shares @ places
            slopes = [Motion(y=share * np.eye(d, len(motions[0].y))) for share in shares]
            by_mass = np.real((places - centre).T @ by_x / values.sum())
            return one_of(motion.partials(centre, slopes, by_mass), place_of(self.component), solution, step)

        return look


def masses(system: System, names: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Masses of some bodies (b,), and their design derivatives (b, n_x) by complex steps of the formulas that make them."""
    by_x = np.zeros((len(names), system.n_x))
    for x, variable in enumerate(system.design):
        affected = items_of(system.scene, variable.paths, system.numbering.users)
        moved = [b for b, name in enumerate(names) if ("bodies", name) in affected]
        if moved:
            stepped = system.scene.moved(variable, 1j * STEP)
            by_x[moved, x] = np.imag(_masses(stepped, [names[b] for b in moved])) / STEP
    return _masses(system.scene, list(names)), by_x


def _masses(scene: ResolvedScene, names: list[str]) -> np.ndarray:
    bodies = scene.all_bodies()
    return np.array([bodies[name].whole_mass(scene) for name in names])


def power_of_load(solution: Solution, name: str) -> Callable[[int], Partials]:
    """Power P = f . w of the load of that name, step by step, with its force law f(z, w) (see `load_kernel`):

        P_z = w . f_z,   P_w = f + w . f_w

    with the poses, the parameters and the value of the time curve in z.
    """
    system, loads = solution.system, solution.system.plan.loads
    load, k = named_loads(system.scene)[name], list(named_loads(system.scene)).index(name)
    motion, curve = MarkerMotion.of(system, grips_of(f"loads.{name}", load)), loads.curve[k]
    curves, curves_x = system.curves(solution.times)
    designs = slice(loads.design_start[k], loads.design_start[k + 1])
    active = (system.plan.curve_index == curve) & (curve >= 0)

    def look(step: int) -> Partials:
        a, b = motion.at(solution, step)
        size, w = len(a.y), np.concatenate([a.rate, b.rate, [0.0]])  # no work is done on a state
        own = solution.q[step, loads.state[k]] if loads.state[k] >= 0 else 0.0
        force, f_z, f_w = law_of_load(system, load, k, (a, b), own, curves[step, curve, 0] if curve >= 0 else 1.0)
        by_z, by_w = (w @ f_z)[None], (force + w @ f_w)[None]
        design = np.zeros((1, system.n_x))
        by_parameter = np.real(by_z[0, 2 * size + loads.design_parameter[designs]]) * loads.design_value[designs]
        np.add.at(design[0], loads.design_variable[designs], by_parameter)
        np.add.at(design[0], system.plan.curve_variable[active], np.real(by_z[0, -1]) * curves_x[step, active, 0])
        sides = [Motion(by_z[:, side], by_w[:, side]) for side in (slice(0, size), slice(size, 2 * size))]
        found = one_of(motion.partials(np.array([force @ w]), sides, design), 0, solution, step)
        if loads.state[k] >= 0 and found.q is not None:
            found.q[loads.state[k]] += w @ f_w[:, -1]
        return found

    return look


def law_of_load(
    system: System, load: Load, k: int, motions: tuple[Motion, Motion], own: Scalar, scale: Scalar
) -> tuple[np.ndarray, ...]:
    """Force law f (w,), f_z (w, z) and f_w (w, w) of load number k at its markers' poses and rates and its `own` state."""
    a, b = motions
    z: np.ndarray = np.concatenate([a.y, b.y, system.plan.loads.parameter[k], [scale]]).astype(system.dtype)
    w: np.ndarray = np.concatenate([a.rate, b.rate, [own]]).astype(system.dtype)
    shapes = (len(w), (len(w), len(z)), (len(w), len(w)))
    found: tuple[np.ndarray, ...] = tuple(np.zeros(shape, system.dtype) for shape in shapes)
    system.run(load.law(), z, w, *found)
    return found


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

    def check(self, scene: ResolvedScene) -> None:
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


class Work(Doer, Integral):
    """Work of a load or of a driver in the whole run: the integral of its power by the trapezoidal rule."""

    kind = "work"
    quantity = "energy"

    @property
    def source(self) -> Power:
        """Power whose integral over time is this work."""
        return Power(load=self.load, joint=self.joint)

    @property
    def physical_dimension(self) -> Dimension:
        """Physical dimension of an energy."""
        return LABELLED["energy"]

    @property
    def unit_quantity(self) -> str:
        """Name of the physical quantity: "energy"."""
        return "energy"

    def unit(self, system_of_units: str) -> str:
        """Unit of energy in a system of units."""
        return unit(system_of_units, "energy")

    def check(self, scene: ResolvedScene) -> None:
        """Refuse what the power of the same load or driver refuses."""
        self.source.check(scene)
