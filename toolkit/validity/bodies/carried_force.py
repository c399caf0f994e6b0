"""Forces along bodies whose elements are not known, and frames that are tied to one end of a body between two joints.

What it costs that a body between two joints has a frame which is tied to one of its ends.

A force N along the line through both points, L apart, keeps its direction in the frame of a linear body. Tied to one end, the frame turns
against the line by psi = n . (u_2 - u_1) / L with the deformation, so that the equations have a stiffness that the body has not:

    K_1 = N / L c^T c,    c = n . (Z_2 - Z_1) of the elastic coordinates,    mu = N / L  c K^-1 c^T

Under tension (N > 0) it is taken away, and psi is too large by mu / (1 - mu); under compression it is too small by |mu| / (1 + |mu|). Other
deflections are off by less. Of a straight beam that is clamped in its frame mu = N L^2 / (3 E I). A frame on the chord has c = 0.

From the point B that holds the frame to an interface point P, L apart along e, the body has the compliances c_a along e and c across it. It
is as much longer as a force N = a / c_a at P would make it, with the elongation a. In parts of what makes a straight bar buckle that is
clamped at B,

    mu = -12 / pi^2  N c / L = -4 N L^2 / (pi^2 E I)

and a quarter of that if two joints hold it that let it turn. Deflections across e lack nearly mu / (1 - mu) of themselves under
compression, and under tension (mu < 0) they are too large by about as much; in directions in which c is less, they are off by less.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.reduced_model.model import Chord, chord_of
from toolkit.responses.least_squares_forces import wrenches_of_joints
from toolkit.system.solution import Solution, design_point, elastic_coordinates, flexible_body, poses_at, used_interfaces
from toolkit.validity.bodies.geometric_stiffness import forces_at_points
from toolkit.validity.frame_choice import frame_choices


def static_deflection(stiffness: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """K^-1 f of forces f, (n_f,) or (n_f, k); K (n_f, n_f) is scaled to a unit diagonal, as coordinates differ by powers of ten."""
    scale = 1 / np.sqrt(np.diag(stiffness))
    found: np.ndarray = (np.linalg.solve(scale[:, None] * stiffness * scale, (forces.T * scale).T).T * scale).T
    return found


LIMIT = 0.05
"""Part of a deflection that may be wrong without a word; the same as that of the other meters."""
INSTANTS = 100
"""The meter looks at about so many instants of a run."""
UNBOUNDED_ERROR = 1e9
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
    return min(mu / (1 - mu), UNBOUNDED_ERROR) if mu < 1 else UNBOUNDED_ERROR


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


CLAMPED_LOAD_FACTOR, PINNED_LOAD_FACTOR = 12 / np.pi**2, 3 / np.pi**2
"""Factors of N c / L that give the load relative to the critical load of a straight bar."""


UNMOVED_PART = 1e-9
"""Part of the largest movement of a point below which it is round-off."""
SHORTEST_REACH = 1e-6
"""Part of its length by which a line has to reach beyond the points that hold its start."""
NO_AXIAL_COMPLIANCE = 1e-12
"""Part of the compliance across below which the compliance along is none: the basis then knows of no force along the line."""


class Carried(NamedTuple):
    """The force along a body at some instants, relative to its critical load."""

    load: np.ndarray  # mu (n_t,), negative in tension
    along: np.ndarray  # e (d,)
    across: np.ndarray  # c (d, d) in parts of its largest


def carried(solution: Solution, body: str, instants: np.ndarray, still: np.ndarray | None) -> Carried | None:
    """Largest force along a body at some instants, of all interface points at which its lines end.

    Where the basis holds no shape that stretches, it is the force that loads and joints put on that point; None without a line.

    Parameters
    ----------
    instants : (n_t,) numbers of states
    still : (n, d) the places that hold a tangent frame; None of other frames
    """
    every = [_carried(solution, body, instants, name, line) for name, line in _lines(solution, body, still)]
    worst = first_largest(np.array([np.abs(each.load).max() for each in every])) if every else None
    return None if worst is None else every[worst]


def still_points(places: np.ndarray, shapes: np.ndarray) -> np.ndarray | None:
    """Points (n, d) that no shape moves; None if each is moved by some."""
    moves = np.abs(shapes).max(axis=(1, 2))
    points = places[moves <= UNMOVED_PART * moves.max()]
    return points if len(points) else None


def lines_between(solution: Solution, body: str, still: np.ndarray | None) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Interface point, start (d,), and relative motion (d, 1 + n_f) of the end of each line: of a chord, or from fixed points.

    A line ends at no point between those that no shape moves: that point is held from two sides, as one between two clamped ends.
    """
    design = design_point(solution.system.scene, body, "interfaces")
    if (chord := chord_of(design.model.reference_condition)) is not None and {*chord} <= {*(design.model.interfaces or {})}:
        one, other = (np.real(design.interface(name).here[0]) for name in chord)
        yield chord.second, one[:, 0], other - one
    elif still is not None:
        middle = still.mean(axis=0)
        for name in used_interfaces(solution.system.scene, body):
            motion = np.real(design.interface(name).here[0])
            motion = np.column_stack([motion[:, 0] - middle, motion[:, 1:]])
            if np.any(motion[:, 1:]) and _is_ahead(motion[:, 0], still - middle):
                yield name, middle, motion


def _is_ahead(side: np.ndarray, behind: np.ndarray) -> bool:
    """Whether the end of a line is farther along it than all points (n, d)."""
    return bool((behind @ side).max() < (1 - SHORTEST_REACH) * (side @ side))


class _Line(NamedTuple):
    """A line through a body between two of its points."""

    motion: np.ndarray  # (d, 1 + n_f) of its one end against the other
    across: np.ndarray  # c / L (d, d)
    factor: float


def _lines(solution: Solution, body: str, still: np.ndarray | None) -> Iterator[tuple[str, _Line]]:
    """Interface points of a body and the lines that end there."""
    scene = solution.system.scene
    chord = chord_of(design_point(scene, body, "interfaces").model.reference_condition)
    for name, _, motion in lines_between(solution, body, still):
        if chord is not None:
            yield (
                name,
                _Line(
                    motion, compliance_across(solution, body, motion_against_tangent(solution, body, chord)), PINNED_LOAD_FACTOR
                ),
            )
        else:
            factor = PINNED_LOAD_FACTOR if (choice := frame_choices(scene).get(body)) and choice.chord else CLAMPED_LOAD_FACTOR
            yield name, _Line(motion, compliance_across(solution, body, motion), factor)


def _carried(solution: Solution, body: str, instants: np.ndarray, name: str, line: _Line) -> Carried:
    length = np.linalg.norm(line.motion[:, 0])
    along = line.motion[:, 0] / length
    stiffness = np.real(design_point(solution.system.scene, body).value("stiffness"))
    row = along @ line.motion[:, 1:]
    compliance, largest = row @ static_deflection(stiffness, row), np.linalg.eigvalsh(line.across)[-1]
    if compliance > NO_AXIAL_COMPLIANCE * largest * length:
        force = np.real(solution.q[instants][:, elastic_coordinates(solution, body)]) @ row / compliance
    else:
        force = forces_at_points(solution, body, instants).get(name, np.zeros((len(instants), len(along)))) @ along
    load = -line.factor * largest * force
    if flexible_body(solution.system.scene, body).stiffening(solution.system.scene) is not None:
        load = np.maximum(load, 0.0)  # its spin pulls at it, and that is in the equations
    return Carried(load, along, line.across / largest)
