"""Direct differentiation, the adjoint and the complex step agree on a spatial mechanism with a flexible rod."""

from __future__ import annotations

import pytest

from tests.models.directions import along, derivative_along, felt_direction
from tests.spatial.mechanism import spatial_crank
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.description.run_options import RunOptions
from toolkit.scene.scene import Scene

DESIGN = [
    "points.O.x",
    "bodies.rod.density_steel",
    "bodies.rod.youngs_modulus_steel",
    "bodies.rod.y_M",
    "bodies.crank.inertia.3",
    "joints.O.axis.0",
    "joints.slide.axis.1",
    "joints.drive.curve.height",
    "loads.pull.force.0",
    "loads.motor.torque.1",
    "loads.spring.damping",
]

SAME = 1e-9
"""All methods are exact for the discrete equations: round-off, times the ratio of stretching to bending stiffness; measured 3e-11."""


@pytest.fixture(scope="module")
def crank(tmp_path_factory) -> Scene:
    return spatial_crank(tmp_path_factory.mktemp("crank"))


def difference(scene: Scene, one: dict[str, dict[str, float]], other: dict[str, dict[str, float]]) -> float:
    """Largest difference of any derivative, relative to it, or to 1e-3 of the response's largest effect of a relative change."""
    worst = 0.0
    for name, slopes in one.items():
        size = {x: max(abs(scene.number(x)), 0.1) for x in slopes}
        largest = max(abs(slope) * size[x] for x, slope in slopes.items())
        worst = max(
            worst,
            *(abs(other[name][x] - slope) * size[x] / max(abs(slope) * size[x], 1e-3 * largest) for x, slope in slopes.items()),
        )
    return worst


@pytest.mark.parametrize("formulation", ["index-1", "index-3"])
def test_direct_and_adjoint_agree(crank, formulation):
    scene = crank.model_copy(update={"solver": crank.solver.model_copy(update={"formulation": formulation})})
    direct, adjoint = (gradients_by(method, scene, DESIGN, "transient") for method in ("direct", "adjoint"))
    assert adjoint.values == pytest.approx(direct.values, rel=1e-12)
    assert difference(scene, direct.gradients, adjoint.gradients) < SAME


def test_direct_and_complex_step_agree(crank):
    """Two steps, and one complex step along a direction in which every number counts: plain Python is slow."""
    scene = crank.model_copy(update={"solver": crank.solver.model_copy(update={"end_time": 0.08, "step": 0.04})})
    direct = gradients_by("direct", scene, DESIGN, "transient")
    factors = felt_direction(direct.gradients, 0.0)
    judge = derivative_along(scene, factors, "transient", direct.solution)
    for name, slopes in direct.gradients.items():
        assert along(slopes, factors) == pytest.approx(judge[name], rel=0, abs=SAME * max(map(abs, slopes.values()))), name


def test_gradients_of_the_equilibrium_agree(crank):
    """The driver stands at its end, the rod is bent by weight, spring and torque."""
    scene = crank.model_copy(update={"solver": RunOptions(end_time=0.2, load_steps=1, tolerance=1e-12)})
    direct, adjoint, judge = (
        gradients_by(method, scene, DESIGN[1:4], "static") for method in ("direct", "adjoint", "complex-step")
    )
    assert difference(scene, direct.gradients, adjoint.gradients) < SAME
    assert difference(scene, judge.gradients, direct.gradients) < SAME
