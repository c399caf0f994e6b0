"""Deflections and frequencies that shear changes, by the stiffness that it takes from Euler-Bernoulli elements.

Stiffness that shear takes from Euler-Bernoulli elements.

An element of length L bends by the rotations theta_1 and theta_2 of its ends against its chord. In theta_1 + theta_2 it carries a shear
force, and there shear makes it softer; in theta_1 - theta_2 it carries none:

    E I / L (3 (theta_1 + theta_2)^2 / (1 + Phi) + (theta_1 - theta_2)^2),    Phi = 12 E I / (kappa G A L^2)

are twice its energy in each of the principal planes of its section (Przemieniecki, Theory of Matrix Structural Analysis, 1968, chapter 5).

Deflections that shear makes larger: by the energy that the shear forces of a state would have, in the plane in which it bends.

In the first order of shear the loads move by as much more, in parts of how they move, as the energy of shear is of all energy of the
deformed bodies (Castigliano): 3 E I / (kappa G A L^2) of a cantilever by a force at its end.

A bending wave of the wave number k is too fast by (k r)^2 E / (2 kappa G) in the first order, r^2 = I / A, and k^2 r = omega sqrt(m / E A).
Where that is small for all bodies nothing is computed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import scipy

from toolkit.foundation.units import unit
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.responses.pencil import free_pencil, real_pencil
from toolkit.responses.vibration import any_pencil_of
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import Solution, deforming, elastic_coordinates, flexible_body, is_in_pieces
from toolkit.validity.bodies.beam_assumptions import beams_of
from toolkit.validity.bodies.chain import Chain
from toolkit.validity.bodies.deformation import LIMIT, largest_instants, whole_bodies
from toolkit.validity.bodies.known_chain import chain

MODULI_RATIO = 2.6 / (5 / 6)
"""E / (kappa G) of a rectangle with Poisson's ratio 0.3; 2.9 of a circle, 5 of a thin tube."""


KNOWN_SHEAR = 1e-6
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
    phi = 12 * MODULI_RATIO * bending / (found.axial * found.lengths)[:, None]
    return BentElements(planes, bending, np.where(sheared < (1 - KNOWN_SHEAR) * 6 * bending, 0.0, phi))


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


SHORTEST_DISTANCE = 1 / 20
"""Of the size of a body: loads and supports are not looked at that are nearer to each other."""
STRAIN_ROUND_OFF = 1e-13
"""Below it deformations are round-off, which has no plane."""


@check("shear", STATES)
def sheared(solution: Solution) -> Iterator[Caution]:
    """Shear, which Euler-Bernoulli beams leave out, counts: for deflections by the same loads, in the plane that bends, or for a frequency
    and its derivative by a thickness.

    Limit: 5 % of the deflection or of the frequency.
    Fix: a frame with `shear = true`, or a body of solid elements.
    """
    scene = solution.system.scene
    if not any(_is_thick(scene, name) for name in whole_bodies(scene)):
        return
    for body, part in sheared_parts(solution).items():
        if part > LIMIT:
            yield sheared.caution(
                f"{body} is short for a beam as it is bent here: shear, which Euler-Bernoulli beams leave out, would add some {part:.0%} "
                f"to deflections by the same loads. {sheared.fix}",
            )


def sheared_parts(solution: Solution) -> dict[str, float]:
    """Body -> energy of its shear in parts of that of all deformed beams, over the instants of the largest deflections."""
    names = {name: each for name, each in deforming(solution.system.scene).items() if _has_beams(solution.system.scene, name)}
    where = {name: elastic_coordinates(solution, name) for name in names}
    instants = largest_instants(np.concatenate([np.real(solution.q[:, each]) for each in where.values()], axis=1))
    found, whole, least = dict[str, float](), 0.0, 0.0
    for name, each in names.items():
        behind = chain(solution.system.scene, name)
        assert behind is not None
        shear, energy = shear_energies(behind, behind.displacements(np.real(solution.q[instants][:, where[name]])))
        body = getattr(each, "whole", name)
        found[body] = found.get(body, 0.0) + float(shear.sum())
        whole += float(energy.sum())
        least += STRAIN_ROUND_OFF**2 * float(beams_of(behind).axial @ beams_of(behind).lengths)
    return {body: shear / whole if whole > least else 0.0 for body, shear in found.items()}


def _has_beams(scene: ResolvedScene, name: str) -> bool:
    return not is_in_pieces(scene, name) and chain(scene, name) is not None


def _is_thick(scene: ResolvedScene, name: str) -> bool:
    """Whether shear could count between places as near to each other as are looked at."""
    behind = chain(scene, name) if not is_in_pieces(scene, name) else None
    if behind is None:
        return False
    found, size = beams_of(behind), float(np.linalg.norm(np.ptp(behind.nodes, axis=0)))
    return 3 * MODULI_RATIO * float(found.gyration.max()) > LIMIT * (SHORTEST_DISTANCE * size) ** 2


SUPPORT_FACTOR = 3.0
"""Factor by which vibrations between supports may have a larger error than a free wave."""
STEP = 1e-2
"""Relative change of the shear for the derivative by the thickness."""
MOST_NAMED = 3
"""Largest number of vibrations that are named."""


class Raised(NamedTuple):
    """Relative errors of one frequency, and of its derivative by the thickness of all beams."""

    value: float
    derivative: float

    def counts(self, differentiated: bool) -> bool:
        """Whether an error of those that are asked for exceeds `LIMIT`."""
        return self.value > LIMIT or (differentiated and self.derivative > LIMIT)


@check("shear")
def sheared_vibrations(solution: Solution, asked: Mapping[str, float], differentiated: bool) -> Iterator[Caution]:
    """Doubts about frequencies, by name, in cycles per time, that shear makes lower.

    Parameters
    ----------
    differentiated
        Whether their derivatives are asked for, too.
    """
    found = raised_by_stiff_shear(solution, asked, differentiated)
    high = {name: each for name, each in found.items() if each.counts(differentiated)}
    if not high:
        return
    first = list(high.items())[:MOST_NAMED]
    if (worst := max(high, key=lambda name: high[name].value)) not in dict(first):
        first[-1] = worst, high[worst]
    label = unit(solution.system.scene.units, "rate")
    told = [f"{name} of {asked[name]:.5g} {label} by some {_words(each, differentiated)}" for name, each in first]
    more = f" and {len(high) - len(first)} more" if len(high) > len(first) else ""
    yield sheared_vibrations.caution(
        f"Euler-Bernoulli beams leave shear out, so that frequencies of short waves are too high: {', '.join(told)}{more}. "
        "Fix: a frame with shear = true, or a body of solid elements.",
    )


def _words(found: Raised, differentiated: bool) -> str:
    return f"{found.value:.1%}" + (f" (its derivative by a thickness by {found.derivative:.0%})" if differentiated else "")


def raised_by_stiff_shear(solution: Solution, asked: Mapping[str, float], differentiated: bool) -> dict[str, Raised]:
    """Errors of those frequencies in which shear might count, by name."""
    scene, times = solution.system.scene, 1 + differentiated
    part = times * SUPPORT_FACTOR * max((_slowness(scene, name) for name in whole_bodies(scene) if asked), default=0.0)
    short = {name: value for name, value in asked.items() if part * value > LIMIT}
    return _raised(solution, short) if short else {}


def _slowness(scene: ResolvedScene, name: str) -> float:
    """Relative error of a free bending wave per cycle per time; zero where there are no beams."""
    behind = None if is_in_pieces(scene, name) else chain(scene, name)
    if behind is None:
        return 0.0
    found = beams_of(behind)
    (mass,) = flexible_body(scene, name).some_invariants(scene, "mass")
    per_stretch = float(np.real(mass)) / float(found.axial @ found.lengths)  # m / E A
    return float(np.pi * MODULI_RATIO * np.sqrt(per_stretch * found.gyration.max()))


def _raised(solution: Solution, asked: Mapping[str, float]) -> dict[str, Raised]:
    """Errors of frequencies, from the vibrations with shear that are most alike.

    These are scaled by the mass, so that their products with each other tell.
    """
    weights = solution.system.weights[: solution.system.n_q]
    motions, reduced = free_pencil(weights, real_pencil(any_pencil_of(solution)))
    soft = _soft_bodies(solution, motions)
    stiffness, mass = ((each + each.T) / 2 for each in (reduced.stiffness, reduced.mass))
    try:
        known, more, most = (
            scipy.linalg.eigh(stiffness - sum(each.lost(factor) for each in soft), mass) for factor in (0.0, 1.0, 1 + STEP)
        )
    except scipy.linalg.LinAlgError:
        return {}
    alike = [np.abs(each[1].T @ mass @ known[1]).argmax(axis=0) for each in (more, most)]
    squares = [known[0], *(each[0][where] for each, where in zip((more, most), alike, strict=True))]
    values = [np.sqrt(np.maximum(each, 0.0)) / (2 * np.pi) for each in squares]
    return {name: _of(values, int(np.abs(values[0] - value).argmin())) for name, value in asked.items()}


def _of(values: list[np.ndarray], k: int) -> Raised:
    """Errors of frequency k, from those without shear, with it, and with more of it.

    Shear goes with the square of the thickness.
    """
    known, true, softer = (float(each[k]) for each in values)
    if not true > 0:
        return Raised(np.inf, np.inf) if known > 0 else Raised(0.0, 0.0)
    slope = 1 + 2 * np.log(softer / true) / np.log1p(STEP) if softer > 0 else 0.0
    return Raised(known / true - 1, known / (true * slope) - 1 if slope > 0 else np.inf)


def _soft_bodies(solution: Solution, motions: np.ndarray) -> list[SoftElements]:
    """Shear of the elements of all beams, on the motions that joints allow."""
    found = []
    for name in deforming(solution.system.scene):
        behind = None if is_in_pieces(solution.system.scene, name) else chain(solution.system.scene, name)
        if behind is not None:
            found.append(soft_elements(behind, motions[elastic_coordinates(solution, name)]))
    return found
