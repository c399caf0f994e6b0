"""Stiffness that shear takes from Euler-Bernoulli elements.

An element of length L bends by the rotations theta_1 and theta_2 of its ends against its chord. In theta_1 + theta_2 it carries a shear
force, and there shear makes it softer; in theta_1 - theta_2 it carries none:

    E I / L (3 (theta_1 + theta_2)^2 / (1 + Phi) + (theta_1 - theta_2)^2),    Phi = 12 E I / (kappa G A L^2)

are twice its energy in each of the principal planes of its section (Przemieniecki, Theory of Matrix Structural Analysis, 1968, chapter 5).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.validity.bodies.beam_assumptions import beams_of
from toolkit.validity.bodies.chains.chain import Chain

STIFF = 2.6 / (5 / 6)
"""E / (kappa G) of a rectangle with Poisson's ratio 0.3; 2.9 of a circle, 5 of a thin tube."""


KNOWN = 1e-6
"""Relative softness in theta_1 + theta_2 above which elements know shear already."""


class BentElements(NamedTuple):
    """Bending of all elements of a chain; the rotations of an end are one in the plane, and three in space."""

    planes: np.ndarray  # (n_e, turns, turns) the axes that they bend about, as columns
    bending: np.ndarray  # (n_e, turns) E I / L about each of them; zero about the element itself
    phi: np.ndarray  # (n_e, turns) that they do not know; zero of elements that do


class SoftElements(NamedTuple):
    """Shear of all elements of a chain on some coordinates."""

    sheared: np.ndarray  # (n_e, turns, n_f) rows of theta_1 + theta_2 about the axes of the bending
    bent: BentElements

    def lost(self, factor: float) -> np.ndarray:
        """Stiffness (n_f, n_f) that shear takes away, for another Phi by a factor; 3 E I / L Phi / (1 + Phi) of the squares above."""
        phi = factor * self.bent.phi
        rows = (np.sqrt(3 * self.bent.bending * phi / (1 + phi))[:, :, None] * self.sheared).reshape(-1, self.sheared.shape[2])
        found: np.ndarray = rows.T @ rows
        return found


def bent_elements(behind: Chain) -> BentElements:
    """Bending of the elements of a chain, from its law of forces per deformation."""
    law, found = behind.forms.law, beams_of(behind)
    turns = (law.shape[1] - 1) // 2
    aside = np.eye(turns)[None]
    if turns > 1:
        aside = aside - found.along[:, :, None] * found.along[:, None, :]
    own, other = (aside @ law[:, 1 : 1 + turns, first : first + turns] @ aside for first in (1, 1 + turns))
    values, planes = np.linalg.eigh((own - other) / 2)
    bending = np.maximum(values, 0.0)
    sheared = np.einsum("etk,etu,euk->ek", planes, own + other, planes)
    phi = 12 * STIFF * bending / (found.axial * found.lengths)[:, None]
    return BentElements(planes, bending, np.where(sheared < (1 - KNOWN) * 6 * bending, 0.0, phi))


def soft_elements(behind: Chain, motions: np.ndarray) -> SoftElements:
    """Shear of the elements of a chain, on coordinates that move its elastic ones by the columns of `motions` (n_f, n)."""
    forms, bent = behind.forms, bent_elements(behind)
    turns = bent.bending.shape[1]
    rows = np.einsum("etk,etp->ekp", bent.planes, forms.rows[:, 1 : 1 + turns] + forms.rows[:, 1 + turns :])
    return SoftElements(np.einsum("ekp,epf->ekf", rows, (behind.shapes @ motions)[forms.dofs]), bent)


def shear_energies(behind: Chain, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Energies (n_t,) of displacements (n_t, n): V^2 L / (2 kappa G A) of shear by the same forces, and all that elements know.

    The first in the moments M_1 + M_2 = V L is (M_1 + M_2)^2 Phi L / (24 E I).
    """
    forms, bent = behind.forms, bent_elements(behind)
    forces, turns = forms.forces(u), bent.bending.shape[1]
    strains = np.einsum("ekp,tep->tek", forms.rows, u[:, forms.dofs])
    moments = np.einsum("etk,net->nek", bent.planes, forces[:, :, 1 : 1 + turns] + forces[:, :, 1 + turns :])
    soft = np.divide(bent.phi, 24 * bent.bending, out=np.zeros_like(bent.phi), where=bent.phi > 0)
    return np.einsum("nek,ek->n", moments**2, soft), np.einsum("tek,tek->t", forces, strains) / 2
