"""The truth that the small-deformation meter estimates: the same elements under the same forces, solved corotationally."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.processes.preprocessing_process import run
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import elastic_coordinates, flexible_body
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.known_chain import chain
from toolkit.validity.bodies.chains.planar_chain import PlanarChain
from toolkit.validity.bodies.deformation import Deformation, deformation_of, flexible_bodies
from toolkit.validity.bodies.spinning.stiffened import kept_back

PROGRAM = "preprocessing.corotational.command"


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


def compare_with_corotational(solution: Solution, body: str) -> Comparison:
    """Solve a flexible body corotationally at the instant of the largest estimated error, in a process of the preprocessing.

    Raises
    ------
    InputError
        The preprocessing is not installed; the reduced model does not hold its finite elements; or the corotational body has no
        equilibrium under the forces.
    """
    scene = solution.system.placed
    behind = chain(scene, body)
    if not isinstance(behind, PlanarChain):
        raise InputError(_without_beams(scene, body))
    estimate = deformation_of(behind, solution, body)
    instant = np.flatnonzero(solution.times == estimate.time)[:1]
    elastic = np.real(solution.q[instant][:, elastic_coordinates(solution, body)])
    held_back = kept_back(solution, body, instant)
    content = {
        "nodes": behind.elements.nodes,
        "connectivity": behind.elements.connectivity,
        **behind.made_of.rectangles,
        "held": behind.held,
        "displacements": behind.displacements(elastic)[0],
    }
    if held_back is not None:
        content["loaded"] = behind.displacements(elastic + held_back)[0]
    done = run(PROGRAM, [], json.dumps([{name: value.tolist() for name, value in content.items()}]))
    if done.returncode:
        raise InputError(f"body {body!r} at t = {estimate.time:g}: {done.stderr.strip()}")
    found = json.loads(done.stdout)[0]
    return Comparison(estimate, *(found[name] for name in ("error", "stress", "corotational_stress", "stress_error")))


def flexible_of(solution: Solution) -> list[str]:
    """Flexible bodies of a solution.

    Raises
    ------
    InputError
        There is none.
    """
    found = flexible_bodies(solution.system.placed)
    if not found:
        raise InputError("no body of the scene is flexible, so that none deforms. Give a scene with a flexible body.")
    return found


def _without_beams(scene: Scene, body: str) -> str:
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


def _in_pieces(scene: Scene) -> str:
    """How a solid becomes several bodies without being several ones."""
    return (
        ", or with itself cut into pieces ([pieces] in its file) and `frames` in the scene"
        if not scene.space.turning_elements
        else ""
    )
