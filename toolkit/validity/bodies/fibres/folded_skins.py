"""Skins so thick that their inner fibres fold where they are bent most: half the thickness exceeds the radius of the line they follow."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.itself import Itself
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.reduced_model.model import Mesh
from toolkit.system.flexible_bodies import is_in_pieces
from toolkit.system.solution import Solution
from toolkit.validity.description.mesh_cautions import bodies_of_stress

FINER = 2
"""How many times as many points as nodes the outline of a skin has at least, whose curvature it shows; that of a frame has its nodes."""


@check("folded-skin", STATES)
def folded_skins(solution: Solution) -> Iterator[Caution]:
    """Half the thickness of a skin exceeds the smallest radius of its contour: its inner side folds, and its stress means nothing there.

    Limit: half the thickness above the radius; a doubt where its stress is asked for.
    Fix: a thinner skin, or solid elements.

    There the inner fibre has no length, so that the curved beam that a straight element stands for does not exist; mass is counted twice.
    """
    scene = solution.system.scene
    for name, body in scene.bodies.items():
        if not isinstance(body, ModelBody) or is_in_pieces(scene, name):
            continue
        model = scene.model(body.model, "mesh")
        values = {**model.nominal, **body.model_values()}
        thickness = min((float(np.real(t)) for key, t in values.items() if key.startswith("thickness")), default=0.0)
        radius = smallest_radius(Itself(model.mesh)) if thickness > 0 and model.mesh is not None else np.inf
        if thickness > 2 * radius:
            yield folded_skins.caution(
                f"half the thickness of {name} ({thickness / 2:.3g} {unit(scene.units, 'length')}) exceeds the smallest radius of the line "
                f"that it follows ({radius:.3g}). Inner fibres fold there, and stresses mean nothing. Fix: make it thinner than "
                f"{2 * radius:.3g}, or of solid elements.",
                doubt=name in bodies_of_stress(scene),
            )


@lru_cache(maxsize=16)
def smallest_radius(same: Itself[Mesh]) -> float:
    """Smallest radius of circles through three successive points of a skin's contour; inf of a mesh that shows no contour of its own."""
    outline, nodes = np.real(same.item.outline), np.real(same.item.nodes)
    if len(outline) < FINER * len(nodes):
        return np.inf
    ends = sorted(int(np.argmin(np.linalg.norm(outline - node, axis=1))) for node in (nodes[0], nodes[-1]))
    sides = np.diff(outline[ends[0] : ends[1] + 1], axis=0)
    before, after = sides[:-1], sides[1:]
    area = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
    product = np.prod([np.linalg.norm(each, axis=1) for each in (before, after, before + after)], axis=0)
    return float(np.min(product[area > 0] / (2 * area[area > 0]), initial=np.inf))
