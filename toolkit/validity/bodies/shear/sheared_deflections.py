"""Deflections that shear makes larger: by the energy that the shear forces of a state would have, in the plane in which it bends.

In the first order of shear the loads move by as much more, in parts of how they move, as the energy of shear is of all energy of the
deformed bodies (Castigliano): 3 E I / (kappa G A L^2) of a cantilever by a force at its end.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.flexible_bodies import deforming, elastic_coordinates, is_in_pieces
from toolkit.system.solution import Solution
from toolkit.validity.bodies.beam_assumptions import beams_of
from toolkit.validity.bodies.chains.known_chain import chain
from toolkit.validity.bodies.deformation import LIMIT, largest_instants, whole_bodies
from toolkit.validity.bodies.shear.soft_elements import STIFF, shear_energies

NEAREST = 1 / 20
"""Of the size of a body: loads and supports are not looked at that are nearer to each other."""
STRAIN = 1e-13
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
        least += STRAIN**2 * float(beams_of(behind).axial @ beams_of(behind).lengths)
    return {body: shear / whole if whole > least else 0.0 for body, shear in found.items()}


def _has_beams(scene: ResolvedScene, name: str) -> bool:
    return not is_in_pieces(scene, name) and chain(scene, name) is not None


def _is_thick(scene: ResolvedScene, name: str) -> bool:
    """Whether shear could count between places as near to each other as are looked at."""
    behind = chain(scene, name) if not is_in_pieces(scene, name) else None
    if behind is None:
        return False
    found, size = beams_of(behind), float(np.linalg.norm(np.ptp(behind.nodes, axis=0)))
    return 3 * STIFF * float(found.gyration.max()) > LIMIT * (NEAREST * size) ** 2
