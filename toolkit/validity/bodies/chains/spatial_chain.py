"""Beam elements in space behind a body: those that its reduced model keeps one by one.

Forces s of the linear element do work on the second-order deformations d_2 = u^T Q u / 2 of `spatial_forms`, and so add sum_k s_k Q_k to
its stiffness: under bending moments and torques beams give way sideways, too. The axial force N does more of it where the element bows
between its ends,

    N L / 30 (4 theta_1^2 - 2 theta_1 theta_2 + 4 theta_2^2),    theta_i across the element

What bends a beam before it gives way turns its sections, which for bending about the stiffer principal axis leaves of the moment the part
1 - E I_weak / E I_strong (Trahair, Flexural-Torsional Buckling of Structures, 1993), and none for bending about the weaker: square bars and
tubes never buckle sideways.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from toolkit.kinematics.orientation import axes_along
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.planar_chain import SHORTENING
from toolkit.validity.bodies.chains.second_order import Forms
from toolkit.validity.bodies.chains.spatial_forms import spatial_forms


@dataclass(frozen=True, eq=False)
class SpatialChain(Chain):
    """A chain of beam elements of any section in space."""

    places: np.ndarray  # (n_nodes, 3)
    connectivity: np.ndarray  # (n_e, 2)
    stiffness: np.ndarray  # (n_e, 12, 12)

    per_node: ClassVar[int] = 6

    @property
    def nodes(self) -> np.ndarray:
        return self.places

    def make_forms(self) -> Forms:
        return spatial_forms(self.places, self.connectivity, self.stiffness)

    def make_stiffening(self) -> np.ndarray:
        """Forms of the geometric stiffness by all forces of the elements, (n_e, 7, 12, 12)."""
        found, (e, lengths) = self.forms.curved.copy(), self._sides
        moments = found[:, 1:].reshape(-1, 2, 3, 12, 12)
        found[:, 1:] = np.einsum("ecd,encpq->endpq", self._counting(), moments, optimize=True).reshape(-1, 6, 12, 12)
        theta = self.forms.rows[:, 1:].reshape(-1, 2, 3, 12)
        across = theta - e[:, None, :, None] * np.einsum("ec,encp->enp", e, theta)[:, :, None]
        found[:, 0] += lengths[:, None, None] * np.einsum("encp,nm,emcq->epq", across, SHORTENING, across, optimize=True)
        return found

    def _counting(self) -> np.ndarray:
        """Part of the moments at an end that makes the element buckle sideways, (n_e, 3, 3).

        That is the torque, and bending about the stiffer axis.
        """
        law, e = self.forms.law, self._sides[0]
        along = e[:, :, None] * e[:, None, :]
        aside = np.eye(3) - along
        bending = aside @ (law[:, 1:4, 1:4] - law[:, 1:4, 4:]) @ aside  # 2 E I / L about every axis across
        values, axes = np.linalg.eigh(bending)
        strong, part = axes[:, :, 2], 1 - values[:, 1] / values[:, 2]
        return along + part[:, None, None] * strong[:, :, None] * strong[:, None, :]

    @cached_property
    def _sides(self) -> tuple[np.ndarray, np.ndarray]:
        """Directions (n_e, 3) and lengths (n_e,) of the elements."""
        sides = self.places[self.connectivity[:, 1]] - self.places[self.connectivity[:, 0]]
        lengths = np.linalg.norm(sides, axis=1)
        return sides / lengths[:, None], lengths


def rows_of_part(nodes: np.ndarray) -> np.ndarray:
    """Rows (6, n) of displacements that the frame of a part does not feel.

    The frame starts at its first node, goes through its last and rolls with both.
    """
    side, n = nodes[-1] - nodes[0], 6 * len(nodes)
    found, chord = np.zeros((6, n)), side / np.linalg.norm(side)
    found[:3, :3] = np.eye(3)
    found[3:5, n - 6 : n - 3] = axes_along(chord)[:, :2].T
    found[5, 3:6] = found[5, n - 3 :] = chord
    return found
