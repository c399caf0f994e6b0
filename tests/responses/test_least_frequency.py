"""The least frequency on the way of a load: against the closed form of a truss that nearly snaps, and of ends of the way."""

from __future__ import annotations

import numpy as np
import pytest

from tests.models.scenes import WING
from tests.responses.test_load_margin import FORCE, HALF, RISE, SNAPPING, STIFFNESS, truss
from tests.scene_file.test_schemas import complaints
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.statics import solve_statics
from toolkit.components.loads.springs import SpatialSpringDamper, SpringDamper
from toolkit.description.design import Point
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.responses.least_frequency import LeastFrequency
from toolkit.responses.vibration import Frequency
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene

UPRIGHT = 200.0
"""Stiffness of a spring below the block, so that it goes through the flat angle without snapping."""
NUMBERS = ("loads.left.stiffness", "loads.right.stiffness", "loads.below.stiffness", "bodies.block.mass")


def nearly(dimension: int, force: float) -> Scene:
    scene = truss(dimension, force=force)
    spring = SpringDamper if dimension == 2 else SpatialSpringDamper
    below = spring(bodies=("block", "ground"), points=("T", "V"), stiffness=UPRIGHT)
    deep = Point(x=0.0, y=-5.0, **({} if dimension == 2 else {"z": 0.0}))
    return scene.model_copy(
        update={
            "points": {**scene.points, "V": deep},
            "loads": {**scene.loads, "below": below},
            "responses": {"least": LeastFrequency(), "end": Frequency()},
        }
    )


@pytest.mark.parametrize(("dimension", "method"), [(2, "direct"), (2, "adjoint"), (2, "complex-step"), (3, "direct")])
def test_it_is_that_of_the_flat_truss_half_way(dimension, method):
    """K = k_below + 2 k (1 - L/b) where the springs, of undeformed length L, are flat: under whatever force the block comes by there."""
    scene = nearly(dimension, 150.0)
    force = "loads.push.force.y" if dimension == 2 else "loads.push.force.1"
    found = gradients_by(method, scene, [*NUMBERS, force], "static")
    part = 1 - np.hypot(HALF, RISE) / HALF
    stiffness = UPRIGHT + 2 * STIFFNESS * part
    least, slopes = found.values["least"], found.gradients["least"]
    assert least == pytest.approx(np.sqrt(stiffness) / (2 * np.pi), rel=1e-12)  # the mass is 1
    assert found.values["end"] > 1.2 * least
    by_stiffness = least / (2 * stiffness)
    expected = [by_stiffness * part, by_stiffness * part, by_stiffness, -least / 2]
    assert [slopes[name] for name in NUMBERS] == pytest.approx(expected, rel=1e-8)
    assert abs(slopes[force]) < 1e-8 * least / 150.0  # more force only comes by there earlier


@pytest.mark.parametrize(("force", "end"), [(0.5 * FORCE, True), (-150.0, False)])
def test_where_it_falls_or_rises_all_the_way_it_is_that_of_an_end(force, end):
    """Pressed a little, the truss is softest under the full load; drawn upwards, without load."""
    found = gradients_by("direct", nearly(2, force), [*NUMBERS, "loads.push.force.y"], "static")
    least, slopes = found.values["least"], found.gradients["least"]
    if end:
        assert least == pytest.approx(found.values["end"], rel=1e-12)
        assert slopes == pytest.approx(found.gradients["end"], rel=1e-8)
        return
    flat = HALF**2 / np.hypot(HALF, RISE) ** 2
    assert least == pytest.approx(np.sqrt(UPRIGHT + 2 * STIFFNESS * (1 - flat)) / (2 * np.pi), rel=1e-12)
    assert slopes["loads.push.force.y"] == pytest.approx(0.0, abs=1e-12)


def test_more_torque_only_comes_by_the_softest_place_of_the_wing_earlier():
    """The torque is all the load, so that the least frequency does not depend on it, at a fifth of the load where it is least."""
    found = LeastFrequency().partials(solve_statics(compile_scene(read_scene(WING), ["M_t", "points.D.x"])))
    assert abs(found.design[0]) < 1e-6 * found.value / 4200.0
    assert abs(found.design[1]) > 0.01 * found.value


def test_beside_a_known_equilibrium_the_way_is_found_anew():
    system = compile_scene(nearly(2, 150.0))
    whole = solve_statics(system)
    beside = solve_statics(system, start=whole)
    assert beside.path is None
    assert LeastFrequency().partials(beside).value == pytest.approx(LeastFrequency().partials(whole).value, rel=1e-10)


def test_a_way_that_has_snapped_is_refused():
    scene = read_scene(SNAPPING, {"solver.continuation": "arc-length"}).model_copy(
        update={"responses": {"least": LeastFrequency()}}
    )
    with pytest.raises(InputError, match="does not snap through"):
        gradients_by("direct", scene, list(scene.design)[:1], "static")


def test_it_meets_the_schema():
    assert complaints({"units": "m-kg-s", "bodies": {}, "responses": {"m": {"type": "least-frequency"}}}, "scene") == []
