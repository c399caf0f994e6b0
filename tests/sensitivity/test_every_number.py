"""Every number of a scene is a design variable: direct differentiation = adjoint = complex step, for every kind there is."""

from __future__ import annotations

from fnmatch import fnmatch

import numpy as np
import pytest

from tests.models.cases import write_models
from tests.models.curves import built_in_curves
from tests.models.directions import along, derivative_along, direction, felt_direction
from tests.models.every_number import SCENES, rods
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.components.bodies.ground import Ground
from toolkit.components.curves.catalogue import Curve
from toolkit.description.description import Description
from toolkit.foundation.errors import InputError
from toolkit.scene.kinds import kinds_of
from toolkit.scene.scene import Scene

AGREEMENT = 1e-9
"""All methods are exact for the discrete equations; round-off is 1e-16 times the 1/step^2 = 2500 and the condition 1e3."""
ROUND_OFF = 1e-12
"""A derivative below this part of the response's largest one (numbers are of order one) is that one's round-off."""

NO_TURN = "the body does not turn"
AT_REST = "nothing moves in an equilibrium"
LED = "an integral makes the error zero, whatever the gains are"
SLIDES = {
    "bodies.block.inertia": "the block does not turn",
    "points.C.*": "it slides along a straight line, wherever that is",
}
GOES_ON = {
    "joints.*.terms.*.curves.1.coefficients.0": "a curve of a sequence goes on from the value that the one before has reached"
}
NO_EFFECT: dict[tuple[str, str], dict[str, str]] = {
    ("flight", "transient"): {},
    ("wheels", "transient"): {"bodies.follower.inertia": NO_TURN, "bodies.rack.inertia": NO_TURN},
    ("rods", "transient"): GOES_ON,
    ("swing", "transient"): GOES_ON,
    ("beams", "transient"): {},
    ("controlled", "transient"): SLIDES,
    ("controlled", "static"): {
        **SLIDES,
        "loads.*_gain": LED,
        "loads.rub.*": AT_REST,
        "loads.slip.*": AT_REST,
        "bodies.crank.angular_velocity": AT_REST,
    },
    ("swing", "static"): {
        **GOES_ON,
        "bodies.*.velocity.*": AT_REST,
        "bodies.*.inertia": AT_REST,
        "loads.*.damping": AT_REST,
        "loads.thrust.curve.*.0": "straight lines between points: the load at the end of the time is between the second and the third",
    },
    ("beams", "static"): {
        "bodies.strip.angular_velocity": AT_REST,
        "loads.*.damping": AT_REST,
        "bodies.*.damping_mass": AT_REST,
        "bodies.*.damping_stiffness": AT_REST,
        "bodies.strip.position.*": "where a floating body begins to look for its equilibrium is not where it finds it",
    },
}
"""Scene and analysis -> paths without effect by physics, and the reason. The linkage of `rods` is free to move: it has no equilibrium."""

Gradients = dict[str, dict[str, float]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    directory = tmp_path_factory.mktemp("models")
    write_models(directory)
    return directory


@pytest.fixture(scope="module", params=NO_EFFECT, ids="-".join)
def compared(request, folder) -> tuple[tuple[str, str], Scene, list[str], dict[str, Gradients]]:
    """Gradients of all responses of a scene by all its numbers, direct and adjoint."""
    scene = SCENES[request.param[0]](folder)
    paths = scene.available_paths()
    return (
        request.param,
        scene,
        paths,
        {m: gradients_by(m, scene, paths, request.param[1]).gradients for m in ("direct", "adjoint")},
    )


def largest(slopes: dict[str, float]) -> float:
    """Largest derivative of a response."""
    return max(abs(slope) for slope in slopes.values())


def test_direct_and_adjoint_agree_on_every_number(compared):
    *_, by = compared
    for response, slopes in by["direct"].items():
        expected = pytest.approx(slopes, rel=AGREEMENT, abs=ROUND_OFF * largest(slopes))
        assert by["adjoint"][response] == expected, response


def test_a_complex_step_of_all_numbers_at_once_agrees(compared):
    """Once as the numbers are, and once so that every number counts by its own size."""
    (_, kind), scene, paths, by = compared
    known = solve(prepare(scene), kind)
    for factors in (direction(paths), felt_direction(by["direct"], 10 * ROUND_OFF)):
        for response, judge in derivative_along(scene, factors, kind, known).items():
            slopes = by["direct"][response]
            assert along(slopes, factors) == pytest.approx(judge, rel=0, abs=AGREEMENT * largest(slopes)), response


def test_every_number_has_an_effect_unless_physics_says_no(compared):
    case, _, paths, by = compared
    share = {x: max(abs(slopes[x]) / largest(slopes) for slopes in by["direct"].values()) for x in paths}
    without = {x for x in paths if any(fnmatch(x, pattern) for pattern in NO_EFFECT[case])}
    assert {x for x in paths if share[x] < 10 * ROUND_OFF} == without


def test_both_methods_agree_on_the_response_that_a_number_matters_most_to(compared):
    """Without any allowance for round-off of the others."""
    *_, paths, by = compared
    for x in paths:
        response = max(by["direct"], key=lambda name: abs(by["direct"][name][x]) / largest(by["direct"][name]))
        exact = by["direct"][response][x]
        if abs(exact) > 10 * ROUND_OFF * largest(by["direct"][response]):
            assert by["adjoint"][response][x] == pytest.approx(exact, rel=AGREEMENT), (x, response)


def kinds_in(record: object) -> set[str]:
    """Names of all kinds of curves in a record."""
    if isinstance(record, Description):
        own = {record.kind} if isinstance(record, Curve) else set()
        return own.union(*(kinds_in(value) for _, value in record))
    return set().union(*(kinds_in(value) for value in record)) if isinstance(record, tuple) else set()


def test_the_scenes_contain_every_kind_that_there_is(folder):
    """A new kind belongs into one of the scenes, and is then differentiated by every number it has."""
    scenes = [make(folder) for make in SCENES.values()]
    for group, kinds in kinds_of(2).items():
        shipped = {kind for kind, described in kinds.items() if described.__module__.startswith("toolkit.")} - {Ground.kind}
        assert shipped == {item.kind for scene in scenes for item in getattr(scene, group).values()}, group
    components = [item for scene in scenes for group in (scene.joints, scene.loads) for item in group.values()]
    assert built_in_curves() == set().union(*map(kinds_in, components))


def optional_numbers(scene: Scene) -> set[tuple[str, str]]:
    """Kind and field of all numbers of a scene's components, None where one is left out."""
    items = [item for group in (scene.bodies, scene.joints, scene.loads) for item in group.values()]
    return {(item.kind, name) for item in items for name, value in item if isinstance(value, (float, tuple))}


def test_the_scenes_set_every_optional_number_of_every_kind(folder):
    """A length that is left out follows the points; where it is given it is a number of its own, and it is given somewhere."""
    given = set().union(*(optional_numbers(make(folder)) for make in SCENES.values()))
    left_out = {
        (kind, name)
        for kinds in kinds_of(2).values()
        for kind, described in kinds.items()
        if described.__module__.startswith("toolkit.")
        for name, field in described.model_fields.items()
        if field.default is None
    }
    assert left_out
    settings = {("flexible", "geometric_error"), ("flexible", "modes_per_frame")}  # no numbers of the body
    assert left_out - settings <= given


@pytest.mark.parametrize("path", ["solver.step", "solver.baumgarte.damping", "solver.baumgarte.stiffness", "solver.end_time"])
def test_solver_options_are_no_design_variables_and_the_refusal_says_why(folder, path):
    with pytest.raises(InputError, match=rf"'{path}' cannot be a design variable: step, stabilisation \(Baumgarte\)"):
        rods(folder).design_variables([path])


def test_numbers_of_a_response_are_no_design_variables_and_the_refusal_says_why(folder):
    with pytest.raises(InputError, match=r"'responses.slot.time' cannot be a design variable: numbers of a response"):
        rods(folder).design_variables(["responses.slot.time"])


def test_no_gradient_is_undefined(compared):
    assert all(np.isfinite(slope) for each in compared[-1].values() for slopes in each.values() for slope in slopes.values())
