"""Joints of every kind at a body with three frames: gradients are complex steps, and a stiff body is that with one frame."""

from __future__ import annotations

from typing import Any

import pytest

from tests.models.cut_hub import YOUNG, hub, joints_of
from tests.models.directions import along, derivative_along, direction
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.sensitivity.preparation import Kind, evaluate_responses, prepare, solve
from toolkit.scene.scene import Scene

AGREEMENT = 1e-10
"""Round-off is 1e-16 times the 1/step^2 = 1e4 and a condition of 1e2; half the step leaves four times as much."""
GROUPS = [(dimension, range(first, len(joints_of(dimension)), 3)) for dimension in (2, 3) for first in range(3)]
"""Dimension and numbers of joints: scenes hold at most eight kinds."""
BESIDE = ("loads.", "bodies.block")
"""Beginning of what is no number of a joint, a point or the beam."""
EVERY = pytest.mark.parametrize(("dimension", "joints"), GROUPS)


def disagreement(
    scene: Scene, kind: Kind, methods: tuple[str, ...] = ("direct", "adjoint"), judged: bool = True
) -> dict[str, float]:
    """Response -> by how much derivatives differ between methods, in parts of the largest, and from a complex step of all at once, in
    parts of the sum of their sizes."""
    paths = [path for path in scene.available_paths() if not path.startswith(BESIDE)]
    first, *others = (gradients_by(method, scene, paths, kind) for method in methods)
    factors = direction(paths)
    exact = derivative_along(scene, factors, kind, first.solution) if judged else {}
    found: dict[str, float] = {}
    for name, slopes in first.gradients.items():
        largest = max(map(abs, slopes.values())) or 1.0  # a pin has no torque
        gaps = [abs(other.gradients[name][x] - slope) / largest for other in others for x, slope in slopes.items()]
        terms = sum(abs(factors[x] * slope) for x, slope in slopes.items()) or 1.0
        gaps += [abs(along(slopes, factors) - exact[name]) / terms] if judged else []
        found[name] = max(gaps)
    return found


def agree(*args: Any, **options: Any) -> None:
    found = disagreement(*args, **options)
    assert {name: gap for name, gap in found.items() if not gap < AGREEMENT} == {}


@EVERY
def test_gradients_of_a_motion_are_complex_steps(tmp_path, dimension, joints):
    """By all numbers of the scene: every joint at a point inside of a part, or at the end, as its first or its second body."""
    agree(hub(tmp_path, dimension, joints), "transient")


@EVERY
def test_gradients_of_an_equilibrium_agree_and_a_stiff_body_is_that_with_one_frame(tmp_path, dimension, joints):
    """What frames change is of second order in the deflection: a hundred times stiffer, a ten thousandth of it."""
    agree(hub(tmp_path, dimension, joints), "static", judged=dimension == 2)
    errors = []
    for factor in (1e2, 1e4):
        scenes = [hub(tmp_path, dimension, joints, frames, factor * YOUNG) for frames in (1, (1, 3))]
        one, three = (evaluate_responses(solve(prepare(scene), "static")) for scene in scenes)
        kinds = {name: name.split()[0] for name in one if " " in name}
        sizes = {kind: max(abs(one[name]) for name in kinds if kinds[name] == kind) for kind in kinds.values()}
        errors.append(max(abs(three[name] - one[name]) / sizes[kind] for name, kind in kinds.items()))
    assert errors[0] < 1e-6
    assert errors[1] < 1e-3 * errors[0] + 1e-10  # what Newton leaves
