"""Bases that hold no shape which stretches a body: the checks read axial forces from its stretch, and see none where forces pull at it.

What forces at points do is then found without the basis (`unseen_forces`); of weight it is told that nobody knows.

Judged by unit forces f at the points of the body, and everywhere if it has weight: the axial forces N = F K^-1 Psi^T f of the basis against
those of all its elements.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from toolkit.foundation.verdict import Caution
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import design_point, flexible_body, used_interfaces
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.chain import Chain
from toolkit.validity.bodies.chains.known_chain import chain
from toolkit.validity.bodies.compressed.unseen_forces import unseen_forces
from toolkit.validity.bodies.deformation import flexible_bodies
from toolkit.validity.bodies.static_deflection import static_deflection

SEEN = 0.2
"""Part of the axial forces that a basis may miss without a word."""


WEIGHT = "its weight"


def unseen_tension(solution: Solution) -> Iterator[Caution]:
    """Flexible bodies whose points forces pull at that their bases do not see, or whose weight does."""
    scene = solution.system.scene
    for body in flexible_bodies(scene):
        behind = chain(scene, body)
        if behind is None or behind.is_full:
            continue
        missing = _missing(scene, body, behind)
        if WEIGHT in missing:
            yield unseen(scene, body, [WEIGHT])
        if missing.keys() - {WEIGHT}:
            yield from unseen_forces(solution, body, missing)


def unseen(scene: Scene, body: str, pulls: Sequence[str]) -> Caution:
    """That a body's basis does not show how some forces stretch it."""
    has_them = "interface" in flexible_body(scene, body).design_point(scene).model.left_out
    better = (
        "More modes in its basis show more of it" if has_them else 'A basis of kind "craig-bampton" holds these shapes for points'
    )
    return Caution(
        "unseen-tension",
        f"the basis of {body} holds no shapes that stretch it as forces of {', '.join(pulls)} would: how far these "
        "forces compress it is not known, and neither its critical load nor all of its large deformation is judged. "
        f"{better}.",
        doubt=False,
    )


def _pulls(scene: Scene, body: str, behind: Chain) -> dict[str, np.ndarray]:
    """Unit loads (d, n) on the nodes in all directions: at interface points that the scene uses, and everywhere if there is gravity.

    The frame is no such point: forces at it do not stretch the body.
    """
    design, nodes = design_point(scene, body, "interfaces"), behind.nodes
    found = {}
    for name in used_interfaces(scene, body):
        place = np.real(design.interface(name).here[0])[:, 0]
        found[name] = _on(behind, [int(np.argmin(((nodes - place) ** 2).sum(axis=1)))])
    if np.any(np.real(scene.gravity)):
        found[WEIGHT] = _on(behind, range(len(nodes)))
    return found


def _on(behind: Chain, loaded: Iterable[int]) -> np.ndarray:
    d = behind.nodes.shape[1]
    loads = np.zeros((d, len(behind.nodes), behind.per_node))
    for axis in range(d):
        loads[axis, list(loaded), axis] = 1.0
    return loads.reshape(d, -1)


def _missing(scene: Scene, body: str, behind: Chain) -> dict[str, np.ndarray]:
    """Where forces pull -> axial forces (d, n_e) under unit forces that the basis does not show, if they are more than `SEEN`."""
    found = {}
    for name, loads in _pulls(scene, body, behind).items():
        true, shown = axial_forces(scene, body, behind, loads)
        if np.linalg.norm(shown - true) > SEEN * np.linalg.norm(true):
            found[name] = true - shown
    return found


def axial_forces(scene: Scene, body: str, behind: Chain, loads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Axial forces of the elements (n_t, n_e) under loads (n_t, n) on the nodes, and what the basis shows of them."""
    stiffness = np.real(design_point(scene, body).value("stiffness"))
    elastic = static_deflection(stiffness, behind.shapes.T @ loads.T).T
    return behind.axial_forces(behind.under(loads)), behind.axial_forces(behind.displacements(elastic))
