"""Forces along bodies whose elements are not known, solids and reduced beams in space: what they do to bending, by rules for slender bars.

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
from toolkit.reduced_model.model import chord_of
from toolkit.system.flexible_bodies import design_point, elastic_coordinates, flexible_body, used_interfaces
from toolkit.system.solution import Solution
from toolkit.validity.bodies.compressed.forces_at_points import forces_at_points
from toolkit.validity.bodies.static_deflection import static_deflection
from toolkit.validity.bodies.turning_frame import compliance_across, motion_against_tangent
from toolkit.validity.description.frame_choice import frame_choices

CLAMPED, PINNED = 12 / np.pi**2, 3 / np.pi**2
"""Factors of N c / L that give the load relative to the critical load of a straight bar."""


STILL = 1e-9
"""Part of the largest movement of a point below which it is round-off."""
SHORT = 1e-6
"""Part of its length by which a line has to reach beyond the points that hold its start."""
SEEN = 1e-12
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
    points = places[moves <= STILL * moves.max()]
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
    return bool((behind @ side).max() < (1 - SHORT) * (side @ side))


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
            yield name, _Line(motion, compliance_across(solution, body, motion_against_tangent(solution, body, chord)), PINNED)
        else:
            factor = PINNED if (choice := frame_choices(scene).get(body)) and choice.chord else CLAMPED
            yield name, _Line(motion, compliance_across(solution, body, motion), factor)


def _carried(solution: Solution, body: str, instants: np.ndarray, name: str, line: _Line) -> Carried:
    length = np.linalg.norm(line.motion[:, 0])
    along = line.motion[:, 0] / length
    stiffness = np.real(design_point(solution.system.scene, body).value("stiffness"))
    row = along @ line.motion[:, 1:]
    compliance, largest = row @ static_deflection(stiffness, row), np.linalg.eigvalsh(line.across)[-1]
    if compliance > SEEN * largest * length:
        force = np.real(solution.q[instants][:, elastic_coordinates(solution, body)]) @ row / compliance
    else:
        force = forces_at_points(solution, body, instants).get(name, np.zeros((len(instants), len(along)))) @ along
    load = -line.factor * largest * force
    if flexible_body(solution.system.scene, body).stiffening(solution.system.scene) is not None:
        load = np.maximum(load, 0.0)  # its spin pulls at it, and that is in the equations
    return Carried(load, along, line.across / largest)
