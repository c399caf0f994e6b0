"""Bases that hold no shape which stretches a body: the checks read axial forces from its stretch, and see none where forces pull at it.

What forces at points, weight and inertia do is then found without the basis (`unseen_forces`).

Judged by unit forces f at the points of the body: the axial forces N = F K^-1 Psi^T f of the basis against
those of all its elements.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial

import numpy as np

from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.flexible_bodies import design_point, flexible_body, used_interfaces
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.known_chain import chain
from toolkit.validity.bodies.compressed.unseen_forces import unseen_forces
from toolkit.validity.bodies.deformation import flexible_bodies
from toolkit.validity.bodies.element_accelerations import pull_of_frame
from toolkit.validity.bodies.static_deflection import static_deflection

SEEN = 0.2
"""Part of the axial forces that a basis may miss without a word."""


@check("tension", STATES)
def unseen_tension(solution: Solution) -> Iterator[Caution]:
    """Flexible bodies whose points forces pull at that their bases do not see, or whose weight and inertia do."""
    scene = solution.system.scene
    for body in flexible_bodies(scene):
        behind = chain(scene, body)
        if behind is not None and not behind.is_full:
            yield from unseen_forces(solution, body, _missing(scene, body, behind), partial(_by_mass, solution, body, behind))


def _pulls(scene: ResolvedScene, body: str, behind: Chain) -> dict[str, np.ndarray]:
    """Unit loads (d, n) on the nodes in all directions at interface points that the scene uses.

    The frame is no such point: forces at it do not stretch the body.
    """
    design, nodes = design_point(scene, body, "interfaces"), behind.nodes
    found = {}
    for name in used_interfaces(scene, body):
        place = np.real(design.interface(name).here[0])[:, 0]
        found[name] = _on(behind, [int(np.argmin(((nodes - place) ** 2).sum(axis=1)))])
    return found


def _by_mass(solution: Solution, body: str, behind: Chain, instants: np.ndarray) -> np.ndarray:
    """Axial forces (n_t, n_e) by weight and by the inertia of the frame's motion that the basis does not show; zero where a spin's
    stiffening is in the equations already."""
    scene = solution.system.scene
    alike, by_place, _ = pull_of_frame(solution, body, instants)
    pulls = alike[:, None] + np.einsum("tij,nj->tni", by_place, behind.nodes)
    if not np.any(pulls) or flexible_body(scene, body).stiffening(scene) is not None:
        return np.zeros((len(instants), 1))
    loads = np.zeros((len(instants), len(behind.nodes), behind.per_node))
    loads[:, :, : pulls.shape[2]] = pulls * _nodal_masses(scene, body, behind)[:, None]
    true, shown = axial_forces(scene, body, behind, loads.reshape(len(instants), -1))
    return true - shown


def _nodal_masses(scene: ResolvedScene, body: str, behind: Chain) -> np.ndarray:
    """Mass of the body by its nodes, (n_nodes,): of each element as its stiffness along it says, as of one material."""
    ends = behind.forms.dofs[:, [0, -1]] // behind.per_node
    lengths = np.linalg.norm(behind.nodes[ends[:, 1]] - behind.nodes[ends[:, 0]], axis=1)
    parts = behind.forms.law[:, 0, 0] * lengths**2
    found = np.zeros(len(behind.nodes))
    for side in (0, 1):
        np.add.at(found, ends[:, side], parts / 2)
    whole: np.ndarray = np.real(design_point(scene, body).value("mass")) * found / found.sum()
    return whole


def _on(behind: Chain, loaded: Iterable[int]) -> np.ndarray:
    d = behind.nodes.shape[1]
    loads = np.zeros((d, len(behind.nodes), behind.per_node))
    for axis in range(d):
        loads[axis, list(loaded), axis] = 1.0
    return loads.reshape(d, -1)


def _missing(scene: ResolvedScene, body: str, behind: Chain) -> dict[str, np.ndarray]:
    """Where forces pull -> axial forces (d, n_e) under unit forces that the basis does not show, if they are more than `SEEN`."""
    found = {}
    for name, loads in _pulls(scene, body, behind).items():
        true, shown = axial_forces(scene, body, behind, loads)
        if np.linalg.norm(shown - true) > SEEN * np.linalg.norm(true):
            found[name] = true - shown
    return found


def axial_forces(scene: ResolvedScene, body: str, behind: Chain, loads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Axial forces of the elements (n_t, n_e) under loads (n_t, n) on the nodes, and what the basis shows of them."""
    stiffness = np.real(design_point(scene, body).value("stiffness"))
    elastic = static_deflection(stiffness, behind.shapes.T @ loads.T).T
    return behind.axial_forces(behind.under(loads)), behind.axial_forces(behind.displacements(elastic))
