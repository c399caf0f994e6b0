"""Where the stress points of a flexible body are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import first_smallest
from toolkit.reduced_model.model import ReducedModel
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.flexible_bodies import flexible_body

FAR = 0.25
"""Part of a body's extent that the nearest stress point may be away from the place that is asked for."""


class StressPlaces(NamedTuple):
    """Undeformed places of all stress points (n_s, d) in the axes of the reduced model, and their fibres (n_s,): 1, -1, or 0 of a solid."""

    place: np.ndarray
    fibre: np.ndarray

    def nearest(self, place: np.ndarray, fibre: int) -> int:
        """Number of the stress point of a fibre (0 for any) that is nearest to a place; of equally near ones the first.

        Raises
        ------
        InputError
            There is none of that fibre.
        """
        rows = np.flatnonzero((self.fibre == fibre) | (fibre == 0))
        if not len(rows):
            raise InputError("the body has stress points without fibres, as solids have; leave `fibre` out.")
        return int(rows[first_smallest(np.sqrt(np.sum((self.place[rows] - place) ** 2, axis=1)))])

    def near(self, place: np.ndarray, fibre: int) -> int:
        """Number of the nearest stress point, as `nearest`, if it is near the place.

        Raises
        ------
        InputError
            There is none of that fibre, or none anywhere near; names the nearest.
        """
        found = self.nearest(place, fibre)
        away = np.sqrt(np.sum((self.place[found] - place) ** 2))
        if away > FAR * np.ptp(self.place, axis=0).max():
            nearest, there = (", ".join(f"{x:.6g}" for x in each) for each in (self.place[found], place))
            raise InputError(
                f"there is no stress point near [{there}]; the nearest is at [{nearest}]. Places are those of the undeformed body in the "
                "axes of its reduced model."
            )
        return found


def stress_places(scene: ResolvedScene, body: str) -> StressPlaces:
    """Places of the stress points of a flexible body.

    Raises
    ------
    InputError
        The body is not flexible, or its reduced model does not say where its stress points are.
    """
    path = flexible_body(scene, body).model
    model = scene.model(path, "mesh", "outline", "stress", "surface")
    place, count = _places(model), len(model.invariants.stress_operator)
    if place is None or len(place) != count or not count:
        raise InputError(
            f"the reduced model {path!r} does not say where its {count} stress points are. Ask for the largest stress of the body "
            "(max-stress, ks-stress), or build the model anew from its mesh."
        )
    fibre = np.zeros(count, int) if model.stress is None else np.sign(model.stress.fibre).astype(int)
    return StressPlaces(place, fibre)


def _places(model: ReducedModel) -> np.ndarray | None:
    """Places (n_s, d) at element ends, edge middles, surface points or ends of surface lines; None if the model has none."""
    mesh, outline, surface, stress = model.mesh, model.outline, model.surface, model.stress
    found: np.ndarray | None = None
    if mesh is not None and stress is not None:
        found = mesh.nodes[mesh.connectivity[stress.element, stress.end]]
    elif outline is not None:
        points, (first, middle, last) = outline.position[:, :, 0], outline.edges.T
        found = np.where((first == middle)[:, None], (points[first] + points[last]) / 2, points[middle])
    elif surface is not None and model.invariants.stress_operator.shape[1] == 1:
        found = surface.position[surface.lines.ravel(), :, 0]
    elif surface is not None:
        found = surface.position[:, :, 0]
    return found
