"""Mass of bodies and their common centre of mass."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np
from pydantic import field_validator

from toolkit.bodies.body import CENTRE
from toolkit.compilation.dependence import items_of
from toolkit.compilation.quantities import STEP
from toolkit.responses.instant import Instant
from toolkit.responses.kinematics.marker_formula import one_of, place_of, refuse_component
from toolkit.responses.kinematics.marker_motion import MarkerMotion, Motion
from toolkit.responses.response import Partials
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import Solution
from toolkit.system.system import System


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

    def names(self, scene: Any) -> tuple[str, ...]:
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

    def grips(self, scene: Any) -> tuple[tuple[str, str], ...]:
        """Pairs of body and centre of mass, for every body that the response counts."""
        return tuple((name, CENTRE) for name in self.names(scene))

    def check(self, scene: Any) -> None:
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
