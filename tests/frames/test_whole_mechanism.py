"""The judge that solves the whole mechanism with one frame to every element."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

import ffrf
from tests.frames.test_cut_bodies import EI, STRAIGHT, cantilever, in_space
from tests.frames.test_cut_wing import WING, wing
from toolkit.analyses.sensitivity.certificate.whole_mechanism import compare_mechanism
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.command_line.cli import app


def test_exact_gradients_of_the_mechanism_are_its_central_differences_and_not_those_of_one_frame():
    solution = solve(prepare(wing(1)), "static")
    found = compare_mechanism(solution, ["t_w", "x_A", "bodies.skin.chord"])
    assert found is not None
    assert found.elements == {"skin": 30}
    exact = found.corotational
    assert exact is not None
    for response, quotients in found.quotients.items():
        assert set(quotients) == {"t_w", "x_A"}  # the chord moves by preprocessing alone
        for name, value in quotients.items():
            size = max(abs(each) for each in exact.gradients[response].values())
            assert value == pytest.approx(
                exact.gradients[response][name], rel=1e-5, abs=1e-6 * size
            )  # truncation of the quotient
    assert ("shape_rmse", "x_A") in found.wrong_signs()
    assert ("shape_rmse", "t_w") not in found.wrong_signs()
    assert "shape_rmse by x_A" in found.cautions()[0].text
    assert 0.03 < found.distances["skin"] < 0.04  # 3.6 %, measured apart by parts that are tied to one end


def test_the_command_tells_of_the_mechanism():
    done = CliRunner().invoke(
        app,
        [
            "check-deformation",
            str(WING / "scene.toml"),
            "--static",
            "--json",
            "--variables",
            "x_A",
            "--set",
            "bodies.skin.frames=8",
        ],
    )
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert found["deformation"] == {}  # parts are no bodies of the scene
    assert found["mechanism"]["distances"]["skin"] < 1e-3
    slopes = found["mechanism"]["gradients"]["shape_rmse"]["x_A"]
    assert slopes["value"] == pytest.approx(slopes["corotational"], rel=0.05)
    assert slopes["central_difference"] == pytest.approx(slopes["corotational"], rel=1e-5)


def test_a_mechanism_that_cannot_be_solved_is_a_doubt(tmp_path):
    """Compression that one linear body bears at any size buckles elements that turn."""
    solution = solve(prepare(cantilever(tmp_path, STRAIGHT[::2], 1, in_space((-5 * EI, 0.0)))), "static")
    found = compare_mechanism(solution, [])
    assert found is not None
    assert found.cautions()[0].doubt
    assert "with a frame to every element the scene cannot be solved" in found.cautions()[0].text


def test_solids_have_no_such_mechanism():
    scene = ffrf.read_scene(WING.parent / "bracket" / "scene.toml")
    assert compare_mechanism(solve(prepare(scene), "static"), []) is None
