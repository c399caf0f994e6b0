"""Arc lengths of interface points as parameters of a body, where the shapes of its basis follow the places of the points."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from preprocessing.basis.reduction import per_node
from preprocessing.discretisation.discretisation import DesignSpace
from toolkit.reduced_model.model import place_parameter


def with_places(space: DesignSpace, followed: Collection[str] | None = None) -> DesignSpace:
    """Design space with a parameter for every interface point inside an element, or for those that are `followed`.

    At a node the polygon has a kink and no derivative.
    """
    if followed is not None and not followed:
        return space
    nominal = space.nominal()
    empty = np.zeros((per_node(nominal.nodes) * len(nominal.nodes), 1))
    inside = {name for name, p in nominal.interfaces(empty).items() if p.arc_length_range[0] < p.arc_length_range[1]}
    wanted = inside if followed is None else inside & set(followed)
    free = {place_parameter(name): (name, nominal.places[name]) for name in nominal.places if name in wanted}

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
