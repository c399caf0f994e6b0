"""Bases that hold no shape which stretches a body: the checks read axial forces from its stretch, and see none where forces pull at it.

Judged by unit forces f at the points of the body, and everywhere if it has weight: the axial forces N = F K^-1 Psi^T f of the basis against
those of all its elements.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from toolkit.foundation.verdict import Caution
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import design_point
from toolkit.validity.bodies.compressed.geometric_stiffness import axial_forces
from toolkit.validity.bodies.deformation import Chain, chain, flexible_bodies

SEEN = 0.2
"""Part of the axial forces that a basis may miss without a word."""


WEIGHT = "its weight"


def unseen_tension(scene: Scene) -> Iterator[Caution]:
    """Flexible bodies at whose points forces may pull that their bases do not see, or whose weight does."""
    for body in flexible_bodies(scene):
        behind = None if _is_full(scene, body) else chain(scene, body)
        pulls = {} if behind is None else _pulls(scene, body, behind)
        blind = [name for name, loads in pulls.items() if behind is not None and missed_part(scene, body, behind, loads) > SEEN]
        if blind:
            yield Caution(
                "unseen-tension",
                f"the basis of {body} holds no shapes that stretch it as forces of {', '.join(blind)} would: how far these "
                "forces compress it is not known, and neither its critical load nor all of its large deformation is judged. A basis of "
                'kind "craig-bampton" holds these shapes for points.',
                doubt=False,
            )


def _pulls(scene: Scene, body: str, behind: Chain) -> dict[str, np.ndarray]:
    """Unit loads (2, n) on the nodes in both directions: at interface points that the scene uses, and everywhere if there is gravity.

    The frame is no such point: forces at it do not stretch the body.
    """
    design, nodes = design_point(scene, body, "interfaces"), behind.elements.nodes
    used = {getattr(place, "interface", None) for place in scene.points.values() if getattr(place, "body", None) == body}
    found = {}
    for name in sorted(set(design.model.interfaces or {}) & used):
        place = np.real(design.interface(name).here[0])[:, 0]
        found[repr(name)] = _on(nodes, [int(np.argmin(((nodes - place) ** 2).sum(axis=1)))])
    if np.any(np.real(scene.gravity)):
        found[WEIGHT] = _on(nodes, range(len(nodes)))
    return found


def _on(nodes: np.ndarray, loaded: Iterable[int]) -> np.ndarray:
    loads = np.zeros((2, len(nodes), 3))
    loads[0, list(loaded), 0] = loads[1, list(loaded), 1] = 1.0
    return loads.reshape(2, -1)


def _is_full(scene: Scene, body: str) -> bool:
    """Whether the basis holds all shapes that there are: all coordinates of nodes but the three of the frame."""
    mesh = design_point(scene, body, "mesh").model.mesh
    return mesh is None or mesh.recovery.shape[1] - 1 + 3 >= mesh.recovery.shape[0]


def missed_part(scene: Scene, body: str, behind: Chain, loads: np.ndarray) -> float:
    """Part of the axial forces under loads (n_t, n) on the nodes that the basis does not show."""
    true = axial_forces(behind, behind.under(loads))
    stiffness = np.real(design_point(scene, body).value("stiffness"))
    scale = 1 / np.sqrt(np.diag(stiffness))
    elastic = scale * np.linalg.solve(scale[:, None] * stiffness * scale, scale[:, None] * (behind.shapes.T @ loads.T)).T
    largest = np.linalg.norm(true)
    return float(np.linalg.norm(axial_forces(behind, behind.displacements(elastic)) - true) / largest) if largest else 0.0
