"""Every response in the plane and in space: its partial derivatives, its gradients by every method, its units, and its schema."""

from __future__ import annotations

from typing import Any

import pytest

from tests.models.directions import along, derivative_along, direction
from tests.models.response_cases import CASES, PLANE, SPACE, TIP, plane, space, write_models
from tests.scene_file.test_scene_units import differences
from tests.scene_file.test_schemas import complaints
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.api.check import check_response
from toolkit.foundation.errors import ConformanceError
from toolkit.responses.catalogue import Response
from toolkit.responses.marker_formula import Motion
from toolkit.responses.point_motion import PointVector
from toolkit.responses.vibration import OfVibration

AGREEMENT = 1e-10
"""Of the response's largest derivative: all methods are exact for the discrete equations, the rest is round-off."""
IN_SPACE = (
    "velocity",
    "size of acceleration",
    "angular velocity",
    "size of angular velocity",
    "angle",
    "power of a torque",
    "centre of one",
)
"""Those whose formulas there are other ones; a check in space takes some seconds."""
ELSEWHERE = {"shape-mse", "shape-rms", "shape-max", "load-margin", "least-frequency"}
"""Kinds that need a body with a target shape, which the wing of `test_responses` has, or that snap (`test_load_margin`), or nearly do."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    directory = tmp_path_factory.mktemp("models")
    write_models(directory)
    return directory


@pytest.mark.parametrize("name", [name for name, response in PLANE.items() if not isinstance(response, OfVibration)])
def test_partial_derivatives_in_the_plane_are_complex_steps(name, folder):
    check_response(PLANE[name], plane(folder))


@pytest.mark.parametrize("name", IN_SPACE)
def test_partial_derivatives_in_space_are_complex_steps(name, folder):
    check_response(SPACE[name], space(folder))


@pytest.mark.parametrize("kind", ["transient", "static"])
@pytest.mark.parametrize("where", CASES)
def test_direct_adjoint_and_complex_step_agree(where, kind, folder):
    make, responses = CASES[where]
    scene = make(folder).model_copy(update={"responses": responses})
    paths = scene.available_paths()
    by = {method: gradients_by(method, scene, paths, kind) for method in ("direct", "adjoint")}
    factors = direction(paths)
    judge = derivative_along(scene, factors, kind, by["direct"].solution)
    left_out = {name for name, each in responses.items() if (each.needs_rest if kind == "transient" else each.needs_motion)}
    assert set(by["direct"].values) == set(judge) == set(responses) - left_out
    for name, exact in by["direct"].gradients.items():
        largest = max(map(abs, exact.values()))
        assert by["adjoint"].gradients[name] == pytest.approx(exact, rel=0, abs=AGREEMENT * largest), name
        assert along(exact, factors) == pytest.approx(judge[name], rel=0, abs=AGREEMENT * largest), name
        assert largest > 0 or (kind == "static" and by["direct"].values[name] == 0), name  # an energy of motion at rest


def test_the_lists_contain_every_kind_that_there_is():
    shipped = {kind for kind, described in Response.kinds.items() if described.__module__.startswith("toolkit.")}
    for listed in (PLANE, SPACE):
        assert shipped - ELSEWHERE == {response.kind for response in listed.values()}


@pytest.mark.parametrize("where", CASES)
def test_units_change_no_response(where, folder, tmp_path):
    make, responses = CASES[where]
    scene = make(folder).model_copy(update={"responses": responses})
    some = ["points.A.x", "loads.motor.torque" if where == "plane" else "loads.motor.torque.0", "bodies.crank.density"]
    values, slopes = differences(scene, some, tmp_path)
    # both runs round differently; accelerations divide that by the step twice
    assert values < 1e-8
    assert slopes < 1e-7


@pytest.mark.parametrize("where", CASES)
def test_every_response_meets_the_schema_as_it_stands_in_a_file(where):
    table = {name: written(response) for name, response in CASES[where][1].items()}
    assert complaints({"units": "m-kg-s", "bodies": {}, "responses": table}, "scene") == []


def written(response: Any) -> dict[str, Any]:
    """A response as it stands in a file."""
    given = {key: value for key, value in dict(response).items() if value is not None}
    return {"type": response.kind, **{key: _plain(value) for key, value in given.items()}}


def _plain(value: Any) -> Any:
    if isinstance(value, Response):
        return written(value)
    return [_plain(each) for each in value] if isinstance(value, tuple) else value


def test_a_derivative_that_is_wrong_is_named(folder):
    class Blind(PointVector):
        """A velocity whose formula forgets a derivative."""

        kind = "half-a-velocity-of-a-test"

        def formula(self, *motions: Motion):
            """No derivative."""
            return motions[0].rate[:2], [Motion(y=0 * motions[0].y[None] + [[0.0], [0.0]])]

    with pytest.raises(ConformanceError, match=r"d half-a-velocity-of-a-test / d q is wrong at \(t = .*a complex step gives"):
        check_response(Blind(**TIP), plane(folder))


@pytest.mark.parametrize("where", CASES)
def test_a_file_says_the_same_as_python(where):
    for response in CASES[where][1].values():
        table = written(response)
        assert Response.kinds[table.pop("type")].model_validate(table) == response
