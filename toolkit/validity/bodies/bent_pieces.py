"""Bending of the pieces of a solid between their ends, which no frame that carries a whole piece has.

Ends that turn by theta_1 and theta_2 against the line through both bow a piece of length L as a beam, and bring them nearer by

    L (2 theta_1^2 - theta_1 . theta_2 + 2 theta_2^2) / 30

of which the linear piece has nothing. All of these together are about how far a node of the body is from where it should be.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.system.flexible_bodies import deforming, elastic_coordinates, is_in_pieces
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.known_chain import chain
from toolkit.validity.bodies.chains.sides import sides_of
from toolkit.validity.bodies.cut.places import displacements
from toolkit.validity.bodies.deformation import LIMIT, instants_of, whole_bodies


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
