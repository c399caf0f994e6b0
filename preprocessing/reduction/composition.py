"""What a body was made of, for its reduced model: nodes and elements by kind, volume, named places, what its mesh file holds besides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from preprocessing.assembly.assembly import Parts
from preprocessing.discretisation.discretisation import DesignSpace, Discretisation
from preprocessing.mesh.solid_mesh import SolidMesh
from toolkit.reduced_model.description.composition import (
    LONGEST_SENTENCE,
    Attributes,
    Composition,
    KeptLeftOut,
    KeptMass,
    PlaceOfNodes,
    place_of,
    plain_text,
)
from toolkit.reduced_model.model import InterfacePoint


def mesh_composition(mesh: SolidMesh, volume: float | None, clamped: np.ndarray, tied: Mapping[str, np.ndarray]) -> Attributes:
    """Composition of a body of solid elements, or of finished matrices.

    Parameters
    ----------
    volume : of its elements; None where it is not known
    clamped, tied : numbers of the clamped nodes, and of those that carry each interface point
    """
    return Composition(
        nodes=len(mesh.nodes),
        elements={kind: len(block) for kind, block in mesh.blocks.items()},
        volume=volume,
        interface_points={name: len(nodes) for name, nodes in tied.items()},
        clamp=_place(mesh.nodes, clamped) if len(clamped) else None,
        groups={plain_text(name): _place(mesh.nodes, nodes) for name, nodes in mesh.groups.items()},
        masses=[KeptMass(each.mass, [*each.place], len(each.carriers), plain_text(each.source)) for each in mesh.masses],
        left_out=[KeptLeftOut(plain_text(what), n, plain_text(why, LONGEST_SENTENCE)) for what, n, why in mesh.left_out],
        remarks=[plain_text(text, LONGEST_SENTENCE) for text in mesh.remarks],
    ).attributes()


def line_composition(
    space: DesignSpace, nominal: Discretisation, held: Sequence[int], interfaces: Mapping[str, InterfacePoint]
) -> Attributes:
    """Composition of a skin or a frame; `held` are the numbers of the clamped nodes."""
    nodes = np.real(nominal.nodes)
    return Composition(
        nodes=len(nodes),
        elements={"beam": len(nominal.element.connectivity)},
        volume=_volume_of_lines(space, nominal.parts),
        interface_points={name: 2 if np.ptp(point.arc_length_range) > 0 else 1 for name, point in interfaces.items()},
        clamp=_place(nodes, np.asarray(held)) if len(held) else None,
    ).attributes()


def _place(nodes: np.ndarray, numbers: np.ndarray) -> PlaceOfNodes:
    return place_of(nodes[numbers].tolist())


def _volume_of_lines(space: DesignSpace, parts: Parts) -> float | None:
    """The mass that the body would have if every density were one; None where some of its mass has no density."""
    dense = {name for name, quantity in space.quantities.items() if quantity == "density"}
    along = [part for part in parts.parts if part.name == (0, 0)]
    if not all(dense & dict(part.factors).keys() for part in along):
        return None
    at_one: dict[str, Any] = {**space.values, **dict.fromkeys(dense, 1.0)}
    motion = parts.coordinates.translations[0]
    mass = replace(parts, parts=tuple(along)).at(at_one).m[0]
    return float(np.real(motion @ (mass @ motion)))
