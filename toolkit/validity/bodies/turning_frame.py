"""What it costs that a body between two joints has a frame which is tied to one of its ends.

A force N along the line through both points, L apart, keeps its direction in the frame of a linear body. Tied to one end, the frame turns
against the line by psi = n . (u_2 - u_1) / L with the deformation, so that the equations have a stiffness that the body has not:

    K_1 = N / L c^T c,    c = n . (Z_2 - Z_1) of the elastic coordinates,    mu = N / L  c K^-1 c^T

Under tension (N > 0) it is taken away, and psi is too large by mu / (1 - mu); under compression it is too small by |mu| / (1 + |mu|). Other
deflections are off by less. Of a straight beam that is clamped in its frame mu = N L^2 / (3 E I). A frame on the chord has c = 0.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.reduced_model.model import Chord
from toolkit.responses.least_squares_forces import wrenches_of_joints
from toolkit.system.flexible_bodies import design_point
from toolkit.system.marker_states import poses_at
from toolkit.system.solution import Solution
from toolkit.validity.bodies.static_deflection import static_deflection
from toolkit.validity.description.frame_choice import frame_choices

LIMIT = 0.05
"""Part of a deflection that may be wrong without a word; the same as that of the other meters."""
INSTANTS = 100
"""The meter looks at about so many instants of a run."""
BOUNDLESS = 1e9
"""Stands for an error without bound where instants are compared."""


class TurningFrame(NamedTuple):
    """The instant at which the frame of a body falsifies its deflection most."""

    body: str
    chord: Chord
    time: float
    force: float  # along the chord, positive in tension
    error: float  # part by which deflections across the chord are off, about

    @property
    def exceeded(self) -> bool:
        """Whether deflections are not to be trusted."""
        return not self.error <= LIMIT


def turning_frames(solution: Solution) -> Iterator[TurningFrame]:
    """Bodies that two joints hold and whose frame is tied to one end."""
    for body, choice in frame_choices(solution.system.scene).items():
        if choice.chord is not None and choice.advice:
            compliance = lateral_compliance(solution, body, choice.chord)
            steps = np.arange(len(solution.times))[:: -(-len(solution.times) // INSTANTS)]
            forces = _along(solution, body, choice.chord, steps)
            errors = np.array([_error(force * compliance) for force in forces])
            worst = first_largest(errors)
            yield TurningFrame(
                body, choice.chord, float(solution.times[steps[worst]]), float(forces[worst]), float(errors[worst])
            )


def _error(mu: float) -> float:
    if mu < 0:
        return -mu / (1 - mu)
    return min(mu / (1 - mu), BOUNDLESS) if mu < 1 else BOUNDLESS


def lateral_compliance(solution: Solution, body: str, chord: Chord) -> float:
    """mu for a unit force: the most that c K^-1 c^T / L can be across the chord."""
    one, other = (np.real(design_point(solution.system.scene, body).interface(name).here[0]) for name in chord)
    return _largest(compliance_across(solution, body, other - one))


def bending_compliance(solution: Solution, body: str, chord: Chord) -> float:
    """The same of the second end against the tangent at the first, whatever the frame is tied to."""
    return _largest(compliance_across(solution, body, motion_against_tangent(solution, body, chord)))


def motion_against_tangent(solution: Solution, body: str, chord: Chord) -> np.ndarray:
    """The line of a chord and how each elastic coordinate moves its second end against the tangent at the first, (d, 1 + n_f)."""
    (one, turn), (other, _) = (design_point(solution.system.scene, body).interface(name).here for name in chord)
    found = np.real(other - one)
    side, turned = found[:, 0], np.real(turn)[..., 1:]
    found[:, 1:] -= np.outer([-side[1], side[0]], turned) if turned.ndim == 1 else np.cross(turned, side, axisa=0, axisc=0)
    return found


def compliance_across(solution: Solution, body: str, motion: np.ndarray) -> np.ndarray:
    """c K^-1 c^T / L (d, d) across a line, of its own vector and displacements per elastic coordinate (d, 1 + n_f)."""
    stiffness, side, moved = np.real(design_point(solution.system.scene, body).value("stiffness")), motion[:, 0], motion[:, 1:]
    length = np.linalg.norm(side)
    across = moved - np.outer(side, side @ moved) / length**2
    found = across @ static_deflection(stiffness, across.T)
    compliance: np.ndarray = (found + found.T) / (2 * length)
    return compliance


def _largest(compliance: np.ndarray) -> float:
    return float(np.linalg.eigvalsh(compliance)[-1])


def _along(solution: Solution, body: str, chord: Chord, steps: np.ndarray) -> np.ndarray:
    """The larger of the forces that joints exert at both ends, along the line through them, (n_t,): loads and inertia take up the rest."""
    system, d = solution.system, solution.system.scene.dimension
    forces, places = np.zeros((2, 2, len(steps), d))
    poses, of_joints = poses_at(system, solution.q[steps]), wrenches_of_joints(solution)
    wrenches = np.array([of_joints.at(int(step)) for step in steps])
    for j, joint in enumerate(system.scene.joints.values()):
        for side, (gripped, point) in enumerate(joint.grips):
            interface = getattr(system.scene.interface(point), "interface", None)
            if gripped == body and interface in chord:
                end = chord.index(interface)
                forces[end] += (1, -1)[side] * wrenches[:, j, 0, :d]
                grip = next(
                    n for n, marker in enumerate(system.numbering.markers) if marker[:2] == (body, point)
                )  # with axes in space
                places[end] = poses[:, grip, :d]
    line = places[1] - places[0]
    pulls = np.stack([-(forces[0] * line).sum(axis=1), (forces[1] * line).sum(axis=1)]) / np.linalg.norm(line, axis=1)
    return np.array([pair[first_largest(np.abs(pair))] for pair in pulls.T])
