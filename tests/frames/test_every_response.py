"""Responses of every kind of a body with two frames: gradients by all numbers of the scene are complex steps, or they are refused."""

from __future__ import annotations

from typing import Any

import pytest

import ffrf
from tests.frames.test_every_joint import AGREEMENT, disagreement
from tests.models.response_cases import CASES, TIP, write_models
from toolkit.foundation.errors import InputError
from toolkit.responses.point_motion import Deflection
from toolkit.responses.response import Response
from toolkit.responses.vibration import DampingRatio, Frequency
from toolkit.scene.scene import Scene


def cut(folder: Any, where: str, responses: dict[str, Response]) -> Scene:
    """The scene of all responses, whose flexible body is cut in the middle of its elements."""
    write_models(folder)
    scene = CASES[where][0](folder)
    strip = scene.bodies["strip"].model_copy(update={"frames": 2})
    options = scene.solver.model_copy(update={"end_time": scene.solver.step})
    return scene.model_copy(update={"bodies": {**scene.bodies, "strip": strip}, "responses": responses, "solver": options})


@pytest.mark.parametrize(("where", "kind"), [("plane", "transient"), ("space", "transient"), ("plane", "static")])
def test_gradients_are_complex_steps(tmp_path, where, kind):
    """Of a motion, and of the vibrations of an equilibrium."""
    responses = {
        name: each
        for name, each in CASES[where][1].items()
        if not isinstance(each, Deflection) and isinstance(each, Frequency | DampingRatio) == (kind == "static")
    }
    found = disagreement(cut(tmp_path, where, responses), kind, ("direct", "adjoint"))
    assert found.keys() == responses.keys()
    assert {name: gap for name, gap in found.items() if not gap < AGREEMENT} == {}


def test_the_deflection_in_the_one_frame_is_refused_with_what_to_ask_for(tmp_path):
    scene = cut(tmp_path, "plane", {"tip": Deflection(**TIP)})
    with pytest.raises(InputError, match=r"no frame is that of the whole body\. Ask for the displacement of the point"):
        ffrf.compile(scene).simulate()
