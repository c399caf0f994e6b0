"""The compilation differentiates only what a number can change: it misses nothing, and does not look at the whole scene."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.benchmarks.chain import chain
from tests.models.scenes import hanging_skin
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.system.dependence import affected_by, affected_items, users_by_name
from toolkit.system.numbering import number
from toolkit.system.quantities import STEP, Quantities, evaluate_quantities

KINDS = ("start", "constant", "floating", "markers", "joints", "loads")


def changes(found: Quantities, kind: str) -> set[int]:
    """Numbers of those items that have an imaginary part anywhere."""
    return {k for k, part in getattr(found, kind).items() if is_complex(part)}


def is_complex(part: Any) -> bool:
    """Whether an array, or one within, has an imaginary part."""
    return any(map(is_complex, part)) if isinstance(part, tuple) else bool(np.any(np.imag(part) != 0))


def moved(scene: Scene, path: str) -> Scene:
    return scene.with_number(path, scene.number(path) + 1j * STEP)


def test_nothing_changes_but_what_is_differentiated():
    scene = loaded(hanging_skin())
    numbering, users = number(scene), users_by_name(scene)
    for path in scene.available_paths():
        everything = evaluate_quantities(moved(scene, path), numbering)
        some = evaluate_quantities(moved(scene, path), numbering, affected_by(scene, numbering.markers, [path], users))
        for kind in KINDS:
            assert changes(some, kind) == changes(everything, kind), (path, kind)


def test_a_point_in_a_chain_reaches_its_two_rods_and_their_joints():
    scene = loaded(chain(50))
    found = affected_items(scene, "points.P20.x", users_by_name(scene))
    rods = {("bodies", "rod19"), ("bodies", "rod20")}
    assert found == {("points", "P20"), *rods, ("joints", "J19"), ("joints", "J20"), ("joints", "J21")}


def test_gravity_reaches_all():
    assert affected_items(hanging_skin(), "loads.weight.acceleration.y", {}) is None
