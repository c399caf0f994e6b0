"""How far bodies bend whose finite elements are not at hand: reduced beams in space by the lines of their surface, solids by its points.

Bending of the pieces of a solid between their ends, which no frame that carries a whole piece has.

Ends that turn by theta_1 and theta_2 against the line through both bow a piece of length L as a beam, and bring them nearer by

    L (2 theta_1^2 - theta_1 . theta_2 + 2 theta_2^2) / 30

of which the linear piece has nothing. All of these together are about how far a node of the body is from where it should be.

A line that turns by theta in the body's frame stays as long as it is and so loses theta^2 / 2 of its length along where it was, which a
linear body gains instead. The mean of that over all lines that turn, times the body's extent L, is how far its end is off: with d the
deflection of a cantilever's tip 0.6 d^2 / L, of an arc between the ends that hold its frame 2.7 d^2 / L. What a body without lines has is
taken for a cantilever; members of a frame that rest do not count. A force along the body, see `carried_force`, adds its part of the
critical one of the displacement across it.

Numbers of frames that were chosen at the numbers of a scene, and leave more than is wanted at others.

The meter of large deformation is too large rather than too small: at other numbers errors are what it finds there, or by the runs that
have chosen, as much less as theirs is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from toolkit.components.bodies.cut_body import CutBody
from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import Solution, deforming, design_point, elastic_coordinates, is_in_pieces
from toolkit.validity.bodies.carried_force import Carried, carried, still_points
from toolkit.validity.bodies.chain import sides_of
from toolkit.validity.bodies.deformation import (
    LIMIT,
    ROUND_OFF,
    Deformation,
    deformations,
    displacements,
    divided,
    instants_of,
    whole_bodies,
)
from toolkit.validity.bodies.known_chain import chain, has_chain
from toolkit.validity.frame_choice import choices_in


@check("bent-pieces", STATES)
def bent_pieces(solution: Solution) -> Iterator[Caution]:
    """A solid in pieces bends inside of its pieces so far that they shorten, which no frame of a whole piece knows.

    Limit: 5 % of its largest displacement.
    Fix: more pieces in the body file.
    """
    scene = solution.system.scene
    for body in whole_bodies(scene):
        if not is_in_pieces(scene, body):
            continue
        error, turn, count = shortening(solution, body)
        if error > LIMIT:
            yield bent_pieces.caution(
                f"{body} is cut into {count} pieces, which bend by up to {turn:.2g} rad against the lines through their ends. They "
                f"shorten, which no frame of a whole piece knows: nodes are off by about {error:.1%} of its displacement (limit "
                f"{LIMIT:.0%}). Fix: cut it into some {int(np.ceil(count * np.sqrt(error / LIMIT)))} pieces.",
            )


def shortening(solution: Solution, body: str) -> tuple[float, float, int]:
    """Shortening of the pieces of a body at the worst instant, relative to its largest displacement then.

    With it the largest angle of an end in rad, and the number of pieces.
    """
    scene = solution.system.scene
    instants = instants_of(solution, body)
    bows, turns = [], []
    for name, part in deforming(scene).items():
        behind = chain(scene, name) if body in (name, getattr(part, "whole", None)) else None
        if behind is not None:
            u = behind.displacements(np.real(solution.q[instants][:, elastic_coordinates(solution, name)]))
            sides, turned = sides_of(behind), np.einsum("ekp,tep->tek", behind.forms.rows, u[:, behind.forms.dofs])[:, :, 1:]
            found = _across(turned, sides.along)
            bows.append(_bow(found[0], found[1], sides.lengths))
            turns.append(np.linalg.norm(found, axis=3).max(axis=0))
    lost, moved = np.concatenate(bows, axis=1), displacements(solution, body, instants).max(axis=1)
    parts = np.divide(lost.sum(axis=1), moved, out=np.zeros(len(moved)), where=moved > 0)
    worst = first_largest(parts)
    return float(parts[worst]), float(np.concatenate(turns, axis=1)[worst].max()), lost.shape[1]


def _across(turns: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Rotations of both ends (2, n_t, n_e, 3) without those about the line through both, from (n_t, n_e, 6)."""
    ends = np.stack([turns[:, :, :3], turns[:, :, 3:]])
    found: np.ndarray = ends - np.einsum("ntec,ec->nte", ends, along)[..., None] * along
    return found


def _bow(first: np.ndarray, second: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Shortening of pieces by the rotations of their ends, (n_t, n_e)."""
    squares = [np.sum(one * other, axis=2) for one, other in ((first, first), (first, second), (second, second))]
    found: np.ndarray = lengths * (2 * squares[0] - squares[1] + 2 * squares[2]) / 30
    return found


CANTILEVER_FACTOR = 0.6
"""Of d^2 / L, for a force at its tip."""
DOUBTFUL_LOAD_PART = 0.1
"""Part of the critical load above which deflections across lack more than a tenth of themselves, by rules that other supports change."""
HARDLY_BENT_PART = 1e-2
"""Lines that turn by less than a tenth of the largest angle belong to members that hardly bend; of a cantilever they are a twentieth."""


@dataclass(frozen=True)
class Bending:
    """The instant of the largest estimated error; lengths in the units of the scene."""

    displacement: float  # largest displacement of a point in the body's frame
    error: float
    time: float
    rotation: float  # largest angle that a line turns by in the frame, rad; nan of a body without lines
    size: float  # extent of the undeformed body
    load: float  # the largest force along the body at any instant in parts of the critical one, about; zero where none compresses it

    @property
    def relative(self) -> float:
        """The error in parts of the displacement, where this is more than round-off."""
        return self.error / self.displacement if self.displacement > ROUND_OFF * self.size else 0.0


Measured: TypeAlias = Deformation | Bending
"""Deformation of a body in its frame, and its estimated geometric error."""


@check("large-deformation", STATES)
def bent_surfaces(solution: Solution) -> Iterator[Caution]:
    """Bodies whose elements are not known that leave the range of small deformations, or come near to buckling."""
    for body in whole_bodies(solution.system.scene):
        found = bending(solution, body)
        if found is not None and not found.relative <= LIMIT:
            yield bent_surfaces.caution(_told(solution.system.scene, body, found), body=body, part=found.relative)
        if found is not None and found.load > LIMIT:
            part = found.load / (1 - found.load) if found.load < 1 else np.inf
            yield Caution("critical-load", _compressed(body, found.load), not found.load <= DOUBTFUL_LOAD_PART, body, part)


def geometric_errors(solution: Solution) -> dict[str, Measured | None]:
    """What the meters estimate of every flexible body; None of those that no meter knows."""
    return {body: bending(solution, body) if found is None else found for body, found in deformations(solution).items()}


def bending(solution: Solution, body: str) -> Bending | None:
    """How far one body bends; None where its finite elements tell it better, or nothing does."""
    scene = solution.system.scene
    if isinstance(scene.bodies[body], CutBody) or has_chain(scene, body):
        return None
    design = design_point(scene, body, "surface", "outline")
    shown = "surface" if design.model.surface is not None else "outline" if design.model.outline is not None else ""
    if not shown:
        return None
    position = np.real(design.value(f"{shown}.position"))
    places, shapes = position[:, :, 0], position[:, :, 1:]
    instants = instants_of(solution, body)
    elastic = np.real(solution.q[instants][:, elastic_coordinates(solution, body)])
    moved = np.einsum("pdf,tf->tpd", shapes, elastic)
    distance, extent = np.linalg.norm(moved, axis=2).max(axis=1), float(np.ptp(places, axis=0).max())
    lines = design.model.surface.lines if design.model.surface is not None else np.zeros((0, 2), int)
    if len(lines):
        lost, turned = _lost(places, moved, lines)
        error = extent * lost
    else:
        error, turned = CANTILEVER_FACTOR * distance**2 / extent, np.full(len(distance), np.nan)
    force = carried(solution, body, instants, still_points(places, shapes))
    if force is not None:
        error = error + np.abs(force.load) * _aside(moved, force)
    k = first_largest(error)
    load = 0.0 if force is None else max(float(force.load.max()), 0.0)
    return Bending(float(distance[k]), float(error[k]), float(solution.times[instants[k]]), float(turned[k]), extent, load)


def _aside(moved: np.ndarray, force: Carried) -> np.ndarray:
    """The largest displacement of a point (n_t, n, d) across a line, (n_t,), where it is stiffer by as much less as it yields less."""
    across = moved - (moved @ force.along)[:, :, None] * force.along
    farthest = across[np.arange(len(across)), np.argmax(np.einsum("tpd,tpd->tp", across, across), axis=1)]
    size = np.linalg.norm(farthest, axis=1)
    yielding = np.einsum("td,de,te->t", farthest, force.across, farthest)
    return np.divide(yielding, size, out=np.zeros(len(size)), where=size > 0)


def _lost(points: np.ndarray, moved: np.ndarray, lines: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean of theta^2 / 2 over the lines that turn, by their length, and the largest theta, (n_t,)."""
    first, last = lines.T
    along = points[last] - points[first]
    length = np.linalg.norm(along, axis=1)
    change = (moved[:, last] - moved[:, first]) / length[:, None]
    sideways = np.sum(change**2, axis=2) - np.einsum("tld,ld->tl", change, along / length[:, None]) ** 2
    turning = np.where(sideways >= HARDLY_BENT_PART * sideways.max(axis=1, keepdims=True), length, 0.0)
    whole = turning.sum(axis=1)
    mean = np.divide(np.sum(sideways * turning, axis=1), 2 * whole, out=np.zeros(len(whole)), where=whole > 0)
    return mean, np.arctan(np.sqrt(np.maximum(sideways.max(axis=1), 0.0)))


def _compressed(body: str, load: float) -> str:
    lost = (
        f"deflections across lack some {load / (1 - load):.0%} of them, and frequencies are lower"
        if load < 1
        else "it buckles, which these numbers do not show"
    )
    return (
        f"{body} is compressed with some {load:.2g} times what buckles a slender bar of its stiffness: {lost}. Linear FFRF has no "
        "geometric stiffness of a body in its frame. Fix: load it less, stiffen it, or make several bodies in a row of it, which buckle as "
        "they should."
    )


def _told(scene: ResolvedScene, body: str, found: Bending) -> str:
    length = unit(scene.units, "length")
    return (
        f"{body} leaves the range of small deformations: it is displaced by up to {found.displacement:.3g} {length} in its frame at "
        f"t = {found.time:.4g}. Bodies that bend so far are off by some {found.error:.2g} {length}, {found.relative:.0%} of that "
        f"(limit {LIMIT:.0%}), because their lines grow where they turn. Fix: "
        f"{divided(scene, body, found.relative / LIMIT)}, or stiffen the body."
    )


ESTIMATE_FACTOR = 2
"""Estimated errors are off by up to this factor: beyond so many times the wanted one it is missed for certain."""


@check("outgrown-frames", STATES)
def outgrown_choices(solution: Solution) -> Iterator[Caution]:
    """Bodies whose number of frames was chosen by an error that this solution exceeds."""
    choices = choices_in(solution.system.scene)
    for body, metered in geometric_errors(solution).items() if choices else ():
        if metered is None or body not in choices or choices[body][1].kept_run:
            continue
        number, choice = choices[body]
        error = metered.relative * (min(choice.error / choice.metered, 1.0) if choice.metered > 0 else 1.0)
        if error > choice.wanted:
            needed = int(np.ceil(number * np.sqrt(error / choice.wanted)))
            yield outgrown_choices.caution(
                f"the number of frames of {body} was chosen at the numbers of the scene as it is written. At these it leaves about "
                f"{error:.1%} of the largest displacement, where a geometric error of {choice.wanted:.3g} is wanted. Fix: write these "
                f"numbers into the scene, so that the number is chosen for them, or frames = {needed}.",
                doubt=error > ESTIMATE_FACTOR * choice.wanted,
            )
