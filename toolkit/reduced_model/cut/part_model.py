"""A part of a body as a reduced model of its own, for all that looks at the finite elements behind a body."""

from __future__ import annotations

import numpy as np

from toolkit.reduced_model.cut.chain import Place
from toolkit.reduced_model.cut.part import Part
from toolkit.reduced_model.model import Chord, InterfacePoint, ReducedModel, StressPoints

FIRST, LAST = "first node", "last node"
"""Names of the interface points at the ends of a part."""


def part_model(part: Part, whole: ReducedModel) -> ReducedModel:
    """Reduced model of a part at the design that the part was made at; it contains no dependence on the design."""
    ends = {FIRST: Place(part.first, 0.0), LAST: Place(part.last - 1, 1.0)}
    stress = None
    if whole.stress is not None:
        found = {name: array[part.stress_rows] for name, array in vars(whole.stress).items()}
        stress = StressPoints(**{**found, "element": found["element"] - part.first})
    return ReducedModel(
        dimension=whole.dimension,
        units=whole.units,
        reference_condition=Chord(FIRST, LAST).condition,
        basis=whole.basis,
        nominal=whole.nominal,
        nominal_units=whole.nominal_units,
        input_hash=whole.input_hash,
        writers=whole.writers,
        invariants=part.invariants,
        interfaces={name: _at(part, place) for name, place in ends.items()},
        stress=stress,
        path=whole.path,
        **part.picture(whole),
    )


def _at(part: Part, place: Place) -> InterfacePoint:
    position, rotation = part.at(place)
    return InterfacePoint(np.array(place.station), np.full(2, place.station), position[None], rotation[None])
