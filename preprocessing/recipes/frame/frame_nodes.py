"""Where the named nodes of a frame are: by coordinates, or at a length and an angle from another node."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from preprocessing.recipes.frame.frame_tables import PolarNode

AXES = "xyz"
POLAR = {"length": "length", "angle": "angle"}
"""Numbers of a node at a length and an angle, and what they are, for their units."""


def node_values(nodes: Mapping[str, Sequence[float]], polar: Mapping[str, PolarNode]) -> dict[str, float]:
    """Values of the nodes' parameters: `x_A` of a node with coordinates, `length_B` and `angle_B` of one without."""
    found = {f"{axis}_{name}": value for name, place in nodes.items() for axis, value in zip(AXES, place, strict=False)}
    return found | {f"{key}_{name}": getattr(each, key) for name, each in polar.items() for key in POLAR}


def positions(
    nodes: Mapping[str, Sequence[float]], polar: Mapping[str, PolarNode], design: Mapping[str, Any] | None = None
) -> dict[str, np.ndarray]:
    """Places (d,) of all nodes at a design, by default that of the file, real or complex; those with coordinates first."""
    values = node_values(nodes, polar) if design is None else design
    found = {name: np.array([values[f"{axis}_{name}"] for axis in AXES[: len(place)]]) for name, place in nodes.items()}
    for name in _in_order(polar, found):
        length, angle = values[f"length_{name}"], values[f"angle_{name}"]
        found[name] = found[polar[name].start] + length * np.array([np.cos(angle), np.sin(angle)])
    return {name: found[name] for name in [*nodes, *polar] if name in found}


def hanging_in_the_air(nodes: Mapping[str, Any], polar: Mapping[str, PolarNode]) -> list[str]:
    """Names of nodes that do not lead back to one with coordinates."""
    return [name for name in polar if name not in set(_in_order(polar, nodes))]


def _in_order(polar: Mapping[str, PolarNode], known: Mapping[str, Any]) -> Iterator[str]:
    """Names of nodes, each behind that of the node that it starts from."""
    placed, waiting = set(known), dict(polar)
    while ready := [name for name, each in waiting.items() if each.start in placed]:
        placed.update(ready)
        yield from ready
        waiting = {name: each for name, each in waiting.items() if name not in placed}
