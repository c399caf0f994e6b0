"""Stress at one point of a flexible body, and along a line on it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

import numpy as np
from pydantic import model_validator

from toolkit.description.description import Pair, Positive, Quantity, Triple
from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import RESULT_TIE_BAND, first_largest, first_smallest
from toolkit.reduced_model.model import ReducedModel
from toolkit.responses.response import Instant, Partials
from toolkit.responses.stress import design_rates, kreisselmeier_steinhauser, point_slope, point_stress, stress_operator
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import Solution, elastic_coordinates, flexible_body

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Scalar

FARTHEST_STRESS_POINT = 0.25
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
        if away > FARTHEST_STRESS_POINT * np.ptp(self.place, axis=0).max():
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


FIBRES = {"outer": 1, "inner": -1, None: 0}
SAMPLES = 400
"""Places along a line whose nearest stress points are those of the line."""


class LocalStress(Instant):
    """Base of stresses at chosen stress points of a flexible body; the stress of solids is von Mises'.

    Attributes
    ----------
    body
        Name of a flexible body.
    fibre
        Of a skin or a beam: the outer or the inner fibre; by default the first of those that are nearest.
    """

    quantity = "stress"

    body: str
    fibre: Literal["outer", "inner"] | None = None

    @abstractmethod
    def rows(self, scene: ResolvedScene) -> list[int]:
        """Numbers of the stress points that the response uses."""

    @abstractmethod
    def reduced(self, stress: np.ndarray) -> tuple[Scalar, np.ndarray]:
        """Value of the response from the stresses (r,) at these points, and its derivatives by them (r,)."""

    def check(self, scene: ResolvedScene) -> None:
        """Refuse a body that is not flexible, or has no stress points there."""
        super().check(scene)
        self.rows(scene)

    def at(self, solution: Solution, step: int) -> Partials:
        """Stress and its partial derivatives at a step, from the rows of the stress operator."""
        return self.instants(solution)(step)

    def instants(self, solution: Solution) -> Callable[[int], Partials]:
        """Stress and its partial derivatives, step by step; rows and their design derivatives are found once for all steps."""
        scene, system = solution.system.scene, solution.system
        where, rows = elastic_coordinates(solution, self.body), self.rows(scene)
        whole = stress_operator(scene, self.body)
        operator, rates = whole[rows], design_rates(solution, self.body, "stress_operator")
        row, component, coordinate = np.unravel_index(rates.entry, whole.shape)
        ours = np.isin(row, rows)
        place = np.searchsorted(rows, row[ours]), component[ours]

        def look(step: int) -> Partials:
            q_f = solution.q[step, where]
            components = operator @ q_f
            value, weights = self.reduced(point_stress(components))
            by_component = np.real(weights)[:, None] * np.real(point_slope(components))
            slope = np.zeros(system.n_q)
            slope[where] = np.einsum("rc,rcf->f", by_component, np.real(operator))
            change = by_component[place] * np.real(q_f)[coordinate[ours]] * rates.value[ours]
            return Partials(value, q=slope, design=np.bincount(rates.parameter[ours], change, system.n_x))

        return look


class StressAtPoint(LocalStress):
    """Stress at the stress point of a flexible body that is nearest to a place.

    Attributes
    ----------
    place
        The place on the undeformed body, in the axes of its reduced model.
    """

    kind = "stress-at-point"

    place: Annotated[Pair | Triple, Quantity("length")]

    def rows(self, scene: ResolvedScene) -> list[int]:
        """Number of the stress point that is nearest to the place."""
        refuse_other_space(self.place, scene)
        return [stress_places(scene, self.body).near(np.array(self.place), FIBRES[self.fibre])]

    def reduced(self, stress: np.ndarray) -> tuple[Scalar, np.ndarray]:
        """Stress at the only point, and its derivative: one."""
        return stress[0], np.ones(1)


class StressAlongLine(LocalStress):
    """Stress along a straight line on a flexible body: the largest, the mean or the smooth largest at the stress points nearest to it.

    Attributes
    ----------
    places
        Begin and end of the line on the undeformed body, in the axes of its reduced model.
    take
        The largest (its derivative is that of the point where it occurs), the mean of the stress points, or the smooth largest (KS).
    aggregation
        Parameter rho of the smooth largest, in 1/unit of stress.
    """

    kind = "stress-along-line"

    places: Annotated[tuple[Pair, Pair] | tuple[Triple, Triple], Quantity("length")]
    take: Literal["largest", "mean", "ks"] = "largest"
    aggregation: Annotated[Positive | None, Quantity("1/stress")] = None

    @model_validator(mode="after")
    def _sharp(self) -> StressAlongLine:
        if (self.take == "ks") != (self.aggregation is not None):
            raise ValueError('`aggregation` belongs to take = "ks" and to no other')
        return self

    def rows(self, scene: ResolvedScene) -> list[int]:
        """Numbers of the stress points nearest to places along the line, each once."""
        for place in self.places:
            refuse_other_space(place, scene)
        known, (begin, end) = stress_places(scene, self.body), map(np.array, self.places)
        for end_of_line in (begin, end):
            known.near(end_of_line, FIBRES[self.fibre])
        along = [begin + share * (end - begin) for share in np.linspace(0, 1, SAMPLES)]
        return sorted({known.nearest(place, FIBRES[self.fibre]) for place in along})

    def reduced(self, stress: np.ndarray) -> tuple[Scalar, np.ndarray]:
        """One number from the stresses along the line, as `take` or the aggregation says, and its derivatives by them."""
        if self.aggregation is not None:
            return kreisselmeier_steinhauser(stress, self.aggregation)
        if self.take == "mean":
            return stress.mean(), np.full(len(stress), 1 / len(stress))
        place = first_largest(np.real(stress), RESULT_TIE_BAND)
        return stress[place], (np.arange(len(stress)) == place).astype(float)


def refuse_other_space(place: tuple[float, ...], scene: ResolvedScene) -> None:
    """Refuse a place with more or fewer numbers than the scene's space has.

    Raises
    ------
    InputError
        Says how many there are to be.
    """
    if len(place) != scene.dimension:
        raise InputError(f"a place in a scene of dimension {scene.dimension} has {scene.dimension} numbers, not {len(place)}.")
