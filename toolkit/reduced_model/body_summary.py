"""What a body is, as numbers: mass, centre, inertia, volume, counts, and where its interface points and groups are."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.units import unit
from toolkit.reduced_model.composition import Composition, PlaceOfNodes, read_composition
from toolkit.reduced_model.model import ReducedModel
from toolkit.reduced_model.parts import SpatialInvariants, all_second_moments
from toolkit.reduced_model.told_body import BodySummary, MassRecord, NodesRecord, PointRecord

ROUND_OFF = 1e-13
"""Part of the body's size, or of its inertia, below which a coordinate of the centre or a product of inertia is round-off."""
NOT_KEPT = (
    "The file of this model does not keep its nodes, elements, volume and groups; ffrf-preprocess --force builds one that does."
)


def body_summary(model: ReducedModel) -> BodySummary:
    """Summary of a reduced model's body at its nominal design, in the units of its system.

    Returns
    -------
    summary
        `mass`, `centre`, `inertia` (about the centre; a tensor in space, a number in the plane), `volume`, `nodes`, `elements` by kind,
        `units`, `interface_points` and `groups` with `position` and number of `nodes`, `clamp`, concentrated `masses`, `left_out`,
        `remarks`, and `not_listed`: how many more groups and so on there are. None is what is not known.
    """
    kept = read_composition(model.composition, model.dimension)
    centre, inertia = centre_and_inertia(model)
    length, mass = unit(model.units, "length"), unit(model.units, "mass")
    return {
        "mass": float(np.real(model.invariants.mass)),
        "centre": centre.tolist(),
        "inertia": inertia.tolist(),
        "volume": kept.volume,
        "nodes": kept.nodes,
        "elements": dict(kept.elements) if model.composition else None,
        "units": {
            "mass": mass,
            "centre": length,
            "inertia": f"{mass} {length}^2",
            "volume": f"{length}^3",
            "position": length,
        },
        "interface_points": _interface_points(model, kept),
        "clamp": kept.clamp and _nodes(kept.clamp),
        "groups": {name: _nodes(each) for name, each in kept.groups.items()},
        "masses": [MassRecord(mass=m.mass, position=m.position, nodes=m.nodes, source=m.source) for m in kept.masses],
        "left_out": [each._asdict() for each in kept.left_out],
        "remarks": [*kept.remarks, *([] if model.composition else [NOT_KEPT])],
        "not_listed": dict(kept.not_listed),
    }


def _nodes(place: PlaceOfNodes) -> NodesRecord:
    return {"position": place.position, "nodes": place.nodes}


def centre_and_inertia(model: ReducedModel) -> tuple[np.ndarray, np.ndarray]:
    """Centre of mass (d,), and the inertia about it: (3, 3) in space, () in the plane."""
    inv, mass = model.invariants, float(np.real(model.invariants.mass))
    centre = np.real(inv.first_moment[:, 0]) / mass
    if isinstance(inv, SpatialInvariants):
        moments = np.real(all_second_moments(inv.second_moment)[:, :, 0, 0]) - mass * np.outer(centre, centre)
        inertia = np.trace(moments) * np.eye(3) - moments
        radius = np.sqrt(max(np.trace(moments), 0.0) / mass)
    else:
        inertia = np.real(inv.inertia[0, 0]) - mass * centre @ centre
        radius = np.sqrt(max(float(inertia), 0.0) / mass)
    return _without_round_off(centre, radius + np.abs(centre).max()), _without_round_off(inertia, np.abs(inertia).max())


def _without_round_off(numbers: np.ndarray, scale: float) -> np.ndarray:
    return np.where(np.abs(numbers) > ROUND_OFF * scale, numbers, 0.0)


def _interface_points(model: ReducedModel, kept: Composition) -> dict[str, PointRecord]:
    places = {name: np.real(point.position[0, :, 0]).tolist() for name, point in (model.interfaces or {}).items()}
    return {name: {"position": place, "nodes": kept.interface_points.get(name)} for name, place in places.items()}
