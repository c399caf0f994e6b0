"""Every number of a scene in space is a design variable: direct differentiation = adjoint = complex step, for every kind there is."""

from __future__ import annotations

from fnmatch import fnmatch

import numpy as np
import pytest

from tests.models.curves import built_in_curves
from tests.models.directions import along, derivative_along, direction
from tests.models.spatial_cases import write_models
from tests.models.spatial_every_number import SCENES
from tests.scene_file.test_scene_units import differences
from tests.sensitivity.test_every_number import GOES_ON, NO_TURN, kinds_in, optional_numbers
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.scene.kinds import kinds_of

AGREEMENT = 1e-11
"""Of the response's largest derivative: round-off is 1e-16 times the 1/step^2 = 2500 and the condition 1e2 of the equations."""
ROUND_OFF = 1e-12
"""A derivative below this part of the response's largest one (numbers are of order one) is that one's round-off."""
TILTED = "the angle about an axis that is tilted against the only one of the motion changes in second order"
NO_EFFECT: dict[str, dict[str, str]] = {
    "wheels": {
        "bodies.follower.inertia.*": NO_TURN,
        "bodies.rack.inertia.*": NO_TURN,
        "points.N.*": "gravity is uniform, and a nut falls alike everywhere",
        "points.S.[xy]": "a rack is pushed alike wherever it is gripped along itself",
        "points.F.x": "the torque of its guide about x does not feel it, nor does its motion",
    },
    "linkage": {"bodies.car.inertia.*": NO_TURN, **GOES_ON},
    "frames": {
        "bodies.plate.inertia.*": NO_TURN,
        "bodies.sled.inertia.*": NO_TURN,
        "bodies.rubber.position.*": "nothing but uniform gravity and its own surface acts on the grounded body",
        "loads.coil.axis.*": TILTED,
    },
    "controlled": {
        "bodies.block.inertia.*": NO_TURN,
        "points.C.*": "the block slides along a straight line, wherever that is",
        "loads.motor.axis.*": TILTED,
        "loads.rub.axis.*": TILTED,
    },
}
"""Scene -> paths without effect on its motion by physics, and the reason."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    directory = tmp_path_factory.mktemp("models")
    write_models(directory)
    return directory


@pytest.fixture(
    scope="module",
    params=[
        *(f"{name} transient" for name in ("wheels", "linkage", "frames", "controlled")),
        *(f"{name} static" for name in ("frames", "controlled")),
    ],
)
def compared(request, folder):
    """Scene and kind, and the gradients of all responses of a scene by all its numbers, direct and adjoint."""
    name, kind = request.param.split()
    scene = SCENES[name](folder)
    return name, scene, kind, {m: gradients_by(m, scene, scene.available_paths(), kind) for m in ("direct", "adjoint")}


def largest(slopes: dict[str, float]) -> float:
    return max(abs(slope) for slope in slopes.values())


def test_direct_and_adjoint_agree(compared):
    for response, slopes in compared[-1]["adjoint"].gradients.items():
        exact = compared[-1]["direct"].gradients[response]
        assert slopes == pytest.approx(exact, rel=0, abs=AGREEMENT * largest(exact)), response


def test_a_complex_step_of_all_numbers_at_once_agrees(compared):
    _, scene, kind, by = compared
    factors = direction(scene.available_paths())
    for response, judge in derivative_along(scene, factors, kind, by["direct"].solution).items():
        exact = by["direct"].gradients[response]
        assert along(exact, factors) == pytest.approx(judge, rel=0, abs=AGREEMENT * largest(exact)), response


def test_every_number_has_an_effect_on_the_motion_unless_physics_says_no(compared):
    name, _, kind, by = compared
    gradients = by["direct"].gradients
    paths = next(iter(gradients.values())) if kind == "transient" else {}  # not every body is asked for at rest
    share = {x: max(abs(slopes[x]) / largest(slopes) for slopes in gradients.values()) for x in paths}
    without = {x for x in paths if any(fnmatch(x, pattern) for pattern in NO_EFFECT[name])}
    assert {x for x in paths if share[x] < 10 * ROUND_OFF} == without


def test_no_gradient_is_undefined(compared):
    assert all(
        np.isfinite(slope) for each in compared[-1].values() for slopes in each.gradients.values() for slope in slopes.values()
    )


def test_the_scenes_contain_every_kind_that_there_is(folder):
    """A new kind belongs into one of the scenes, and is then differentiated by every number it has."""
    scenes = [make(folder) for make in SCENES.values()]
    for group, kinds in kinds_of(3).items():
        shipped = {kind for kind, described in kinds.items() if described.__module__.startswith("toolkit.")} - {"ground"}
        assert shipped == {item.kind for scene in scenes for item in getattr(scene, group).values()}, group
    components = [item for scene in scenes for group in (scene.joints, scene.loads) for item in group.values()]
    assert built_in_curves() == set().union(*map(kinds_in, components))


def test_the_scenes_set_every_optional_number_of_every_kind(folder):
    given = set().union(*(optional_numbers(make(folder)) for make in SCENES.values()))
    left_out = {
        (kind, name)
        for kinds in kinds_of(3).values()
        for kind, described in kinds.items()
        if described.__module__.startswith("toolkit.") and kind != "ground"
        for name, field in described.model_fields.items()
        if field.default is None and name not in ("origin", "axis")  # a point's name, and what defines a frame's angle
    }
    assert left_out
    settings = {("flexible", "geometric_error"), ("flexible", "modes_per_frame")}  # no numbers of the body
    assert left_out - settings <= given


@pytest.mark.parametrize("name", SCENES)
def test_scenes_with_every_kind_of_component_do_not_depend_on_the_units(name, folder, tmp_path):
    scene = SCENES[name](folder)
    values, slopes = differences(scene, scene.available_paths(), tmp_path)
    # both runs round differently; Newton leaves 1e-10 of the model size, and squares that error in the step it stops at
    assert values < 1e-9
    # each derivative beside the largest of its response
    assert slopes < 1e-8


def test_letters_name_the_numbers_of_a_vector_too(folder):
    scene = SCENES["frames"](folder)
    design = scene.design_variables(["loads.pull.force.z", "joints.slot.axis.x", "bodies.strip.velocity.y"])
    assert [each.path for each in design] == ["loads.pull.force.2", "joints.slot.axis.0", "bodies.strip.velocity.1"]
    assert scene.with_number("loads.pull.force.z", 7.0).number("loads.pull.force.2") == 7.0
