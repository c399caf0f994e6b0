"""The truth that the small-deformation meter estimates: the same elements under the same forces, solved corotationally."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.reduced_model.model import StressPoints
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.flexible_bodies import design_point, elastic_coordinates, flexible_body
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.known_chain import chain
from toolkit.validity.bodies.chains.planar_chain import PlanarChain
from toolkit.validity.bodies.corotational.elements import Corotational
from toolkit.validity.bodies.corotational.equilibrium import solve_corotational
from toolkit.validity.bodies.deformation import Deformation, deformation_of, flexible_bodies
from toolkit.validity.bodies.spinning.stiffened import kept_back


@dataclass(frozen=True)
class Comparison:
    """Linear against corotational elements at one instant, beside the meter's estimate; lengths and stresses in the scene's units."""

    estimate: Deformation
    error: float  # largest distance of a node between the two
    stress: float  # largest magnitude, linear
    corotational_stress: float
    stress_error: float  # largest difference at a stress point

    @property
    def relative(self) -> float:
        """The error in parts of the largest linear displacement."""
        return self.error / self.estimate.displacement if self.estimate.displacement else 0.0


class Compared(NamedTuple):
    """Linear displacements and stresses of a body, and those of corotational elements under the same forces."""

    displacements: np.ndarray  # (n,)
    corotational: np.ndarray  # (n,)
    stress: np.ndarray  # (n_stress,)
    corotational_stress: np.ndarray  # (n_stress,)

    @property
    def error(self) -> float:
        """Largest distance of a node between the two."""
        away = self.corotational - self.displacements
        return float(np.hypot(away[0::3], away[1::3]).max())


def compare_with_corotational(solution: Solution, body: str) -> Comparison:
    """Solve a flexible body corotationally at the instant of the largest estimated error.

    Raises
    ------
    InputError
        The reduced model does not hold its finite elements; or the corotational body has no equilibrium under the forces.
    """
    scene = solution.system.scene
    behind = chain(scene, body)
    places = design_point(scene, body, "stress").model.stress
    if not isinstance(behind, PlanarChain) or places is None:
        raise InputError(_without_beams(scene, body))
    estimate = deformation_of(behind, solution, body)
    instant = np.flatnonzero(solution.times == estimate.time)[:1]
    elastic = np.real(solution.q[instant][:, elastic_coordinates(solution, body)])
    held_back = kept_back(solution, body, instant)
    linear = behind.displacements(elastic)[0]
    loaded = linear if held_back is None else behind.displacements(elastic + held_back)[0]
    try:
        found = compared(behind, places, linear, loaded)
    except InputError as error:
        raise InputError(f"body {body!r} at t = {estimate.time:g}: {error}") from None
    sizes = (np.abs(found.stress), np.abs(found.corotational_stress), np.abs(found.corotational_stress - found.stress))
    return Comparison(estimate, found.error, *(float(each.max()) for each in sizes))


def compared(behind: PlanarChain, places: StressPoints, linear: np.ndarray, loaded: np.ndarray) -> Compared:
    """Solve the elements behind a body corotationally, under the forces that its linear elements need for displacements.

    The forces F = K u are those of joints, loads and, in motion, inertia and damping of the body, as far as its basis resolves them, in
    the directions that they have in the body's frame.

    Parameters
    ----------
    linear, loaded : (n,)
        Linear displacements, and the u of the forces: the same without what a spin of the body keeps back.

    Raises
    ------
    InputError
        No corotational equilibrium exists under these forces.
    """
    frame = Corotational(behind.nodes, behind.connectivity, behind.made_of)
    at_rest = frame.tangent(np.zeros(len(linear)))
    found = solve_corotational(frame, at_rest @ loaded, behind.held)
    return Compared(linear, found, frame.linear_stress(linear, places), frame.stress(found, places))


def flexible_of(solution: Solution) -> list[str]:
    """Flexible bodies of a solution.

    Raises
    ------
    InputError
        There is none.
    """
    found = flexible_bodies(solution.system.scene)
    if not found:
        raise InputError("no body of the scene is flexible, so that none deforms. Give a scene with a flexible body.")
    return found


def _without_beams(scene: ResolvedScene, body: str) -> str:
    """Why there is nothing to compare a body with."""
    if not scene.space.turning_elements or scene.model(flexible_body(scene, body).model, "outline").outline is not None:
        return (
            f"body {body!r} does not consist of beams, the only elements that turn here. Compare it with several bodies in a "
            f"row instead of one, which turn themselves{_in_pieces(scene)}."
        )
    return (
        f"the reduced model of body {body!r} does not hold its mesh and stress points, so that its elements are unknown. Build it "
        "again with ffrf-preprocess."
    )


def _in_pieces(scene: ResolvedScene) -> str:
    """How a solid becomes several bodies without being several ones."""
    return (
        ", or with itself cut into pieces ([pieces] in its file) and `frames` in the scene"
        if not scene.space.turning_elements
        else ""
    )
