"""Arc lengths of interface points as parameters of a body, where the shapes of its basis follow the places of the points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from preprocessing.basis.reduction import per_node
from preprocessing.discretisation.discretisation import DesignSpace
from toolkit.reduced_model.model import place_parameter


def with_places(space: DesignSpace) -> DesignSpace:
    """The space with a parameter for every interface point inside an element; at a node the polygon has a kink and no derivative."""
    nominal = space.nominal()
    empty = np.zeros((per_node(nominal.nodes) * len(nominal.nodes), 1))
    inside = {name for name, p in nominal.interfaces(empty).items() if p.arc_length_range[0] < p.arc_length_range[1]}
    free = {place_parameter(name): (name, nominal.places[name]) for name in nominal.places if name in inside}

    def discretise(design: Mapping[str, Any]) -> Any:
        found = space.discretise(design)
        moved = {name: found.places[name] + design[parameter] - s for parameter, (name, s) in free.items()}
        return replace(found, places={**found.places, **moved})

    return replace(
        space,
        values={**space.values, **{parameter: s for parameter, (_, s) in free.items()}},
        quantities={**space.quantities, **dict.fromkeys(free, "length")},
        discretise=discretise,
    )
